// Strategy optimal against a search through all sets of requests, and against what every plan must hold.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "builder.hpp"
#include "cost/exact_time.hpp"

namespace takt::plan {
namespace optimal_properties_test {

using namespace test;
using model::Variable;
using wire::Framing;

std::uint32_t number(std::uint32_t least, std::uint32_t end) {
    return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(least, end));
}

// ---- random projects: one device of few variables, close enough to each other for every rule to decide

Item some_item(int function) {
    const bool bits = function < 3;
    const int place = static_cast<int>(number(0, 60));
    if (bits) return boolean(place / 16, place % 16).read(function);
    static constexpr DataType kTypes[] = {DataType::int16, DataType::float32, DataType::float64,
                                          DataType::string, DataType::boolean};
    const DataType type = kTypes[number(0, std::size(kTypes))];
    Item made = item(type, place, static_cast<int>(number(1, 21))).read(function);
    if (type == DataType::boolean) made.bit = static_cast<std::uint8_t>(number(0, 16));
    return made;
}

std::vector<Item> some_items(std::uint32_t most) {
    std::vector<Item> items;
    const auto count = number(1, most + 1);
    const int functions[] = {static_cast<int>(number(1, 5)), static_cast<int>(number(1, 5))};
    for (std::uint32_t i = 0; i < count; ++i) {
        Item made = some_item(functions[number(0, 4) == 0]);
        if (number(0, 4) == 0) made = made.every(number(0, 2) == 0 ? 0ms : 1000ms);
        if (number(0, 4) == 0) made = made.read_on(number(0, 2));
        if (number(0, 6) == 0) made = made.reports_to(3);
        if (number(0, 6) == 0) made.deadline = 30ms;
        made.used = number(0, 8) != 0;
        items.push_back(made.named("v" + std::to_string(i)));
    }
    return items;
}

void set_gaps(model::Device& device) {
    device.gaps = *rc::gen::element(model::Gaps::never, model::Gaps::learn, model::Gaps::always);
    for (std::size_t area = 0; area < 4; ++area) {
        if (number(0, 4) == 0) device.readable[area] = {{3, 29}, {35, 200}};
        if (number(0, 4) == 0) device.no_read[area] = {{12, 14}, {40, 40}};
    }
}

// All periods are equal. rounds_test.cpp covers several periods.
model::Project some_project(std::uint32_t most) {
    Settings settings{16, *rc::gen::element(Framing::rtu, Framing::ascii, Framing::tcp)};
    settings.profile = *rc::gen::element(model::Profile::generic, model::Profile::owen_kc1);
    settings.strategy = model::Strategy::optimal;
    auto made = project(settings, some_items(most));
    model::Line& line = made.lines[0];
    line.format.baud = *rc::gen::element<std::uint32_t>(1200, 9600, 19200, 115200, 921600);
    line.request_gap = *rc::gen::element<Duration>(0ms, 0ms, 12ms);
    model::Device& device = line.devices[0];
    device.turnaround = *rc::gen::element<Duration>(0ms, 5ms, 50ms);
    device.round_trip = *rc::gen::element<Duration>(1us, 1ms);
    device.registers_per_request_set = *rc::gen::arbitrary<bool>();
    device.registers_per_request = *rc::gen::element<std::uint16_t>(2, 7, 16, 61);
    set_gaps(device);
    for (Variable& v : device.variables)
        if (v.period > 0ms) v.period = 100ms;
    return made;
}

// ---- the reference

struct Range {
    int start = 0, end = 0;
    friend auto operator<=>(const Range&, const Range&) = default;
    [[nodiscard]] bool holds(const Range& other) const { return start <= other.start && other.end <= end; }
};

bool is_bits(wire::Function function) {
    return function == wire::Function::read_coils || function == wire::Function::read_discrete_inputs;
}

Range range_of(const Variable& v) {
    if (is_bits(*v.read)) return {v.register_number * 16 + *v.bit, v.register_number * 16 + *v.bit + 1};
    return {v.register_number, v.register_number + v.registers};
}

int limit_of(const model::Project& project, wire::Function function) {
    const model::Line& line = project.lines[0];
    const auto& device = line.devices[0];
    const bool owen = project.profile == model::Profile::owen_kc1;
    int limit = is_bits(function) ? (owen ? 125 : 2000) : 125;
    if (!is_bits(function) && owen && line.framing == Framing::ascii) limit = 61;
    return device.registers_per_request_set ? std::min<int>(limit, device.registers_per_request) : limit;
}

bool inside(const std::vector<model::ItemRange>& ranges, int item) {
    return std::any_of(ranges.begin(), ranges.end(),
                       [&](const auto& range) { return range.first <= item && item <= range.last; });
}

bool may_read(const model::Device& device, wire::Function function, int item) {
    for (const Variable& v : device.variables)
        if (v.used && v.read == function && range_of(v).holds({item, item + 1})) return true;
    const std::size_t area =
        std::map<int, std::size_t>{{1, 0}, {2, 1}, {4, 2}, {3, 3}}.at(static_cast<int>(function));
    if (device.gaps == model::Gaps::never || inside(device.no_read[area], item)) return false;
    return device.readable[area].empty() || inside(device.readable[area], item);
}

// The contents of a request of a class: whole values, and the pieces of long ones.
std::vector<Range> parts(const Variable& v, int limit) {
    std::vector<Range> parts;
    Range left = range_of(v);
    for (; left.end - left.start > limit; left.start += limit)
        parts.push_back({left.start, left.start + limit});
    parts.push_back(left);
    return parts;
}

struct Class {
    wire::Function function;
    std::optional<Duration> period;
    std::optional<model::LocalIndex> trigger;
    friend auto operator<=>(const Class&, const Class&) = default;

    [[nodiscard]] bool has(const Variable& v) const {
        return v.used && v.read == function && (period ? v.period == *period : v.read_trigger == trigger);
    }
};

std::set<Class> classes_of(const model::Device& device) {
    std::set<Class> classes;
    for (const Variable& v : device.variables) {
        if (!v.used || !v.read) continue;
        classes.insert({*v.read, v.period, {}});
        if (v.read_trigger) classes.insert({*v.read, {}, v.read_trigger});
    }
    return classes;
}

std::set<Range> parts_of(const model::Project& project, const Class& wanted) {
    std::set<Range> all;
    for (const Variable& v : project.lines[0].devices[0].variables)
        if (wanted.has(v))
            for (const Range& part : parts(v, limit_of(project, wanted.function))) all.insert(part);
    return all;
}

using Total = std::pair<ExactTime, std::size_t>;

ExactTime cost_of(const model::Project& project, wire::Function function, int items) {
    const model::Line& line = project.lines[0];
    const auto [asked, answered] = frame_lengths(line.framing, function, static_cast<std::size_t>(items));
    return BusTimeModel(line).transaction(line.devices[0], asked, answered,
                                          estimated_turnaround(line.devices[0]));
}

// The least total over all sets of requests, each from any item to any other.
Total least(const model::Project& project, const Class& wanted) {
    const auto all = parts_of(project, wanted);
    const std::vector<Range> held(all.begin(), all.end());
    std::map<unsigned, ExactTime> cheapest;
    for (const Range& first : held) {
        int end = first.start;
        while (end - first.start < limit_of(project, wanted.function) &&
               may_read(project.lines[0].devices[0], wanted.function, end)) {
            ++end;
            unsigned set = 0;
            for (std::size_t i = 0; i < held.size(); ++i)
                if (Range{first.start, end}.holds(held[i])) set |= 1U << i;
            if (set == 0) continue;
            const ExactTime cost = cost_of(project, wanted.function, end - first.start);
            const auto [at, added] = cheapest.try_emplace(set, cost);
            if (!added) at->second = std::min(at->second, cost);
        }
    }
    std::vector<Total> totals(std::size_t{1} << held.size(), Total{ExactTime{1} << 100, 0});
    totals[0] = {0, 0};
    for (unsigned set = 0; set < totals.size(); ++set)
        for (const auto& [more, cost] : cheapest)
            totals[set | more] =
                std::min(totals[set | more], {totals[set].first + cost, totals[set].second + 1});
    return totals.back();
}

bool serves(const Request& request, const Class& wanted) {
    return request.read == wanted.function &&
           (wanted.period ? request.period == wanted.period : request.read_trigger == wanted.trigger);
}

RC_GTEST_PROP(Optimal, CostsWhatTheBestSetOfRequestsCosts, ()) {
    const auto made = some_project(6);
    const auto plan = make_plan(made).lines[0];
    for (const Class& wanted : classes_of(made.lines[0].devices[0])) {
        Total total{0, 0};
        for (const Request& request : plan.requests) {
            if (!serves(request, wanted)) continue;
            total.first += cost_of(made, wanted.function, request.quantity);
            ++total.second;
        }
        RC_ASSERT(total == least(made, wanted));
    }
}

RC_GTEST_PROP(Optimal, CoversEachVariableWithinTheLimits, ()) {
    const auto made = some_project(30);
    const auto& device = made.lines[0].devices[0];
    const auto plan = make_plan(made).lines[0];
    for (const Request& request : plan.requests) {
        const Range items{request.start, request.start + request.quantity};
        RC_ASSERT(request.quantity <= limit_of(made, *request.read));
        for (int item = items.start; item < items.end; ++item)
            RC_ASSERT(may_read(device, *request.read, item));
        std::optional<Duration> deadline;
        for (const std::size_t i : request.variables) {
            const Variable& v = device.variables[i];
            const auto due = v.deadline.value_or(v.period);
            if (due > 0ms && (!deadline || due < *deadline)) deadline = due;
            RC_ASSERT(!request.period || v.period == request.period);
            RC_ASSERT(!request.read_trigger || v.read_trigger == request.read_trigger);
            RC_ASSERT(!request.status || v.status == request.status);
        }
        if (request.period)
            RC_ASSERT(
                (request.deadline.has_value() == deadline.has_value() && !(request.deadline > deadline)));
    }
    for (const Class& wanted : classes_of(device))
        for (std::size_t i = 0; i < device.variables.size(); ++i) {
            if (!wanted.has(device.variables[i])) continue;
            for (const Range& part : parts(device.variables[i], limit_of(made, wanted.function)))
                RC_ASSERT(std::any_of(plan.requests.begin(), plan.requests.end(), [&](const Request& r) {
                    return serves(r, wanted) && Range{r.start, r.start + r.quantity}.holds(part) &&
                           std::count(r.variables.begin(), r.variables.end(), i) == 1;
                }));
        }
}

// The properties of a request, with the names of its variables.
auto shape(const model::Device& device, const Request& r) {
    std::vector<std::string> names;
    for (const std::size_t i : r.variables) names.push_back(device.variables[i].name);
    return std::tuple(r.read, r.start, r.quantity, r.period, r.read_trigger, r.status, r.stream, names,
                      r.why.code, r.why.arguments);
}

RC_GTEST_PROP(Optimal, DoesNotDependOnTheOrderOfTheFile, (unsigned seed)) {
    const auto made = some_project(30);
    auto shuffled = made;
    auto& variables = shuffled.lines[0].devices[0].variables;
    std::mt19937 random(seed);
    std::shuffle(variables.begin(), variables.end(), random);
    const auto plan = make_plan(made).lines[0];
    const auto again = make_plan(shuffled).lines[0];
    RC_ASSERT(plan.requests.size() == again.requests.size());
    for (std::size_t i = 0; i < plan.requests.size(); ++i)
        RC_ASSERT(shape(made.lines[0].devices[0], plan.requests[i]) ==
                  shape(shuffled.lines[0].devices[0], again.requests[i]));
}

RC_GTEST_PROP(Optimal, NeverNeedsMoreBusTimeThanClassic, ()) {
    auto made = some_project(30);
    model::Device& device = made.lines[0].devices[0];
    for (Variable& v : device.variables) v.registers = std::min(v.registers, device.registers_per_request);
    RC_ASSERT(make_plan(made).lines[0].cycle <=
              make_plan(made, {.strategy = model::Strategy::classic}).lines[0].cycle);
}

RC_GTEST_PROP(Optimal, ListsEntriesByFunctionAndStart, ()) {
    const auto plan = make_plan(some_project(30)).lines[0];
    std::size_t streams = 0;
    for (std::size_t i = 0; i < plan.requests.size(); ++i) {
        const Request& b = plan.requests[i];
        RC_ASSERT(b.stream <= streams);
        streams = std::max(streams, b.stream + 1);
        if (i == 0) continue;
        const Request& a = plan.requests[i - 1];
        RC_ASSERT(std::tuple(a.read, a.start) <= std::tuple(b.read, b.start));
    }
}

}  // namespace optimal_properties_test
}  // namespace takt::plan
