// docs/specification.md, section 6, by bytes, and projects that do not fit.
#include "takt/table/owen.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "project.hpp"
#include "takt/table/restore.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::table {
namespace owen_test {

using namespace test;

std::string hex(const Image& image, std::size_t from, std::size_t count) {
    std::string text;
    for (std::size_t i = from; i < from + count; ++i) {
        constexpr char kDigits[] = "0123456789ABCDEF";
        text += i > from ? " " : "";
        text += kDigits[image.at(i) >> 4];
        text += kDigits[image.at(i) & 15];
    }
    return text;
}

constexpr std::size_t kHead = 28, kMaster = 20, kDevice = 16, kEntry = 20;

std::string entry_bytes(const Image& image, std::size_t devices, std::size_t index) {
    return hex(image, kHead + kMaster + devices * kDevice + index * kEntry, kEntry);
}

Image owen(const model::Project& described) {
    const auto built = build_owen(described, plan::make_plan(described));
    EXPECT_TRUE(built.findings.empty());
    return write_owen(built.table);
}

std::vector<std::string> refusals(const model::Project& described) {
    std::vector<std::string> codes;
    for (const auto& finding : build_owen(described, plan::make_plan(described)).findings)
        codes.push_back(finding.code + " " + finding.path);
    return codes;
}

// docs/specification.md, section 5, scenario 3: triggers at the places 1 and 2, then the three variables.
TEST(Owen, Scenario3ByBytes) {
    auto node = device("Device1", 16);
    node.variables = {variable("Var1", DataType::int16, 500, Function::read_holding_registers),
                      variable("Var2", DataType::int16, 501, Function::read_holding_registers),
                      variable("Var3", DataType::int16, 506, Function::read_input_registers)};
    node.variables[0].read_trigger = node.variables[1].read_trigger = 0;
    node.variables[2].read_trigger = 1;
    node.variables[2].period = 50ms;
    node.variables[2].area = wire::Area::input_register;
    auto described = project({node});
    described.lines[0].request_gap = 12ms;
    described.locals = {local("T512"), local("T600")};
    const auto image = owen(described);
    ASSERT_EQ(image.size(), kHead + kMaster + kDevice + 2 * kEntry);
    EXPECT_EQ(hex(image, 0, 8), "54 41 4B 54 2D 4B 43 31");   // "TAKT-KC1"
    EXPECT_EQ(hex(image, 8, 8), "01 00 1C 00 68 00 00 00");   // version, header, length
    EXPECT_EQ(hex(image, 20, 8), "05 00 01 00 01 00 02 00");  // places, lines, devices, entries
    EXPECT_EQ(hex(image, kHead, kMaster),                     // RTU, no parity, 8, 1, 115200
              "00 00 08 01 00 C2 01 00 E0 2E 00 00 00 00 00 00 00 00 01 00");
    EXPECT_EQ(hex(image, kHead + kMaster, kDevice),  // unit, orders, 100, 100, 3
              "10 01 64 00 64 00 03 00 00 00 00 00 00 00 02 00");
    // word, read 3, polled, 2 variables from 500, data at 3, trigger at 1, period of the device
    EXPECT_EQ(entry_bytes(image, 1, 0), "01 03 00 01 02 00 F4 01 03 00 01 00 00 00 00 00 FF FF FF FF");
    // word, read 4, 1 variable at 506, data at 5, trigger at 2, own period of 50 ms
    EXPECT_EQ(entry_bytes(image, 1, 1), "01 04 00 01 01 00 FA 01 05 00 02 00 00 00 00 00 32 00 00 00");
}

TEST(Owen, BitsDoubleWordsWritesAndStatusByBytes) {
    auto node = device("Node", 1);
    node.variables = {variable("Level", DataType::float32, 10, Function::read_holding_registers,
                               Function::write_multiple_registers),
                      variable("Count", DataType::int32, 12, Function::read_holding_registers,
                               Function::write_multiple_registers),
                      variable("Pump", DataType::boolean, 3, Function::read_coils)};
    for (auto& v : node.variables) v.status = 1;
    node.variables[0].write_on_change = node.variables[1].write_on_change = true;
    node.variables[0].write_trigger = node.variables[1].write_trigger = 0;
    node.variables[2].area = wire::Area::coil;
    node.variables[2].bit = 5;
    node.variables[2].status.reset();
    auto described = project({node});
    described.locals = {local("go"), local("state", DataType::int16)};
    const auto image = owen(described);
    ASSERT_EQ(image.size(), kHead + kMaster + kDevice + 2 * kEntry);
    // bit 5 in the high nibble, read 1, register 3; it is read first, so its place is 3
    EXPECT_EQ(entry_bytes(image, 1, 0), "50 01 00 01 01 00 03 00 03 00 00 00 00 00 00 00 FF FF FF FF");
    // double words, read 3, write 0x10, polled and written on change, write trigger 1, status 2
    EXPECT_EQ(entry_bytes(image, 1, 1), "02 03 10 05 02 00 0A 00 04 00 00 00 01 00 02 00 FF FF FF FF");
}

TEST(Owen, ComesBack) {
    auto node = device("Node", 1);
    for (std::uint16_t i = 0; i < 5; ++i)
        node.variables.push_back(
            variable("V" + std::to_string(i), DataType::int16, 3 * i, Function::read_holding_registers));
    const auto described = project({node, device("Empty", 2)});
    const auto built = build_owen(described, plan::make_plan(described));
    EXPECT_EQ(read_owen(write_owen(built.table)).value(), built.table);
}

// Written in a group whose members were read in two: the buffer's order is the one of reading.
TEST(Owen, MembersLieSideBySide) {
    auto node = device("Node", 1);
    for (std::uint16_t i = 0; i < 4; ++i)
        node.variables.push_back(variable("V" + std::to_string(i), DataType::int16, i,
                                          Function::read_holding_registers,
                                          Function::write_multiple_registers));
    for (auto& v : node.variables) v.write_on_change = true;
    node.variables[2].period = node.variables[3].period = 200ms;
    const auto described = project({node});
    const auto built = build_owen(described, plan::make_plan(described));
    ASSERT_TRUE(built.findings.empty());
    for (const auto& entry : built.table.entries) {
        EXPECT_EQ(entry.quantity, 2);
        EXPECT_EQ(entry.data, entry.start + 1);
    }
}

TEST(Owen, RefusesByName) {
    auto node = device("Node", 1);
    node.variables = {variable("Wide", DataType::float64, 0, Function::read_holding_registers),
                      variable("Text", DataType::string, 10, Function::read_holding_registers),
                      variable("Scaled", DataType::int16, 20, Function::read_holding_registers),
                      variable("Swapped", DataType::int16, 30, Function::read_holding_registers),
                      variable("Fine", DataType::uint16, 40, Function::read_holding_registers)};
    node.variables[2].scale = 0.1;
    node.variables[3].order.high_byte_first = false;
    EXPECT_EQ(refusals(project({node})),
              (std::vector<std::string>{"table.type Wide", "table.type Text", "table.scale Scaled",
                                        "table.byte_order Swapped"}));
}

TEST(Owen, RefusesWhatItsEntriesCannotSay) {
    auto node = device("Node", 1);
    node.variables = {variable("A", DataType::int16, 0, Function::read_holding_registers),
                      variable("B", DataType::int16, 2, Function::read_holding_registers),
                      variable("C", DataType::float32, 3, Function::read_holding_registers)};
    const auto described = project({node});
    plan::Plan planned;
    auto& line = planned.lines.emplace_back();
    plan::Request request;
    request.variables = {0, 1, 2};
    request.read = Function::read_holding_registers;
    request.write = Function::read_write_multiple_registers;
    request.quantity = 5;
    request.period = 1500us;
    request.phase = 10ms;
    request.read_modify_write = true;
    request.admission = model::RateLimit{1s, 1};
    line.requests = {request};
    std::vector<std::string> codes;
    for (const auto& finding : build_owen(described, planned).findings)
        codes.push_back(finding.code + " " + finding.path);
    EXPECT_EQ(codes, (std::vector<std::string>{"table.function A", "table.phase A",
                                               "table.read_modify_write A", "table.admission A",
                                               "table.period A", "table.gap B", "table.mixed_types C"}));
}

// A bit of a register is read in a group and written by an entry of its own.
TEST(Owen, WritesABitOfARegister) {
    auto node = device("Node", 1);
    node.read_modify_write = true;
    node.variables = {variable("A", DataType::boolean, 5, Function::read_holding_registers),
                      variable("B", DataType::boolean, 5, Function::read_holding_registers)};
    for (std::uint8_t bit = 0; auto& v : node.variables) {
        v.bit = bit++;
        v.write = Function::write_single_register;
        v.write_on_change = true;
    }
    const auto described = project({node});
    const auto plan = plan::make_plan(described);
    const auto built = build_owen(described, plan);
    EXPECT_TRUE(built.findings.empty());
    ASSERT_EQ(built.table.entries.size(), 3U);
    EXPECT_EQ(built.table.entries[0].quantity, 2);
    const auto& second = built.table.entries[2];
    EXPECT_EQ(second.type_and_bit, OwenEntry::kBit | 1 << 4);
    EXPECT_EQ(second.read, 0);
    EXPECT_EQ(second.write, 0x06);
    EXPECT_EQ(second.flags, OwenEntry::kWrittenOnChange);
    EXPECT_EQ(second.quantity, 1);
    EXPECT_EQ(second.start, 5);
    EXPECT_EQ(second.data, built.table.entries[0].data + 1);
}

// The restored project makes the same table again.
TEST(Owen, IsRestored) {
    auto node = device("Node", 3);
    node.read_modify_write = true;
    node.variables = {variable("B", DataType::boolean, 5, Function::read_holding_registers),
                      variable("W", DataType::int16, 6, Function::read_holding_registers),
                      variable("D", DataType::int32, 7, Function::read_holding_registers),
                      variable("E", DataType::int32, 9, Function::read_holding_registers)};
    node.variables[0].bit = std::uint8_t{4};
    node.variables[0].write = Function::write_single_register;
    node.variables[2].write = node.variables[3].write = Function::write_multiple_registers;
    for (auto& v : node.variables) v.write_on_change = v.write.has_value();
    node.variables[1].period = 50ms;
    node.variables[1].read_trigger = 0;
    auto described = project({node});
    described.locals = {local("go")};
    const auto plan = plan::make_plan(described);
    const auto table = build_owen(described, plan).table;
    const auto restore = [](const OwenTable& of) {
        return restored(OwenView::open(write_owen(of)).value()).value();
    };
    const auto back = restore(table);
    EXPECT_EQ(build_owen(back.project, back.plan).table, table);
    ASSERT_EQ(back.plan.lines.size(), 1U);
    EXPECT_EQ(back.plan.lines[0].cycle, plan.lines[0].cycle);
    EXPECT_EQ(back.plan.lines[0].utilization, plan.lines[0].utilization);
    ASSERT_EQ(back.plan.lines[0].requests.size(), plan.lines[0].requests.size());
    for (std::size_t i = 0; i < plan.lines[0].requests.size(); ++i) {
        const auto& got = back.plan.lines[0].requests[i];
        const auto& made = plan.lines[0].requests[i];
        EXPECT_EQ(
            std::tie(got.read, got.write, got.start, got.quantity, got.period, got.read_modify_write),
            std::tie(made.read, made.write, made.start, made.quantity, made.period, made.read_modify_write));
    }
    // An entry with a function that no controller has makes no request.
    auto foreign = table;
    foreign.entries[0].read = 0x63;
    EXPECT_EQ(restore(foreign).plan.lines[0].requests.size(), plan.lines[0].requests.size() - 1);
}

// `table show` prints no table that `run` refuses.
TEST(Owen, ATableThatContradictsItselfIsNotRead) {
    auto node = device("Node", 3);
    node.variables = {variable("A", DataType::int16, 0, Function::read_holding_registers),
                      variable("B", DataType::float32, 9, Function::read_holding_registers)};
    const auto described = project({node});
    auto table = build_owen(described, plan::make_plan(described)).table;
    ASSERT_EQ(table.entries.size(), 2U);
    ASSERT_TRUE(read_owen(write_owen(table)));
    table.entries[1].data = table.entries[0].data;
    const auto image = write_owen(table);
    const auto run = restored(OwenView::open(image).value());
    ASSERT_FALSE(run);
    const auto shown = read_owen(image);
    ASSERT_FALSE(shown);
    EXPECT_EQ(shown.error(), run.error());
}

TEST(Owen, EveryRefusalHasItsWords) {
    for (const auto code : owen_codes())
        for (const auto language : text::kLanguages) {
            EXPECT_TRUE(text::has(language, code)) << code;
            EXPECT_TRUE(text::has(language, std::string(code) + ".advice")) << code;
        }
}

}  // namespace owen_test
}  // namespace takt::table
