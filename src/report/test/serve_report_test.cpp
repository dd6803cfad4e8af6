#include "takt/report/states/serve_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"

namespace takt::report {
namespace serve_report_test {

using namespace test;

endpoint::ListenerStatistics listener(std::string where) {
    endpoint::ListenerStatistics made;
    made.where = std::move(where);
    made.counters.requests = 100;
    made.counters.answers = 98;
    made.counters.exceptions = 3;
    made.counters.faults[1] = 2;
    made.counters.faults[3] = 5;
    return made;
}

TEST(ServeReport, ALineForEachEndpoint) {
    const endpoint::Statistics summary{
        .listeners = {listener("rtu /dev/ttyUSB0 19200 bit/s"), listener("rtu /dev/ttyS1")}};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = served_text(texts, summary);
        EXPECT_EQ(count_of(text, "\n"), 2U);
        expect_complete(text);
        expect_contains(text, texts("app.served", {{"where", "rtu /dev/ttyS1"},
                                                   {"requests", "100"},
                                                   {"answers", "98"},
                                                   {"exceptions", "3"},
                                                   {"dropped", "7"}}));
    }
    EXPECT_EQ(served_text(english(), {}), "");
}

TEST(ServeReport, RefusedAndEndedConnectionsOnlyWhereThereAreAny) {
    endpoint::Statistics all{.listeners = {listener("tcp://127.0.0.1:1502")}};
    all.listeners[0].connections = endpoint::ListenerStatistics::Connections{};
    auto& counters = all.listeners[0].connections->counters;
    counters.accepted = 9;
    EXPECT_EQ(count_of(served_text(english(), all), "\n"), 2U);
    counters.refused = 6;
    counters.over_limit = 1;
    counters.over_peer_limit = 2;
    counters.no_descriptors = 3;
    EXPECT_EQ(count_of(served_text(english(), all), "\n"), 3U);
    counters.write_stalls = 4;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = served_text(texts, all);
        EXPECT_EQ(count_of(text, "\n"), 4U);
        expect_complete(text);
        expect_contains(text, texts("app.served_refused", {{"where", "tcp://127.0.0.1:1502"},
                                                           {"count", "6"},
                                                           {"limit", "1"},
                                                           {"peer", "2"},
                                                           {"descriptors", "3"},
                                                           {"tls", "0"}}));
        expect_contains(text, texts("app.served_ended", {{"where", "tcp://127.0.0.1:1502"},
                                                         {"count", "4"},
                                                         {"header", "0"},
                                                         {"frame", "0"},
                                                         {"idle", "0"},
                                                         {"unread", "4"},
                                                         {"evicted", "0"}}));
    }
}

TEST(ServeReport, RetainedRegistersOfEachUnit) {
    const endpoint::Statistics summary{
        .retained = {{UnitId{1}, "a.regs", {10, 4096, 0}}, {UnitId{247}, "б.regs", {1, 2, 3}}}};
    for (const auto language : kLanguages) {
        const auto text = served_text(Texts(language), summary);
        EXPECT_EQ(count_of(text, "\n"), 2U);
        expect_contains(text, "4096");
        expect_contains(text, "б.regs");
        expect_complete(text);
    }
}

TEST(ServeReport, JsonOfAnEndpoint) {
    endpoint::Statistics all{.listeners = {listener("tcp://127.0.0.1:1502")}};
    all.listeners[0].connections = endpoint::ListenerStatistics::Connections{};
    auto& connections = *all.listeners[0].connections;
    connections.counters.accepted = 9;
    connections.counters.over_limit = 1;
    connections.bad_headers = 2;
    const auto line = served_json(all);
    ASSERT_TRUE(line.ends_with('\n'));
    const auto json = file::Json::parse(line).value();
    const auto& served = at(json, "served", 0);
    EXPECT_JSON(at(served, "where"), "tcp://127.0.0.1:1502");
    EXPECT_JSON(at(served, "requests"), 100);
    EXPECT_JSON(at(served, "dropped", wire::name(wire::FrameFault{1})), 2);
    EXPECT_EQ(at(served, "connections").dump(),
              R"({"accepted":9,"refused":{"connections":1,"connections_per_peer":0,"descriptors":0,"tls":0},)"
              R"("ended":{"bad_header":2,"frame_timeout":0,"idle_timeout":0,"unread":0,"evicted":0}})");
    EXPECT_EQ(json.find("event"), nullptr);
    EXPECT_EQ(json.find("retained"), nullptr);
}

TEST(ServeReport, JsonAsAnEventWithRetainedRegisters) {
    const auto line = served_json(
        {.listeners = {listener("rtu \"x\"\n")}, .retained = {{UnitId{7}, "a\\b", {10, 4096, 1}}}}, "served");
    EXPECT_TRUE(line.starts_with(R"({"event":"served",)")) << line;
    EXPECT_EQ(count_of(line, "\n"), 1U) << "one line for names of any content";
    const auto json = file::Json::parse(line).value();
    EXPECT_JSON(at(json, "served", 0, "where"), "rtu \"x\"\n");
    EXPECT_EQ(at(json, "served", 0).find("connections"), nullptr);
    EXPECT_EQ(at(json, "retained").dump(),
              R"([{"unit":7,"file":"a\\b","commits":10,"bytes":4096,"failures":1}])");
    EXPECT_EQ(served_json({}), "{\"served\":[]}\n");
}

TEST(ServeReport, RelayedRequestsOfEachLine) {
    model::Project project;
    project.lines.emplace_back().name = "main";
    endpoint::Statistics all{.relayed = {{0, {}}}};
    all.relayed[0].counters.asked = 12;
    all.relayed[0].counters.shared = 4;
    const auto json = relayed_json(project, all);
    EXPECT_TRUE(json.starts_with(R"({"event":"relayed","line":"main","asked":12,)")) << json;
    EXPECT_NE(json.find(R"("shared":4)"), std::string::npos);
    for (const auto language : kLanguages) {
        const auto text = relayed_text(Texts(language), project, all);
        expect_contains(text, "main");
        expect_contains(text, "12");
        expect_complete(text);
    }
    EXPECT_EQ(relayed_text(english(), project, {}), "");
}

}  // namespace serve_report_test
}  // namespace takt::report
