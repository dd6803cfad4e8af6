// Classic grouping (docs/specification.md, section 4). Two passes over the variables of a device, each sorted
// by function, register and bit. The read pass numbers the variables; the write pass continues the numbers. A
// pass is cut where boundary() or the item limit requires it, or everywhere without grouping. A write group
// with the same first variable and the same number of members as a read group joins it: the numbers of both
// are consecutive, so the members are equal.
#include "requests/grouping.hpp"

#include <algorithm>
#include <array>
#include <compare>
#include <cstdint>
#include <iterator>
#include <optional>
#include <utility>

#include "requests/boundary.hpp"

namespace takt::plan {
namespace {

using model::Strategy;
using model::Variable;
using wire::Function;

class DevicePlanner {
public:
    DevicePlanner(const model::Project& project, const model::Line& line, const model::Device& device,
                  Strategy strategy)
        : project_(project), line_(line), device_(device), strategy_(strategy) {}

    std::vector<Request> requests();

private:
    using Indices = std::vector<std::size_t>;

    [[nodiscard]] bool takes_part(Pass pass, const Variable& variable) const;
    [[nodiscard]] Indices sorted(Pass pass) const;
    void number(const Indices& order);
    [[nodiscard]] std::vector<Request> groups(Pass pass, const Indices& order);
    /// The reason why the request with `items` items ends after order[at - 1]; nothing if it continues.
    [[nodiscard]] std::optional<Reason> end(Pass pass, const Indices& order, std::size_t at,
                                            std::size_t items);
    [[nodiscard]] Request request(Pass pass, std::size_t first) const;
    void add(Request& request, std::size_t index) const;
    [[nodiscard]] std::vector<Request> merged(std::vector<Request> reads, std::vector<Request> writes) const;
    const ItemLimit& limit(Function function);

    const model::Project& project_;
    const model::Line& line_;
    const model::Device& device_;
    Strategy strategy_;
    std::vector<std::size_t> numbers_;
    std::size_t last_number_ = 0;
    std::array<std::optional<ItemLimit>, 0x11> limits_;
};

std::vector<Request> DevicePlanner::requests() {
    numbers_.assign(device_.variables.size(), 0);
    const Indices read_order = sorted(Pass::read);
    const Indices write_order = sorted(Pass::write);
    number(read_order);
    number(write_order);
    auto reads = groups(Pass::read, read_order);
    return merged(std::move(reads), groups(Pass::write, write_order));
}

bool DevicePlanner::takes_part(Pass pass, const Variable& variable) const {
    return pass == Pass::read ? is_read(variable) : is_written(variable, strategy_);
}

DevicePlanner::Indices DevicePlanner::sorted(Pass pass) const {
    struct SortKey {
        std::uint32_t key;
        std::size_t index;
        auto operator<=>(const SortKey&) const = default;  // what is equal keeps the order of the file
    };
    std::vector<SortKey> keys;
    for (std::size_t i = 0; i < device_.variables.size(); ++i) {
        const Variable& v = device_.variables[i];
        if (!takes_part(pass, v)) continue;
        const auto function = static_cast<std::uint32_t>(*function_in(pass, v));
        const std::uint32_t key = function << 20 | std::uint32_t{v.register_number} << 4 | v.bit.value_or(0);
        keys.push_back({key, i});
    }
    std::ranges::sort(keys);
    Indices order(keys.size());
    std::ranges::transform(keys, order.begin(), &SortKey::index);
    return order;
}

void DevicePlanner::number(const Indices& order) {
    for (const std::size_t index : order)
        if (numbers_[index] == 0) numbers_[index] = ++last_number_;
}

std::vector<Request> DevicePlanner::groups(Pass pass, const Indices& order) {
    std::vector<Request> groups;
    bool open = false;
    std::size_t items = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
        if (open) {
            add(groups.back(), order[i]);
        } else {
            groups.push_back(request(pass, order[i]));
            items = 0;
        }
        items += device_.variables[order[i]].items();
        auto why = end(pass, order, i + 1, items);
        open = !why;
        if (why) groups.back().why = *std::move(why);
    }
    return groups;
}

std::optional<Reason> DevicePlanner::end(Pass pass, const Indices& order, std::size_t at, std::size_t items) {
    if (strategy_ == Strategy::single) return Reason{"plan.grouping_off", {}};
    const Variable& previous = device_.variables[order[at - 1]];
    if (at == order.size()) return Reason{"plan.last", {{"variable", previous.name}}};
    const Variable& next = device_.variables[order[at]];
    const bool adjoin = numbers_[order[at]] == numbers_[order[at - 1]] + 1;
    if (auto why = boundary(pass, {previous, next, adjoin})) return why;
    const ItemLimit& most = limit(*function_in(pass, next));
    const std::size_t size = items + next.items();
    if (size > most.items()) return most.reason(size, next);
    return std::nullopt;
}

Request DevicePlanner::request(Pass pass, std::size_t first) const {
    const Variable& v = device_.variables[first];
    Request made;
    made.variables.push_back(first);
    made.start = v.start();
    made.quantity = v.items();
    made.status = v.status;
    if (pass == Pass::read) {
        made.read = v.read;
        made.period = v.period;
        made.deadline = due_within(v);
        made.read_trigger = v.read_trigger;
    } else {
        made.write = v.write;
        made.write_trigger = v.write_trigger;
        made.write_on_change = v.write_on_change;
    }
    return made;
}

void DevicePlanner::add(Request& request, std::size_t index) const {
    const Variable& v = device_.variables[index];
    request.variables.push_back(index);
    if (request.read) request.deadline = sooner(request.deadline, due_within(v));
    const bool same_register = v.type == DataType::boolean && !wire::is_bit_area(v.area);
    if (!same_register) request.quantity = static_cast<std::uint16_t>(request.quantity + v.items());
}

std::vector<Request> DevicePlanner::merged(std::vector<Request> reads, std::vector<Request> writes) const {
    std::vector<Request*> read_of_first(device_.variables.size(), nullptr);
    for (Request& read : reads) read_of_first[read.variables.front()] = &read;
    std::vector<Request> unmerged;
    for (Request& write : writes) {
        Request* read = read_of_first[write.variables.front()];
        if (read && read->variables.size() == write.variables.size()) {
            read->write = write.write;
            read->write_trigger = write.write_trigger;
            read->write_on_change = write.write_on_change;
        } else {
            unmerged.push_back(std::move(write));
        }
    }
    std::move(unmerged.begin(), unmerged.end(), std::back_inserter(reads));
    return reads;
}

const ItemLimit& DevicePlanner::limit(Function function) {
    auto& known = limits_[static_cast<std::size_t>(function)];
    if (!known) known.emplace(project_, line_, device_, function);
    return *known;
}

}  // namespace

bool is_read(const Variable& variable) {
    return variable.used && variable.read;
}

bool is_written(const Variable& variable, Strategy strategy) {
    if (!variable.used || !variable.write) return false;
    if (strategy == Strategy::single) return true;  // also for commands alone
    // A bool in a register is not an item of 0x06 and 0x10: classic leaves it to others.
    const bool bit_of_register = variable.type == DataType::boolean && !wire::is_bit_area(variable.area);
    if (strategy == Strategy::classic && bit_of_register) return false;
    return variable.write_on_change || variable.write_trigger;
}

std::optional<Duration> sooner(const std::optional<Duration>& a, const std::optional<Duration>& b) {
    if (!a || !b) return a ? a : b;
    return std::min(*a, *b);
}

std::optional<Duration> due_within(const Variable& variable) {
    if (variable.deadline || variable.period == Duration::zero()) return variable.deadline;
    return variable.period;
}

std::vector<Request> device_requests(const model::Project& project, const model::Line& line,
                                     const model::Device& device, Strategy strategy) {
    std::vector<Request> requests = DevicePlanner(project, line, device, strategy).requests();
    for (std::size_t i = 0; i < requests.size(); ++i) requests[i].stream = i;
    return requests;
}

}  // namespace takt::plan
