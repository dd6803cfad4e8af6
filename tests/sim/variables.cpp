// The variables of a random device: runs of neighbours with gaps between, as real maps have them.
#include <algorithm>
#include <array>
#include <string_view>

#include "blueprint.hpp"

namespace takt::simtest {
namespace {

struct Type {
    std::string_view name;
    int registers;
};
constexpr std::array kTypes{Type{"int16", 1},  Type{"uint16", 1}, Type{"int32", 2},
                            Type{"uint32", 2}, Type{"float", 2},  Type{"int64", 4},
                            Type{"uint64", 4}, Type{"double", 4}, Type{"string", 3}};
constexpr std::array<std::string_view, 4> kAreas{"coil", "discrete_input", "input_register",
                                                 "holding_register"};

}  // namespace

VariableBlueprint& VariableDrawer::begin(const std::string& type) {
    auto& made = made_.emplace_back();
    made.keys = {{"name", traits_.prefix + std::to_string(made_.size())}, {"type", type}};
    return made;
}

std::vector<VariableBlueprint> VariableDrawer::draw(std::size_t count) {
    const bool many_bits = chance(20);
    for (int& next : next_) next = static_cast<int>(random_.below(3)) * 40;
    while (made_.size() < count) {
        const auto kind = random_.below(10);
        if (kind < (many_bits ? 4U : 2U))
            add_coils();
        else if (kind < 5 && chance(40))
            add_bits();
        else
            add_registers();
    }
    return std::move(made_);
}

void VariableDrawer::add_gap(const std::string& area, int size) {
    const bool bits = area == kAreas[0] || area == kAreas[1];
    int& next = next_[area == kAreas[0] ? 0 : area == kAreas[1] ? 1 : area == kAreas[2] ? 2 : 3];
    for (int i = 0; i < size; ++i, ++next) {
        if (!traits_.gaps_readable) continue;
        auto& keys = begin(bits ? "bool" : "uint16").keys;
        keys.emplace_back("area", area);
        keys.emplace_back(bits ? "coil" : "register", std::to_string(next));
        keys.emplace_back("used", "false");
    }
}

// Neighbours share their settings more often than not, so that there is something to group.
void VariableDrawer::add_registers() {
    const bool input = chance(25);
    const std::string area(kAreas[input ? 2 : 3]);
    if (chance(35)) add_gap(area, 1 + static_cast<int>(random_.below(4)));
    const Type type = kTypes[random_.below(chance(70) ? 5U : static_cast<std::uint32_t>(kTypes.size()))];
    const bool writes = !input && chance(55);
    const bool reads = !writes || chance(85);
    const bool single = type.registers == 1 && chance(30);
    const sim::Random style = random_.fork(1);
    const int run = 1 + static_cast<int>(random_.below(4));
    for (int i = 0; i < run; ++i) {
        const sim::Random own = random_.fork(2);
        if (!chance(20)) random_ = style;
        auto& made = begin(std::string(type.name));
        int& next = next_[input ? 2 : 3];
        made.keys.emplace_back("register", std::to_string(next));
        if (type.name == "string") made.keys.emplace_back("length", std::to_string(type.registers));
        if (reads) add_reading(made.keys, input ? "0x04" : "0x03");
        if (!reads) made.keys.emplace_back("read", "none");
        if (writes) add_writing(made.keys, single ? "0x06" : "0x10");
        add_values(made.keys, std::string(type.name));
        if (chance(15)) made.period_ms = 250 * (1 + static_cast<int>(random_.below(16)));
        next += type.registers;
        random_ = own;
    }
}

void VariableDrawer::add_bits() {
    int& next = next_[3];
    const bool writes = (traits_.mask_writes || traits_.modifies) && chance(70);
    const auto bits = 1 + random_.below(4);
    for (std::uint32_t i = 0, bit = random_.below(4); i < bits; ++i, bit += 1 + random_.below(3)) {
        auto& made = begin("bool");
        made.keys.emplace_back("register", std::to_string(next));
        made.keys.emplace_back("bit", std::to_string(bit));
        add_reading(made.keys, "0x03");
        if (writes) add_writing(made.keys, chance(50) ? "0x06" : "0x10");
    }
    ++next;
}

void VariableDrawer::add_coils() {
    const bool input = chance(30);
    if (chance(30)) add_gap(std::string(kAreas[input ? 1 : 0]), 1 + static_cast<int>(random_.below(5)));
    int& next = next_[input ? 1 : 0];
    const auto run = 1 + random_.below(5);
    const bool writes = !input && chance(60);
    const bool single = chance(50);
    const sim::Random style = random_.fork(3);
    for (std::uint32_t i = 0; i < run; ++i) {
        const sim::Random own = random_.fork(4);
        if (!chance(20)) random_ = style;
        auto& made = begin("bool");
        made.keys.emplace_back("coil", std::to_string(next++));
        add_reading(made.keys, input ? "0x02" : "0x01");
        if (writes) add_writing(made.keys, single ? "0x05" : "0x0F");
        random_ = own;
    }
}

void VariableDrawer::add_reading(Keys& keys, const std::string& function) {
    keys.emplace_back("read", function);
    if (triggers_ > 0 && chance(12))
        keys.emplace_back("read_trigger",
                          "trigger" + std::to_string(random_.below(static_cast<std::uint32_t>(triggers_))));
    if (statuses_ > 0 && chance(15))
        keys.emplace_back("status",
                          "status" + std::to_string(random_.below(static_cast<std::uint32_t>(statuses_))));
}

void VariableDrawer::add_writing(Keys& keys, const std::string& function) {
    keys.emplace_back("write", function);
    const auto how = random_.below(10);
    if (how < 5) keys.emplace_back("write_on_change", "true");
    if (how >= 4 && how < 7 && triggers_ > 0)
        keys.emplace_back("write_trigger",
                          "trigger" + std::to_string(random_.below(static_cast<std::uint32_t>(triggers_))));
    if (how < 5 && chance(30)) {
        keys.emplace_back("min_interval", std::to_string(500 * (1 + random_.below(6))) + "ms");
        keys.emplace_back("burst", std::to_string(1 + random_.below(3)));
    }
    if (chance(30)) keys.emplace_back("safe_to_repeat", "true");
    if (random_.fork(5).below(6) == 0) keys.emplace_back("verify", "true");
    if (random_.fork(6).below(10) < 3) add_default(keys);
}

void VariableDrawer::add_default(Keys& keys) {
    const auto type = std::ranges::find(keys, "type", &Keys::value_type::first);
    keys.emplace_back("default", type->second == "bool" ? "true" : type->second == "string" ? "abc" : "7");
}

void VariableDrawer::add_values(Keys& keys, const std::string& type) {
    if (type == "string") return;
    if (chance(15)) keys.emplace_back("scale", chance(50) ? "0.1" : "0.5");
    if (chance(10)) keys.emplace_back("offset", "-40");
    if (chance(10)) keys.emplace_back("hold_last", "true");
    if (chance(10)) keys.emplace_back("high_register_first", "true");
    if (chance(10)) keys.emplace_back("high_byte_first", "false");
    if (chance(10)) keys.emplace_back("dead_band", "2");
}

}  // namespace takt::simtest
