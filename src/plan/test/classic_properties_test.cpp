// Classic against a slow reference that is written from the text of docs/specification.md, section 4, and
// against what every plan must hold.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <tuple>

#include "builder.hpp"

namespace takt::plan {
namespace classic_properties_test {

using namespace test;
using model::Profile;
using model::Variable;
using wire::Framing;

// ---- random projects: long runs of neighbours with few disturbances, so that every rule decides often

constexpr int kReadFunctions[] = {1, 2, 3, 4};
constexpr DataType kTypes[] = {DataType::int16,   DataType::uint16, DataType::int32,
                               DataType::uint32,  DataType::int64,  DataType::float32,
                               DataType::float64, DataType::string, DataType::boolean};

std::optional<model::LocalIndex> local(unsigned choice) {
    return choice % 3 == 0 ? std::nullopt : std::optional<model::LocalIndex>(choice % 3);
}

void set_functions(Item& item, unsigned choice) {
    const int read = kReadFunctions[choice % 4];
    const bool bits = read < 3;
    if (bits) item.type = DataType::boolean;
    item = item.read(read);
    item.model::Variable::write.reset();
    if (read == 1 || read == 3) item.model::Variable::write = static_cast<wire::Function>(bits ? 0x0F : 0x10);
    if (read == 1 && choice / 4 % 3 == 0) item.model::Variable::write = wire::Function::write_single_coil;
    if (read == 3 && choice / 4 % 4 == 0) item.model::Variable::write = wire::Function::write_single_register;
    if (choice / 16 % 4 == 0) item.model::Variable::write.reset();
    if (choice / 16 % 4 == 1 && item.model::Variable::write) item.model::Variable::read.reset();
}

void set_type(Item& item, unsigned choice) {
    if (wire::is_bit_area(item.area)) return;
    item.type = kTypes[choice % std::size(kTypes)];
    item.registers =
        static_cast<std::uint16_t>(register_count(item.type, 1 + static_cast<int>(choice / 16 % 3)));
}

void disturb(Item& item, unsigned which, unsigned choice) {
    switch (which) {
        case 0: set_functions(item, choice); break;
        case 1: set_type(item, choice); break;
        case 2: item.period = choice % 2 ? 100ms : 50ms; break;
        case 3: item.status = local(choice); break;
        case 4: item.read_trigger = local(choice); break;
        case 5: item.write_trigger = local(choice); break;
        case 6: item.write_on_change = choice % 2; break;
        case 7: item.register_number = static_cast<std::uint16_t>(item.register_number + choice % 3); break;
        case 8: item.register_number = static_cast<std::uint16_t>(choice % 12); break;
        case 9: item.used = choice % 4 != 0; break;
        case 10: item.model::Variable::read.reset(); break;
        default: break;
    }
}

std::vector<Item> items_from(const std::vector<std::uint32_t>& steps) {
    std::vector<Item> items;
    Item item = int16(0).read(3).write(0x10).on_change();
    for (const std::uint32_t step : steps) {
        disturb(item, step % 24, step / 24 % 65536);
        if (item.type == DataType::boolean) {
            item.registers = 1;
            if (!item.bit) item.bit = std::uint8_t{0};
        } else {
            item.bit.reset();
        }
        items.push_back(item);
        const bool next_bit = item.bit && *item.bit < 15;
        if (next_bit)
            item.bit = static_cast<std::uint8_t>(*item.bit + 1);
        else
            item.register_number = static_cast<std::uint16_t>(item.register_number + item.registers);
        if (item.bit && !next_bit) item.bit = std::uint8_t{0};
    }
    return items;
}

struct Sample {
    Settings settings;
    std::vector<Item> items;
};

Sample sample() {
    const auto steps = *rc::gen::container<std::vector<std::uint32_t>>(rc::gen::arbitrary<std::uint32_t>());
    Settings settings;
    settings.registers_per_request = *rc::gen::elementOf(std::vector<std::uint16_t>{2, 3, 4, 5, 7, 16, 125});
    settings.framing = *rc::gen::element(Framing::rtu, Framing::ascii);
    settings.profile = *rc::gen::element(Profile::generic, Profile::owen_kc1);
    return {settings, items_from(steps)};
}

// The properties that make two variables equal for a plan. The name is not one of them.
auto likeness(const Variable& v) {
    return std::make_tuple(v.register_number, v.bit.value_or(0), v.type, v.registers, v.read, v.write,
                           v.period, v.status, v.read_trigger, v.write_trigger, v.write_on_change);
}

// ---- the reference: numbers by counting, groups by asking every rule of every pair

bool takes_part(const Variable& v, bool writing) {
    if (!v.used) return false;
    if (!writing) return v.read.has_value();
    if (v.type == DataType::boolean && v.area == wire::Area::holding_register) return false;
    return v.write.has_value() && (v.write_on_change || v.write_trigger.has_value());
}

std::vector<std::size_t> pass_order(const std::vector<Variable>& all, bool writing) {
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < all.size(); ++i) {
        if (!takes_part(all[i], writing)) continue;
        const auto key = [&](std::size_t k) {
            const Variable& v = all[k];
            return std::make_tuple(writing ? *v.write : *v.read, v.register_number, v.bit.value_or(0));
        };
        auto at = order.begin();
        while (at != order.end() && key(*at) <= key(i)) ++at;
        order.insert(at, i);
    }
    return order;
}

// docs/specification.md, section 3, as it stands there.
int limit_of(const Settings& settings, wire::Function function) {
    const bool tight = settings.framing == Framing::ascii && settings.profile == Profile::owen_kc1;
    switch (static_cast<int>(function)) {
        case 0x03:
        case 0x04: return tight ? 61 : 125;
        case 0x10: return tight ? 59 : 123;
        case 0x0F: return settings.profile == Profile::owen_kc1 ? 125 : 1968;
        default: return settings.profile == Profile::owen_kc1 ? 125 : 2000;
    }
}

// Signedness is a reading of an integer; an integer of two registers and a float are one.
DataType type_of(const Variable& v) {
    if (v.type == DataType::uint16) return DataType::int16;
    if (v.type == DataType::uint64) return DataType::int64;
    return v.type == DataType::int32 || v.type == DataType::uint32 ? DataType::float32 : v.type;
}

bool may_follow(const Variable& a, const Variable& b, bool writing) {
    const bool rule_2 = b.type == DataType::boolean
                            ? b.register_number == a.register_number && *b.bit == a.bit.value_or(99) + 1
                            : b.register_number == a.register_number + a.registers;
    const bool rule_3 = a.status == b.status;
    const bool rule_4 = a.registers == b.registers && type_of(a) == type_of(b);
    const bool rule_5 = writing || (a.read == b.read && a.read_trigger == b.read_trigger);
    const bool alone =
        b.write == wire::Function::write_single_coil || b.write == wire::Function::write_single_register;
    const bool rule_6 = !writing || (a.write == b.write && a.write_trigger == b.write_trigger &&
                                     a.write_on_change == b.write_on_change && !alone);
    const bool rule_7 = a.period == b.period;
    return rule_2 && rule_3 && rule_4 && rule_5 && rule_6 && rule_7;
}

struct Entry {
    bool reads, writes;
    std::vector<std::size_t> members;
    friend bool operator==(const Entry&, const Entry&) = default;
};

std::vector<Entry> reference(const Settings& settings, const std::vector<Variable>& all) {
    std::map<std::size_t, int> numbers;
    std::vector<Entry> entries;
    for (const bool writing : {false, true}) {
        const auto order = pass_order(all, writing);
        for (const std::size_t i : order) numbers.try_emplace(i, static_cast<int>(numbers.size()) + 1);
        std::vector<std::vector<std::size_t>> groups;
        for (const std::size_t i : order) {
            bool joins = !groups.empty();
            if (joins) {
                auto members = groups.back();
                members.push_back(i);
                int items = 0;
                for (const std::size_t m : members)
                    items += all[m].type == DataType::boolean ? 1 : all[m].registers;
                const int limit = limit_of(settings, writing ? *all[i].write : *all[i].read);
                joins = items <= std::min<int>(limit, settings.registers_per_request) &&
                        may_follow(all[groups.back().back()], all[i], writing) &&
                        numbers[i] == numbers[groups.back().back()] + 1;
            }
            if (!joins) groups.emplace_back();
            groups.back().push_back(i);
        }
        for (const auto& group : groups) {
            const auto partner = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) {
                return writing && entry.reads && entry.members.front() == group.front() &&
                       entry.members.size() == group.size();
            });
            if (partner != entries.end())
                partner->writes = true;
            else
                entries.push_back({!writing, writing, group});
        }
    }
    return entries;
}

std::vector<Entry> entries_of(const LinePlan& plan) {
    std::vector<Entry> entries;
    for (const Request& request : plan.requests)
        entries.push_back({request.read.has_value(), request.write.has_value(), request.variables});
    return entries;
}

TEST(Classic, KeepsTheOrderOfTheFileAtOneRegister) {
    const auto made = project({16}, {real(4).read(3), int16(4).read(3), int16(5).read(3), int16(4).read(3)});
    EXPECT_EQ(entries_of(make_plan(made).lines[0]),
              (std::vector<Entry>{{true, false, {0}}, {true, false, {1}}, {true, false, {3, 2}}}));
}

RC_GTEST_PROP(Classic, EqualsTheReference, ()) {
    const auto [settings, items] = sample();
    const auto made = project(settings, items);
    const auto plan = make_plan(made).lines[0];
    const auto expected = reference(settings, made.lines[0].devices[0].variables);
    RC_ASSERT(entries_of(plan) == expected);

    std::size_t count = 0;
    for (const Entry& entry : expected)
        count += entry.reads && items[entry.members[0]].read_trigger ? 2U : 1U;
    RC_ASSERT(plan.request_count == count);
}

// ---- what every plan must hold

// A request without its names: the members as they are alike.
using Shape = std::tuple<std::uint8_t, std::optional<wire::Function>, std::optional<wire::Function>,
                         std::uint16_t, std::uint16_t, Duration, std::string,
                         std::vector<decltype(likeness(std::declval<Variable>()))>>;

std::vector<Shape> shapes(const model::Project& project, const LinePlan& plan) {
    std::vector<Shape> shapes;
    for (const Request& r : plan.requests) {
        const auto& device = project.lines[0].devices[r.device];
        std::vector<decltype(likeness(std::declval<Variable>()))> members;
        for (const std::size_t i : r.variables) members.push_back(likeness(device.variables[i]));
        shapes.emplace_back(device.address.value, r.read, r.write, r.start, r.quantity, r.bus_time,
                            r.why.code, members);
    }
    return shapes;
}

// Shuffles the variables, but those at one register and bit keep their order.
void shuffle(std::vector<Variable>& variables, std::mt19937& random) {
    const auto seat = [](const Variable& v) { return std::pair(v.register_number, v.bit.value_or(0)); };
    const auto before = variables;
    std::shuffle(variables.begin(), variables.end(), random);
    std::map<std::pair<std::uint16_t, std::uint8_t>, std::vector<Variable>> seats;
    for (auto v = before.rbegin(); v != before.rend(); ++v) seats[seat(*v)].push_back(*v);
    for (auto& v : variables) {
        auto& left = seats[seat(v)];
        v = left.back();
        left.pop_back();
    }
}

RC_GTEST_PROP(Classic, DoesNotDependOnTheOrderOfTheRegisters, (unsigned seed)) {
    const auto first = sample();
    const auto second = sample();
    auto made = project(first.settings, {});
    made.lines[0].devices = {device(9, first.settings, first.items), device(4, first.settings, second.items)};
    const auto plan = make_plan(made).lines[0];

    auto shuffled = made;
    std::mt19937 random(seed);
    auto& devices = shuffled.lines[0].devices;
    std::swap(devices[0], devices[1]);
    for (auto& device : devices) shuffle(device.variables, random);
    const auto again = make_plan(shuffled).lines[0];

    RC_ASSERT(shapes(made, plan) == shapes(shuffled, again));
    RC_ASSERT(plan.request_count == again.request_count);
    RC_ASSERT(plan.ungrouped_requests == again.ungrouped_requests);
    RC_ASSERT(plan.cycle == again.cycle);
}

void check_span(const Request& request, const std::vector<Variable>& variables) {
    std::uint32_t end = request.start;
    for (const std::size_t i : request.variables) {
        const Variable& v = variables[i];
        const bool bit_of_register = v.type == DataType::boolean && !wire::is_bit_area(v.area);
        RC_ASSERT(v.start() == (bit_of_register ? request.start : end));
        end = v.start() + std::uint32_t{v.items()};
    }
    RC_ASSERT(end == std::uint32_t{request.start} + request.quantity);
}

RC_GTEST_PROP(Plans, CoverEachUsedVariableOnceAndInOneRequest, ()) {
    auto [settings, items] = sample();
    settings.strategy = *rc::gen::element(model::Strategy::single, model::Strategy::classic);
    const auto made = project(settings, items);
    const auto& variables = made.lines[0].devices[0].variables;
    const auto plan = make_plan(made).lines[0];
    std::multiset<std::size_t> read, written;
    for (const Request& request : plan.requests) {
        check_span(request, variables);
        RC_ASSERT(request.variables.size() == 1 ||
                  request.variables.size() <= settings.registers_per_request);
        for (const std::size_t i : request.variables) {
            if (request.read) read.insert(i);
            if (request.write) written.insert(i);
        }
        for (const auto& function : {request.read, request.write})
            if (function && request.variables.size() > 1)
                RC_ASSERT(request.quantity <=
                          std::min<int>(limit_of(settings, *function), settings.registers_per_request));
    }
    for (std::size_t i = 0; i < variables.size(); ++i) {
        RC_ASSERT(read.count(i) == (variables[i].used && variables[i].read ? 1U : 0U));
        if (settings.strategy == model::Strategy::classic)
            RC_ASSERT(written.count(i) == (takes_part(variables[i], true) ? 1U : 0U));
    }
}

RC_GTEST_PROP(Classic, NeverNeedsMoreBusTimeThanSingleToRead, ()) {
    const auto [settings, items] = sample();
    const auto made = project(settings, items);
    const auto classic = make_plan(made).lines[0];
    const auto single = make_plan(made, {.strategy = model::Strategy::single}).lines[0];
    RC_ASSERT(classic.cycle <= single.cycle);
    RC_ASSERT(classic.ungrouped_requests == single.request_count);
}

// A project with errors: types that do not fit their area, lengths and limits of zero, addresses beyond the
// end.
std::vector<Item> items_with_errors() {
    const auto numbers = *rc::gen::container<std::vector<std::uint32_t>>(rc::gen::arbitrary<std::uint32_t>());
    std::vector<Item> items;
    for (const std::uint32_t number : numbers) {
        Item item = test::item(kTypes[number % std::size(kTypes)], static_cast<int>(number >> 16));
        item.registers = static_cast<std::uint16_t>(number % 7 == 0 ? number >> 12 : item.registers);
        if (number % 3 == 0) item.bit = static_cast<std::uint8_t>(number >> 3);
        if (number % 4 != 0) item = item.read(kReadFunctions[number / 4 % 4]);
        if (number % 5 != 0) item = item.write(number % 2 ? 0x05 : 0x10).on_change();
        item.area = static_cast<wire::Area>(number / 8 % 4);
        items.push_back(item);
    }
    return items;
}

RC_GTEST_PROP(Plans, ShowAProjectWithErrors, ()) {
    const auto items = items_with_errors();
    const auto limit = *rc::gen::element<std::uint16_t>(0, 1, 200, 65535);
    const auto plan = plan_of({limit}, items);
    std::multiset<std::size_t> read;
    for (const Request& request : plan.requests) {
        RC_ASSERT(!request.why.code.empty());
        if (request.read) read.insert(request.variables.begin(), request.variables.end());
    }
    for (std::size_t i = 0; i < items.size(); ++i)
        RC_ASSERT(read.count(i) == (items[i].model::Variable::read ? 1U : 0U));
}

// Every register of a device, read and written, in the least favourable order of the file.
TEST(Classic, PlansAWholeAreaOfRegisters) {
    auto items = row(65536, int16(0).read(3).write(0x10).on_change());
    std::reverse(items.begin(), items.end());
    const auto plan = plan_of({123}, items);
    EXPECT_EQ(plan.requests.size(), 533U) << "65536 / 123 = 532.8, all merged";
    EXPECT_EQ(plan.ungrouped_requests, 65536U);
    EXPECT_EQ(plan.requests.back().start + plan.requests.back().quantity, 65536);
}

}  // namespace classic_properties_test
}  // namespace takt::plan
