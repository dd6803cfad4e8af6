// `mirror` of a unit: polled values become variables of the unit, one after another from a first item on.
#include <algorithm>
#include <tuple>
#include <utility>

#include "devices/binding.hpp"
#include "servers/interpretation.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

enum class MirrorOrder : std::uint8_t { project, address, name };

/// A polled variable with its place.
struct MirroredVariable {
    std::size_t line = 0;
    const Device* device = nullptr;
    Variable* variable = nullptr;
};

bool is_boolean(const MirroredVariable& polled) {
    return polled.variable->type == DataType::boolean;
}

void sort(std::vector<MirroredVariable>& all, MirrorOrder order) {
    if (order == MirrorOrder::name)
        std::ranges::stable_sort(all, {}, [](const MirroredVariable& p) { return p.variable->name; });
    if (order == MirrorOrder::address)
        std::ranges::stable_sort(all, {}, [](const MirroredVariable& p) {
            return std::tuple(p.line, p.device->address.value, p.variable->area, p.variable->start(),
                              p.variable->bit.value_or(0));
        });
}

/// One `mirror` of a unit.
class Mirror {
public:
    Mirror(Interpretation& state, Reader& reader, ServerUnit& unit, const Device& shape)
        : state_(state), reader_(reader), unit_(unit), shape_(shape) {}

    [[nodiscard]] wire::Area area() const { return area_; }

    void read_keys() {
        area_ = reader_.choice<wire::Area>("area").value_or(wire::Area::holding_register);
        first_ = static_cast<unsigned>(reader_.integer("first").value_or(0));
        order_ = reader_.choice<MirrorOrder>("order").value_or(MirrorOrder::project);
        writable_ = reader_.boolean("writable").value_or(false);
        if (writable_ && area_ != wire::Area::holding_register && area_ != wire::Area::coil) {
            reader_.report_without_effect("writable", "area: " + std::string(name(area_)));
            writable_ = false;
        }
        read_devices();
    }

    /// @param bits_elsewhere  another mirror of the unit has the bools
    void fill(bool bits_elsewhere) {
        auto all = selected(bits_elsewhere);
        if (all.empty()) return reader_.report(Rule::mirror_empty, "area");
        sort(all, order_);
        unsigned next = first_;
        for (const auto& polled : all) next += items_of(polled);
        if (next > kItemsPerArea)
            return reader_.report(
                Rule::mirror_beyond_end, "first", {},
                {{"items", std::to_string(next - first_)}, {"first", std::to_string(first_)}});
        const ItemRange range{static_cast<std::uint16_t>(first_), static_cast<std::uint16_t>(next - 1)};
        if (overlaps(range)) return;
        auto& offered = unit_.offered[static_cast<std::size_t>(area_)];
        offered = united(offered, {range});
        next = first_;
        for (const auto& polled : all) {
            add(polled, next);
            next += items_of(polled);
        }
    }

private:
    void read_devices() {
        const Node* const list = reader_.list("devices");
        if (list == nullptr) return;
        std::vector<std::string_view> known;
        for (const auto& line : state_.project.lines)
            for (const auto& device : line.devices) known.push_back(device.name);
        for (std::size_t i = 0; i < list->items.size(); ++i) {
            const auto& item = list->items[i];
            devices_.push_back(item.text);
            if (item.kind == Node::Kind::scalar && std::ranges::find(known, item.text) != known.end())
                continue;
            const auto path = reader_.path_of("devices") + "[" + std::to_string(i) + "]";
            const auto guess = known.empty() ? std::string_view("–") : nearest(item.text, known);
            state_.findings.add(Rule::source_unknown, item.location, path, item.text, {},
                                {{"kind", "device"}, {"nearest", std::string(guess)}});
        }
    }

    [[nodiscard]] std::vector<MirroredVariable> selected(bool bits_elsewhere) {
        std::vector<MirroredVariable> all;
        for (std::size_t line = 0; line < state_.project.lines.size(); ++line)
            for (auto& device : state_.project.lines[line].devices) {
                if (reader_.given("devices") && std::ranges::find(devices_, device.name) == devices_.end())
                    continue;
                for (auto& variable : device.variables) {
                    const MirroredVariable polled{line, &device, &variable};
                    if (!variable.used || !variable.read || variable.name.empty()) continue;
                    if (is_boolean(polled) ? !wire::is_bit_area(area_) && bits_elsewhere
                                           : wire::is_bit_area(area_))
                        continue;
                    all.push_back(polled);
                }
            }
        return all;
    }

    [[nodiscard]] unsigned items_of(const MirroredVariable& polled) const {
        return wire::is_bit_area(area_) ? 1U : polled.variable->registers;
    }

    /// Reports the first item of the unit itself, or of another mirror, in the range.
    bool overlaps(const ItemRange& range) {
        const auto area = static_cast<std::size_t>(area_);
        const auto refuse = [&](const ItemRange& own, const std::string& owner) {
            reader_.report(Rule::mirror_overlap, "first", {},
                           {{"area", std::string(name(area_))},
                            {"first", std::to_string(range.first)},
                            {"last", std::to_string(range.last)},
                            {"own_first", std::to_string(own.first)},
                            {"own_last", std::to_string(own.last)},
                            {"owner", owner}});
            return true;
        };
        for (const auto& variable : unit_.variables) {
            if (!variable.used || variable.name.empty() || variable.area != area_) continue;
            const ItemRange own{variable.start(),
                                static_cast<std::uint16_t>(variable.start() + variable.items() - 1)};
            if (overlap(own, range)) return refuse(own, variable.name);
        }
        for (const auto& own : unit_.offered[area])
            if (overlap(own, range)) return refuse(own, "banks");
        if (!wire::is_bit_area(area_) || !unit_.overlays[area]) return false;
        return refuse(unit_.offered[area].empty() ? ItemRange{} : unit_.offered[area].front(), "overlay");
    }

    void add(const MirroredVariable& polled, unsigned at) {
        const Variable& from = *polled.variable;
        Variable variable;
        variable.name = from.name;
        variable.location = reader_.node().location;
        variable.type = from.type;
        variable.area = area_;
        variable.registers = from.registers;
        variable.order = shape_.order;
        variable.scale = from.scale;
        variable.offset = from.offset;
        variable.enumeration = from.enumeration;
        variable.bits = from.bits;
        variable.unit = from.unit;
        variable.comment = from.comment;
        variable.register_number = static_cast<std::uint16_t>(at);
        if (is_boolean(polled)) variable.bit = std::uint8_t{0};
        if (wire::is_bit_area(area_)) {
            constexpr unsigned kBits = 16;
            variable.register_number = static_cast<std::uint16_t>(at / kBits);
            variable.bit = static_cast<std::uint8_t>(at % kBits);
        }
        Binding binding{.variable = unit_.variables.size(), .location = variable.location};
        binding.source = VariableSource{from.name};
        binding.max_age = stale_after(from.period);
        if (writable_ && from.write) {
            binding.sink = VariableSource{from.name};
            polled.variable->written_by_clients = true;
        }
        unit_.variables.push_back(std::move(variable));
        unit_.bindings.push_back(std::move(binding));
    }

    Interpretation& state_;
    Reader& reader_;
    ServerUnit& unit_;
    const Device& shape_;
    wire::Area area_ = wire::Area::holding_register;
    unsigned first_ = 0;
    MirrorOrder order_ = MirrorOrder::project;
    bool writable_ = false;
    std::vector<std::string> devices_;
};

}  // namespace

void interpret_mirrors(Interpretation& state, Reader& reader, ServerUnit& unit, const Device& shape) {
    const Node* const given = reader.value("mirror");
    if (given == nullptr) return;
    std::vector<std::pair<const Node*, std::string>> nodes;
    if (given->kind == Node::Kind::list) {
        for (std::size_t i = 0; i < given->items.size(); ++i) {
            const auto path = reader.path_of("mirror") + "[" + std::to_string(i) + "]";
            if (is_mapping(state, given->items[i], path)) nodes.emplace_back(&given->items[i], path);
        }
    } else if (const Node* const mapping = reader.mapping("mirror")) {
        nodes.emplace_back(mapping, reader.path_of("mirror"));
    }
    std::vector<Reader> readers;
    for (const auto& [node, path] : nodes)
        readers.emplace_back(state.findings, *node, path, Object::mirror, state.context);
    std::vector<Mirror> mirrors;
    for (auto& own : readers) mirrors.emplace_back(state, own, unit, shape).read_keys();
    const bool bits =
        std::ranges::any_of(mirrors, [](const Mirror& mirror) { return wire::is_bit_area(mirror.area()); });
    for (auto& mirror : mirrors) mirror.fill(bits);
}

}  // namespace takt::model
