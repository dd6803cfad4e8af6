#include <algorithm>
#include <set>
#include <utility>

#include "devices/addressing.hpp"
#include "servers/interpretation.hpp"
#include "servers/unit_checks.hpp"
#include "takt/model/item_ranges.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kMostQueued = 31;

/// Calls `each` with a reader for every entry of a list of mappings.
template <class Each>
void for_each_entry(Interpretation& state, Reader& unit, std::string_view key, Object object,
                    const Each& each) {
    const Node* const list = unit.list(key);
    if (list == nullptr) return;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = unit.path_of(key) + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        Reader reader(state.findings, item, path, object, state.context);
        each(reader);
    }
}

/// A number that identifies an entry; it must be unique in its list.
std::optional<std::uint16_t> read_unit_number(Reader& reader, std::string_view key,
                                              std::set<std::uint16_t>& taken) {
    const auto read = reader.integer(key);
    if (!read) return std::nullopt;
    const auto number = static_cast<std::uint16_t>(*read);
    if (taken.insert(number).second) return number;
    reader.report(Rule::number_twice, key, {}, {{"key", std::string(key)}});
    return std::nullopt;
}

void read_overlay(Reader& reader, wire::Area area, ServerUnit& unit) {
    const auto over = reader.word("overlay");
    const auto first = reader.integer("overlay_register").value_or(0);
    if (!over) {
        if (reader.given("overlay_register") && !reader.given("overlay"))
            reader.report_without_effect("overlay_register", "overlay: none");
        return;
    }
    if (!wire::is_bit_area(area)) {
        reader.report(Rule::bank_overlay_bits, "overlay");
        return;
    }
    unit.overlays[static_cast<std::size_t>(area)] = BitsOverRegisters{
        *over == kRegisterAreas[0] ? wire::Area::input_register : wire::Area::holding_register,
        static_cast<std::uint16_t>(first), reader.value("overlay")->location};
}

/// `retain: true` means the whole bank.
std::vector<ItemRange> read_retained(Interpretation& state, Reader& reader,
                                     const std::vector<ItemRange>& items) {
    const Node* const given = reader.node().find("retain");
    const bool plain = given != nullptr && given->kind == Node::Kind::scalar && !given->quoted;
    if (plain && given->text == "true") return items;
    if (plain && given->text == "false") return {};
    return read_item_ranges(state, reader, "retain");
}

void read_bank(Interpretation& state, Reader& reader, ServerUnit& unit, std::array<bool, 4>& seen) {
    const auto area = reader.choice<wire::Area>("area");
    auto items = read_item_ranges(state, reader, "items");
    auto read_only = read_item_ranges(state, reader, "read_only");
    auto retained = read_retained(state, reader, items);
    if (!area) return;
    const auto index = static_cast<std::size_t>(*area);
    if (std::exchange(seen[index], true)) {
        reader.report(Rule::bank_twice, "area", {}, {{"area", std::string(name(*area))}});
        return;
    }
    read_overlay(reader, *area, unit);
    const auto check_covered = [&](const std::vector<ItemRange>& ranges, Rule rule, std::string_view key) {
        for (const auto& range : ranges)
            if (!items.empty() && !holds(items, range))
                reader.report(rule, key, to_text(items),
                              {{"area", std::string(name(*area))},
                               {"first", std::to_string(range.first)},
                               {"last", std::to_string(range.last)}});
    };
    check_covered(retained, Rule::bank_retain_outside, "retain");
    check_covered(read_only, Rule::bank_read_only_outside, "read_only");
    unit.retained[index] = std::move(retained);
    unit.offered[index] = std::move(items);
    unit.read_only[index] = std::move(read_only);
}

void read_banks(Interpretation& state, Reader& reader, ServerUnit& unit) {
    std::array<bool, 4> seen{};
    for_each_entry(state, reader, "banks", Object::bank,
                   [&](Reader& bank) { read_bank(state, bank, unit, seen); });
    for_each_entry(state, reader, "limits", Object::limit, [&](Reader& limit) {
        RegisterLimits limits;
        limits.registers = read_item_ranges(state, limit, "registers");
        const auto least = limit.integer("least");
        const auto greatest = limit.integer("greatest");
        if (!least || !greatest) return;
        const std::int64_t most = *least < 0 ? 32767 : 65535;
        if (*greatest < *least || *greatest > most) {
            limit.report(Rule::limits_reversed, "greatest",
                         std::to_string(*least) + ".." + std::to_string(most),
                         {{"least", std::to_string(*least)}});
            return;
        }
        limits.least = static_cast<std::int32_t>(*least);
        limits.greatest = static_cast<std::int32_t>(*greatest);
        limits.location = limit.node().location;
        unit.limits.push_back(std::move(limits));
    });
}

void read_identification(Interpretation& state, Reader& reader, ServerUnit& unit) {
    std::set<std::uint16_t> ids;
    for_each_entry(state, reader, "identification", Object::identification, [&](Reader& object) {
        const auto id = read_unit_number(object, "id", ids);
        const auto text = object.text("text");
        if (id) unit.identification.push_back({static_cast<std::uint8_t>(*id), text.value_or("")});
    });
    std::ranges::sort(unit.identification, {}, &IdentificationText::id);
    unit.server_id = reader.text("server_id").value_or("");
}

void read_files(Interpretation& state, Reader& reader, ServerUnit& unit) {
    std::set<std::uint16_t> numbers;
    for_each_entry(state, reader, "files", Object::file, [&](Reader& file) {
        const auto number = read_unit_number(file, "number", numbers);
        const auto records = file.integer("records");
        const bool read_only = file.boolean("read_only").value_or(false);
        if (number && records)
            unit.files.push_back({*number, static_cast<std::uint16_t>(*records), read_only});
    });
}

/// The values of a FIFO queue: a list of 16-bit numbers.
std::vector<std::uint16_t> read_values(Interpretation& state, Reader& reader) {
    std::vector<std::uint16_t> values;
    const Node* const list = reader.list("values");
    if (list == nullptr) return values;
    if (list->items.size() > kMostQueued)
        reader.report(Rule::fifo_too_long, "values", "0.." + std::to_string(kMostQueued),
                      {{"count", std::to_string(list->items.size())}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto number = parse_integer(item.text);
        if (item.kind == Node::Kind::scalar && number && !number->negative && number->magnitude <= 65535)
            values.push_back(static_cast<std::uint16_t>(number->magnitude));
        else
            state.findings.add(Rule::field_out_of_range, item.location,
                               reader.path_of("values") + "[" + std::to_string(i) + "]", item.text,
                               "0..65535");
    }
    return values;
}

void read_fifos(Interpretation& state, Reader& reader, ServerUnit& unit) {
    std::set<std::uint16_t> addresses;
    for_each_entry(state, reader, "fifos", Object::fifo, [&](Reader& fifo) {
        const auto address = read_unit_number(fifo, "register", addresses);
        auto values = read_values(state, fifo);
        if (address) unit.fifos.push_back({*address, std::move(values)});
    });
}

/// Keys of polling and writing have no effect on a value of the server itself.
void report_unit_keys_without_effect(Interpretation& state, const Node& node, const std::string& path) {
    constexpr std::string_view kKeys[] = {"read",        "write",        "write_on_change", "min_interval",
                                          "burst",       "read_trigger", "write_trigger",   "status",
                                          "period",      "deadline",     "hold_last",       "dead_band",
                                          "write_range", "verify",       "safe_to_repeat"};
    for (const auto key : kKeys)
        if (const Node* const value = node.find(key); value != nullptr && value->kind != Node::Kind::null)
            state.findings.add(Rule::field_without_effect, value->location, path + "." + std::string(key),
                               value->text, {}, {{"key", std::string(key)}, {"condition", "servers"}});
}

void interpret_unit_variables(Interpretation& state, Reader& reader, ServerUnit& unit, const Device& shape) {
    const Node* const list = reader.list("variables");
    if (list == nullptr) return;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("variables") + "[" + std::to_string(i) + "]";
        if (!is_mapping(state, item, path)) continue;
        report_unit_keys_without_effect(state, item, path);
        std::optional<Binding> binding;
        unit.variables.push_back(interpret_served_variable(
            state, shape, item, path,
            [&](Reader& variable, const Variable& read) { binding = read_binding(state, variable, read); }));
        if (binding) {
            binding->variable = unit.variables.size() - 1;
            unit.bindings.push_back(*std::move(binding));
        }
        check_served_variable(state, unit, item, path);
    }
    report_like_references(state);
    check_overlaps(state, unit, reader.path_of("variables"));
}

}  // namespace

ServerUnit interpret_server_unit(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::unit, state.context);
    ServerUnit unit;
    unit.location = node.location;
    if (const auto address = reader.integer("address")) {
        unit.address = UnitId{static_cast<std::uint8_t>(*address)};
        const auto [first, is_new] = state.addresses.try_emplace(unit.address.value, reader, "address");
        if (!is_new)
            reader.report(Rule::address_duplicate, "address", {}, {{"first", state.describe(first->second)}});
    }
    if (!reader.given("banks") && !reader.given("mirror") && !reader.misspelt("banks") &&
        !reader.misspelt("mirror"))
        reader.report(reader.node().find("banks") != nullptr ? Rule::field_empty : Rule::field_missing,
                      "banks", {}, {{"key", "banks"}});
    read_banks(state, reader, unit);
    check_banks(state, unit, path);
    read_identification(state, reader, unit);
    read_files(state, reader, unit);
    read_fifos(state, reader, unit);
    if (const auto coils = reader.integer("exception_coils"))
        unit.exception_coils = static_cast<std::uint16_t>(*coils);
    unit.durability = reader.choice<Durability>("durability").value_or(unit.durability);
    unit.state = reader.text("state").value_or("");
    const bool retains =
        std::ranges::any_of(unit.retained, [](const auto& ranges) { return !ranges.empty(); });
    for (const std::string_view key : {"durability", "state"})
        if (!retains && reader.given(key)) reader.report_without_effect(key, "retain: []");
    unit.may_restart = reader.boolean("restart").value_or(false);
    unit.may_listen_only = reader.boolean("listen_only").value_or(false);
    Device shape;  // the defaults that a variable inherits
    check_notation(reader);
    shape.order = read_byte_order(reader, shape.order, {});
    interpret_unit_variables(state, reader, unit, shape);
    interpret_mirrors(state, reader, unit, shape);
    return unit;
}

}  // namespace takt::model
