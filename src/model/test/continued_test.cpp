// Common parts of two projects: inserted lines that only move other parts are no difference.
#include "takt/model/continued.hpp"

#include <gtest/gtest.h>

#include <string>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace continued_test {

const std::string kBus =
    "{name: bus, port: /dev/ttyS7, devices: [{name: D, address: 1, variables: "
    "[{name: Level, type: int16, register: 0, read: 3, period: 1s}]}]}";
const std::string kScale =
    "{name: scale, port: /dev/ttyS8, exchanges: [{request: P, "
    "answer: {until: \";\", pattern: \"{weight}\"}}]}";

std::string server(const std::string& keys = "", const std::string& bindings = "") {
    return "{name: S, listen: ::, relay: [{line: bus, units: [7]}]" + keys +
           ", units: [{address: 1, banks: [{area: holding_register, items: [0..9]}], variables: "
           "[{name: A, type: int16, area: holding_register, register: 0, source: {variable: Level}}" +
           bindings + "]}]}";
}

struct Parts {
    std::string lines = kBus;
    std::string servers = server();
    std::string instruments = kScale;
};

Project project(const Parts& parts) {
    const std::string text = "{lines: [" + parts.lines + "], servers: [" + parts.servers +
                             "], instruments: [" + parts.instruments + "]}";
    auto checked = interpret(document({.project = text}));
    for (const auto& finding : checked.findings)
        EXPECT_NE(finding.severity, Severity::error)
            << finding.code << " " << finding.path << " " << finding.value;
    return std::move(checked.project);
}

TEST(Continued, AServerIsTheSameWhereverItIsWritten) {
    const auto before = project({});
    const auto other_line =
        "{name: first, port: /dev/ttyS6, devices: [{name: E, address: 1, "
        "variables: [{name: Speed, type: int16, register: 0, read: 3, period: 1s}]}]}, " +
        kBus;
    const auto now =
        project({.lines = other_line,
                 .servers = "{name: T, listen: ::, tcp_port: 503, units: [{address: 1, banks: []}]},\n\n " +
                            server()});
    EXPECT_EQ(continued_servers(before, now), (Continued{std::nullopt, 0}));
    EXPECT_EQ(continued_gateways(before, now), (Continued{std::nullopt, 0}));
    EXPECT_EQ(continued_instruments(before, now), (Continued{0}));
}

TEST(Continued, WhatAServerConsistsOf) {
    const struct {
        const char* what;
        Parts now;
        bool same;
    } rows[] = {
        {"nothing changed", {}, true},
        {"an access rule", {.servers = server(", access: [{functions: [read], rule: allow}]")}, true},
        {"its port", {.servers = server(", tcp_port: 503")}, false},
        {"a limit", {.servers = server(", max_connections: 7")}, false},
        {"its audit log", {.servers = server(", audit: x.audit")}, false},
        {"one more variable",
         {.servers = server("", ", {name: B, type: int16, area: holding_register, register: 1}")},
         false},
        {"the port of the line behind it",
         {.lines = "{name: bus, port: /dev/ttyS9, devices: [{name: D, address: 1, variables: [{name: Level, "
                   "type: int16, register: 0, read: 3, period: 1s}]}]}"},
         true},
        {"the framing of the line behind it",
         {.lines = "{name: bus, port: /dev/ttyS7, framing: ascii, devices: [{name: D, address: 1, variables: "
                   "[{name: Level, type: int16, register: 0, read: 3, period: 1s}]}]}"},
         false},
    };
    for (const auto& row : rows) {
        SCOPED_TRACE(row.what);
        EXPECT_EQ(continued_servers(project({}), project(row.now))[0].has_value(), row.same);
    }
}

TEST(Continued, AValueOfAnInstrumentFollowsTheInstrument) {
    const std::string bound =
        ", {name: W, type: float, area: holding_register, register: 2, source: "
        "{instrument: scale.weight}}";
    const auto before = project({.servers = server("", bound)});
    const std::string another =
        "{name: meter, port: /dev/ttyS5, exchanges: [{request: M, "
        "answer: {until: \";\", pattern: \"{flow}\"}}]}";
    auto now = project({.servers = server("", bound), .instruments = another + ", " + kScale});
    EXPECT_EQ(continued_instruments(before, now), (Continued{std::nullopt, 0}));
    EXPECT_EQ(continued_servers(before, now), (Continued{0}));
    now.instruments[1].timeout = std::chrono::seconds(7);
    EXPECT_EQ(continued_servers(before, now), (Continued{std::nullopt}));
}

}  // namespace continued_test
}  // namespace takt::model::test
