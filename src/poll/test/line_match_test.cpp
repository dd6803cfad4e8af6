#include "line/line_match.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "bench.hpp"
#include "line/transfer.hpp"

namespace takt::poll::test {
namespace line_match_test {

wire::PreparedRead a_read() {
    return prepared({Function::read_holding_registers, DataAddress{0}, 1});
}

/// A line of one device: one request polls its variables "a" and "b", and writes them on change.
struct Line {
    explicit Line(const std::function<void(Line&)>& change = {}) {
        described = device(5, {int16("a", 0).read(3).write(0x10), int16("b", 1).read(3).write(0x10)});
        request.read = Function::read_holding_registers;
        request.write = Function::write_multiple_registers;
        request.quantity = 2;
        request.period = 100ms;
        if (change) change(*this);
        devices.resize(1);
        devices[0].model = &described;
        for (const auto& variable : described.variables) variables.push_back({.model = &variable});
        requests.resize(1);
        requests[0].plan = &request;
        for (std::size_t v = 0; v < variables.size(); ++v) requests[0].variables.push_back(v);
        requests[0].read = ReadJob{.request = a_read()};
    }
    [[nodiscard]] LineTables tables() const { return {variables, devices, requests}; }

    model::Device described;
    plan::Request request;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
};

TEST(LineMatch, WhatAChangeKeeps) {
    struct Case {
        const char* what;
        std::function<void(Line&)> change;
        bool device, variable_a, read, write;
    };
    const Case kCases[] = {
        {"nothing", [](Line&) {}, true, true, true, true},
        {"name of the device", [](Line& line) { line.described.name = "Other"; }, false, false, false, false},
        {"address", [](Line& line) { line.described.address = UnitId{6}; }, false, false, false, false},
        {"attempts", [](Line& line) { ++line.described.attempts; }, false, false, false, false},
        {"time-out", [](Line& line) { line.described.response_timeout = 5s; }, true, true, true, true},
        {"name of a variable", [](Line& line) { line.described.variables[0].name = "x"; }, true, false, false,
         true},
        {"register of a variable", [](Line& line) { line.described.variables[0].register_number = 9; }, true,
         false, false, true},
        {"type of a variable", [](Line& line) { line.described.variables[0].type = DataType::uint16; }, true,
         false, false, true},
        {"unit of a variable", [](Line& line) { line.described.variables[0].scale = 2; }, true, true, true,
         true},
        {"period of the request", [](Line& line) { line.request.period = 1s; }, true, true, false, true},
        {"function of the write", [](Line& line) { line.request.write = Function::write_single_register; },
         true, true, true, false},
        {"order of the variables",
         [](Line& line) { std::swap(line.described.variables[0], line.described.variables[1]); }, true, true,
         false, true},
    };
    const Line old;
    for (const auto& c : kCases) {
        SCOPED_TRACE(c.what);
        const Line now(c.change);
        const LineMatch match(now.tables(), old.tables());
        EXPECT_EQ(match.device(0).has_value(), c.device);
        std::size_t a = 0;
        while (a < 2 && now.described.variables[a].name != "a") ++a;
        EXPECT_EQ(match.variable(a % 2) == 0U, c.variable_a);
        EXPECT_EQ(match.read(0).has_value(), c.read);
        EXPECT_EQ(match.same_write(0, 0), c.write);
    }
}

TEST(LineMatch, ComparesVariablesByTheirOldIndices) {
    const Line old;
    const Line now([](Line& line) {
        std::swap(line.described.variables[0], line.described.variables[1]);
        line.described.variables.push_back(int16("c", 2).read(3));
    });
    const LineMatch match(now.tables(), old.tables());
    const std::size_t kA[] = {1};
    const std::size_t kBoth[] = {1, 0};
    const std::size_t kNew[] = {2};
    const std::size_t kOldA[] = {0};
    const std::size_t kOldBoth[] = {0, 1};
    EXPECT_TRUE(match.same_variables(kA, kOldA));
    EXPECT_TRUE(match.same_variables(kBoth, kOldBoth));
    EXPECT_FALSE(match.same_variables(kA, kOldBoth));
    EXPECT_FALSE(match.same_variables(kNew, kOldA));
    EXPECT_TRUE(match.share_variables(kBoth, kOldA));
    EXPECT_FALSE(match.share_variables(kNew, kOldBoth));
    EXPECT_FALSE(match.variable(2));
}

}  // namespace line_match_test
}  // namespace takt::poll::test
