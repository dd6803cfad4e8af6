#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model {
namespace mirror_test {

using namespace test;

constexpr std::string_view kLine =
    "{takt: 1, lines: [{name: L, transport: tcp, host: h, devices: ["
    "{name: B, address: 2, variables: ["
    "{name: Level, type: float, register: 10, read: 3, unit: m}, "
    "{name: Alarm, type: bool, coil: 3, read: 1}, "
    "{name: Unused, type: int, register: 1, read: 3, used: false}]}, "
    "{name: A, address: 1, variables: ["
    "{name: Speed, type: int16, register: 5, read: 3, write: 0x10, scale: 0.1, enumeration: ~}, "
    "{name: Written, type: int16, register: 6, read: none, write: 6}]}]}], "
    "servers: [{name: S, listen: *, units: [{address: 1, ";

Checked with_unit(std::string_view unit) {
    auto text = std::string(kLine) + std::string(unit) + "}]}]}";
    const auto tilde = text.find(", enumeration: ~");
    text.erase(tilde, std::string_view(", enumeration: ~").size());
    return interpret({.files = {"p.yaml"}, .root = flow(text)});
}

std::string codes_of(const Checked& checked) {
    std::string codes;
    for (const auto& finding : checked.findings) codes += finding.code + ' ' + finding.path + ' ';
    return codes;
}

/// `Level 0+2`: name, first item, number of items.
std::vector<std::string> places(const Checked& checked) {
    std::vector<std::string> all;
    for (const auto& variable : checked.project.servers.at(0).units.at(0).variables)
        all.push_back(variable.name + ' ' + std::to_string(variable.start()) + '+' +
                      std::to_string(variable.items()));
    return all;
}

TEST(Mirror, EveryPolledValueHasItsRegisters) {
    const auto checked = with_unit("mirror: {}");
    EXPECT_EQ(codes_of(checked), "");
    EXPECT_EQ(places(checked), (std::vector<std::string>{"Level 0+2", "Alarm 2+1", "Speed 3+1"}));
    const auto& unit = checked.project.servers[0].units[0];
    EXPECT_EQ(unit.offered[static_cast<std::size_t>(wire::Area::holding_register)],
              (std::vector<ItemRange>{{0, 3}}));
    ASSERT_EQ(unit.bindings.size(), 3U);
    EXPECT_EQ(std::get<VariableSource>(*unit.bindings[2].source).name, "Speed");
    EXPECT_EQ(unit.bindings[2].max_age, std::chrono::seconds(3));
    EXPECT_FALSE(unit.bindings[2].sink) << "read only";
    EXPECT_EQ(unit.variables[2].scale, 0.1) << "the same raw number";
    EXPECT_EQ(unit.variables[1].bit, 0);
}

TEST(Mirror, OrderAreaAndFirstAreChosen) {
    const auto checked = with_unit(
        "mirror: [{area: input_register, first: 100, order: address}, {area: discrete_input, first: 17}]");
    EXPECT_EQ(codes_of(checked), "");
    EXPECT_EQ(places(checked), (std::vector<std::string>{"Speed 100+1", "Level 101+2", "Alarm 17+1"}));
    EXPECT_EQ(places(with_unit("mirror: {order: name}")),
              (std::vector<std::string>{"Alarm 0+1", "Level 1+2", "Speed 3+1"}));
    EXPECT_EQ(places(with_unit("mirror: {devices: [A]}")), (std::vector<std::string>{"Speed 0+1"}));
}

TEST(Mirror, WritableValuesReachTheDevice) {
    const auto checked = with_unit("mirror: {writable: true}");
    EXPECT_EQ(codes_of(checked), "");
    const auto& bindings = checked.project.servers[0].units[0].bindings;
    EXPECT_TRUE(bindings.at(2).sink && !bindings.at(0).sink);
    EXPECT_TRUE(checked.project.lines[0].devices[1].variables[0].written_by_clients);
}

TEST(Mirror, MistakesAreFindings) {
    const std::pair<std::string_view, std::string_view> cases[] = {
        {"mirror: {first: 10}, banks: [{area: holding_register, items: [12..20]}]",
         "mirror.overlap servers[0].units[0].mirror.first "},
        {"mirror: {first: 10}, banks: [{area: holding_register, items: [14..20]}]", ""},
        {"mirror: {first: 10}, banks: [{area: input_register, items: [10..20]}]", ""},
        {"mirror: [{first: 0}, {first: 3}]", "mirror.overlap servers[0].units[0].mirror[1].first "},
        {"mirror: {first: 65533}", "mirror.beyond_end servers[0].units[0].mirror.first "},
        {"mirror: {first: 65532}", ""},
        {"mirror: {area: input_register, writable: true}",
         "field.without_effect servers[0].units[0].mirror.writable "},
        {"mirror: {devices: [C]}",
         "mirror.empty servers[0].units[0].mirror.area source.unknown "
         "servers[0].units[0].mirror.devices[0] "},
        {"mirror: {order: odd}", "field.unlike_word servers[0].units[0].mirror.order "},
        {"mirror: 5", "field.not_a_group servers[0].units[0].mirror "},
        {"mirror: [5]", "field.not_a_mapping servers[0].units[0].mirror[0] "},
        {"state: x",
         "field.missing servers[0].units[0].banks field.without_effect servers[0].units[0].state "},
    };
    for (const auto& [unit, codes] : cases) EXPECT_EQ(codes_of(with_unit(unit)), codes) << unit;
}

}  // namespace mirror_test
}  // namespace takt::model
