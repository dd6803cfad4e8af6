// Any set of writes: each value once, nothing else, and by no more requests than brute force needs.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>

#include "builder.hpp"
#include "requests/write_pass.hpp"

namespace takt::plan {
namespace write_pass_properties_test {

using namespace test;

constexpr DataType kTypes[] = {DataType::int16, DataType::int32, DataType::int64};

Item random_item(int most_register) {
    const int place = *rc::gen::inRange(0, most_register);
    Item made;
    switch (*rc::gen::inRange(0, 4)) {
        case 0: made = boolean(place / 8, *rc::gen::inRange(0, 4)).read(1); break;
        case 1: made = boolean(place, *rc::gen::inRange(0, 3)).read(3); break;
        default: made = item(kTypes[*rc::gen::inRange(0, 3)], place).read(3);
    }
    const bool coil = made.area == wire::Area::coil;
    const bool one = *rc::gen::inRange(0, 4) == 0 && made.registers == 1;
    made = made.write(coil ? (one ? 0x05 : 0x0F) : one ? 0x06 : 0x10);
    if (*rc::gen::inRange(0, 4) == 0) made = made.write_on(static_cast<std::size_t>(*rc::gen::inRange(0, 2)));
    if (!made.write_trigger || *rc::gen::inRange(0, 3) == 0) made = made.on_change();
    made.used = *rc::gen::inRange(0, 8) != 0;
    return made;
}

model::Project random_project(int most_items, int most_register) {
    std::vector<Item> items;
    const int count = *rc::gen::inRange(0, most_items);
    for (int i = 0; i < count; ++i) items.push_back(random_item(most_register));
    Settings settings{16, wire::Framing::rtu, model::Profile::generic, model::Strategy::optimal};
    auto made = project(settings, items);
    made.locals.resize(2);
    auto& device = made.lines[0].devices[0];
    device.write_single = *rc::gen::element(model::WriteSingle::as_declared, model::WriteSingle::allowed,
                                            model::WriteSingle::never);
    device.fc22 = *rc::gen::arbitrary<bool>();
    device.read_modify_write = *rc::gen::arbitrary<bool>();
    device.registers_per_request_set = *rc::gen::arbitrary<bool>();
    device.registers_per_request = *rc::gen::inRange<std::uint16_t>(2, 9);
    return made;
}

bool is_register_bit(const model::Variable& v) {
    return v.type == DataType::boolean && !wire::is_bit_area(v.area);
}

bool to_be_written(const model::Device& device, const model::Variable& v) {
    if (!v.used || !(v.write_on_change || v.write_trigger)) return false;
    return !is_register_bit(v) || device.fc22 || device.read_modify_write;
}

bool due_together(const model::Variable& a, const model::Variable& b) {
    return a.write_trigger == b.write_trigger && a.write_on_change == b.write_on_change;
}

RC_GTEST_PROP(WritePass, EachValueOnceAndNothingElse, ()) {
    const auto project = random_project(30, 24);
    const auto& device = project.lines[0].devices[0];
    std::vector<int> written(device.variables.size());
    for (const Request& r : write_requests(project, project.lines[0], device)) {
        const bool mask = r.write == wire::Function::mask_write_register || r.read_modify_write;
        std::uint32_t next = r.start;
        std::uint32_t bits = 0;
        for (const auto index : r.variables) {
            const auto& v = device.variables[index];
            ++written[index];
            RC_ASSERT(due_together(v, device.variables[r.variables[0]]));
            RC_ASSERT(r.write_trigger == v.write_trigger && r.write_on_change == v.write_on_change);
            RC_ASSERT(is_register_bit(v) == mask);
            if (mask) {
                RC_ASSERT(v.register_number == r.start);
                RC_ASSERT((bits & 1U << *v.bit) == 0U);
                bits |= 1U << *v.bit;
            } else {
                RC_ASSERT(v.start() == next);  // side by side: no gap, no overlap
                next += v.items();
            }
        }
        RC_ASSERT(r.quantity == (mask ? 1U : next - r.start));
        if (device.registers_per_request_set && r.variables.size() > 1 && !mask)
            RC_ASSERT(r.quantity <= device.registers_per_request);
    }
    for (std::size_t i = 0; i < written.size(); ++i)
        RC_ASSERT(written[i] == (to_be_written(device, device.variables[i]) ? 1 : 0));
}

RC_GTEST_PROP(WritePass, DoesNotDependOnTheOrderOfTheVariables, ()) {
    auto project = random_project(20, 12);
    auto& variables = project.lines[0].devices[0].variables;
    const auto names = [&] {
        std::vector<std::vector<std::string>> all;
        for (const Request& r : write_requests(project, project.lines[0], project.lines[0].devices[0])) {
            auto& one = all.emplace_back();
            for (const auto index : r.variables) one.push_back(variables[index].name);
        }
        return all;
    };
    const auto before = names();
    for (std::size_t i = variables.size(); i-- > 1;)
        std::swap(variables[i], variables[*rc::gen::inRange<std::size_t>(0, i + 1)]);
    RC_ASSERT(names() == before);
}

// ---- the fewest chains by trying all

struct Block {
    std::uint32_t start;
    std::uint32_t size;
};

std::size_t fewest(const std::vector<Block>& blocks, std::size_t at, std::vector<Block>& chains,
                   std::uint32_t most) {
    if (at == blocks.size()) return chains.size();
    const Block& next = blocks[at];
    chains.push_back(next);
    std::size_t best = fewest(blocks, at + 1, chains, most);
    chains.pop_back();
    for (std::size_t i = 0; i < chains.size(); ++i) {
        const Block before = chains[i];
        if (before.start + before.size != next.start || before.size + next.size > most) continue;
        chains[i].size += next.size;
        best = std::min(best, fewest(blocks, at + 1, chains, most));
        chains[i] = before;
    }
    return best;
}

RC_GTEST_PROP(WritePass, NoFewerRequestsArePossible, ()) {
    std::vector<Item> items;
    const int count = *rc::gen::inRange(1, 10);
    int place = 0;
    for (int i = 0; i < count; ++i) {
        if (*rc::gen::inRange(0, 5) == 0) ++place;
        items.push_back(item(kTypes[*rc::gen::inRange(0, 3)], place).write(0x10).on_change());
        place += items.back().registers;
    }
    Settings settings{16, wire::Framing::rtu, model::Profile::generic, model::Strategy::optimal};
    auto made = project(settings, items);
    auto& device = made.lines[0].devices[0];
    device.registers_per_request_set = true;
    device.registers_per_request = *rc::gen::inRange<std::uint16_t>(4, 9);
    std::vector<Block> blocks;
    for (const auto& v : device.variables) blocks.push_back({v.start(), v.registers});
    std::sort(blocks.begin(), blocks.end(), [](const Block& a, const Block& b) { return a.start < b.start; });
    std::vector<Block> chains;
    RC_ASSERT(write_requests(made, made.lines[0], device).size() ==
              fewest(blocks, 0, chains, device.registers_per_request));
}

}  // namespace write_pass_properties_test
}  // namespace takt::plan
