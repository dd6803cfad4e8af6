#include "check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace corpus {
namespace {

using namespace takt;

bool reads(const plan::Request& request, const Value& value) {
    return request.read && request.period && static_cast<int>(*request.read) == value.function &&
           request.start <= value.start && value.end() <= std::uint32_t{request.start} + request.quantity;
}

/// The longest interval between two reads of a value by these requests.
Duration longest_wait(const std::vector<const plan::Request*>& requests) {
    std::int64_t all = 1;
    for (const auto* request : requests) all = std::lcm(all, request->period->count());
    std::vector<std::int64_t> times;
    for (const auto* request : requests)
        for (std::int64_t t = request->phase.count(); t < all; t += request->period->count())
            times.push_back(t);
    std::ranges::sort(times);
    std::int64_t longest = times.front() + all - times.back();
    for (std::size_t i = 1; i < times.size(); ++i) longest = std::max(longest, times[i] - times[i - 1]);
    return Duration(longest);
}

std::string name_of(const Value& value) {
    return "function " + std::to_string(value.function) + " at " + std::to_string(value.start) + ", " +
           std::to_string(value.items) + " items";
}

std::string value_mistake(const Value& value, std::size_t index, const plan::LinePlan& plan,
                          const model::Variable& variable) {
    std::vector<const plan::Request*> readers;
    std::size_t writers = 0;
    for (const auto& request : plan.requests) {
        if (std::ranges::find(request.variables, index) == request.variables.end()) continue;
        if (reads(request, value)) readers.push_back(&request);
        writers += request.write && request.write_on_change ? 1U : 0U;
    }
    if (readers.empty()) return name_of(value) + " is not read";
    if (longest_wait(readers) > variable.period)
        return name_of(value) + " is read more rarely than its period";
    if (value.written && writers != 1) return name_of(value) + " is written by " + std::to_string(writers);
    return {};
}

/// Whether every item of a request is used.
bool wants_all(const Map& map, const plan::Request& request, bool written) {
    std::vector<bool> wanted(65536 + 2000);
    for (const auto& value : map.values)
        if (value.is_bit() == (static_cast<int>(request.write.value_or(*request.read)) == 0x0F ||
                               (request.read && static_cast<int>(*request.read) <= 2)) &&
            (!written || value.written) && (written || static_cast<int>(*request.read) == value.function))
            std::fill(wanted.begin() + value.start, wanted.begin() + value.end(), true);
    return std::all_of(wanted.begin() + request.start, wanted.begin() + request.start + request.quantity,
                       [](bool is) { return is; });
}

std::string request_mistake(const Map& map, const Rules& rules, const plan::Request& request) {
    const std::string name =
        "request at " + std::to_string(request.start) + ", " + std::to_string(request.quantity) + " items";
    if (request.quantity == 0 || request.quantity > rules.limit) return name + ": beyond the limit";
    if (std::uint32_t{request.start} + request.quantity > 65536) return name + ": beyond 65535";
    if (request.write && !wants_all(map, request, true))
        return name + ": writes items that are not requested";
    if (!request.read) return {};
    if (!rules.gaps && !wants_all(map, request, false)) return name + ": reads items that are not requested";
    const Seconds said = static_cast<Seconds>(request.bus_time.count()) / 1e9L;
    if (std::abs(said - rules.cost(request.quantity)) > 1e-9L + 1e-12L)
        return name + ": its bus time is wrong";
    return {};
}

}  // namespace

Checked check(const Map& map, const Bus& bus, bool all_gaps, const model::Project& project,
              const plan::LinePlan& plan) {
    Checked checked;
    const auto note = [&checked](const std::string& mistake) {
        if (checked.mistake.empty()) checked.mistake = mistake;
    };
    for (const auto& request : plan.requests) {
        const auto rules =
            rules_of(map, static_cast<int>(request.read.value_or(wire::Function::read_holding_registers)),
                     bus, all_gaps);
        note(request_mistake(map, rules, request));
        if (!request.read || !request.period) continue;
        checked.round += rules.cost(request.quantity);
        checked.rate += rules.cost(request.quantity) / (static_cast<Seconds>(request.period->count()) / 1e9L);
    }
    const auto& variables = project.lines[0].devices[0].variables;
    for (std::size_t i = 0; i < map.values.size(); ++i)
        note(value_mistake(map.values[i], i, plan, variables[i]));
    return checked;
}

}  // namespace corpus
