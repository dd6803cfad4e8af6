#include "takt/console/served.hpp"

#include <gtest/gtest.h>

#include "support.hpp"

namespace takt::console {
namespace {

using namespace test;

TEST(PutNotice, WarningsAreErrorsAndTheRestIsStatus) {
    std::string status;
    std::string error;
    const Messages messages{[&](const std::string& text) { status += text; },
                            [&](const std::string& text) { error += text; }};
    const auto serving = endpoint::make_notice("app.serving", {{"where", "tcp://127.0.0.1:1502"}});
    put_notice(english(), messages, serving);
    EXPECT_TRUE(status.ends_with('\n'));
    EXPECT_NE(status.find("tcp://127.0.0.1:1502"), std::string::npos) << status;
    EXPECT_EQ(error, "");
    put_notice(english(), messages, endpoint::make_notice("app.serve.unknown", {}));
    EXPECT_NE(error, "");
    EXPECT_FALSE(error.ends_with('\n'));
}

endpoint::Statistics statistics() {
    endpoint::Statistics statistics;
    auto& listener = statistics.listeners.emplace_back();
    listener.where = "tcp://127.0.0.1:1502";
    listener.counters.requests = 5;
    auto& connections = listener.connections.emplace();
    connections.counters.accepted = 3;
    connections.bad_headers = 2;
    statistics.listeners.emplace_back().where = "rtu /dev/ttyS1";
    statistics.retained.push_back({UnitId{4}, "plant.registers", {}});
    statistics.retained[0].written.commits = 9;
    statistics.relayed.push_back({0, {}});
    statistics.relayed[0].counters.asked = 12;
    statistics.relayed[0].counters.shared = 4;
    return statistics;
}

TEST(SummaryOf, HasEveryListenerAndFile) {
    const auto summary = summary_of(statistics());
    ASSERT_EQ(summary.endpoints.size(), 2U);
    EXPECT_EQ(summary.endpoints[0].counters.requests, 5U);
    ASSERT_TRUE(summary.endpoints[0].connections);
    EXPECT_EQ(summary.endpoints[0].connections->accepted, 3U);
    EXPECT_EQ(summary.endpoints[0].connections->bad_headers, 2U);
    EXPECT_FALSE(summary.endpoints[1].connections);
    ASSERT_EQ(summary.retained.size(), 1U);
    EXPECT_EQ(summary.retained[0].commits, 9U);
}

TEST(Relayed, NamesTheLineOfEachCounter) {
    const auto project = host::test::project_of(kPlant);
    const auto json = relayed_json(project, statistics());
    EXPECT_TRUE(json.starts_with(R"({"event":"relayed","line":"main","asked":12,)")) << json;
    EXPECT_NE(json.find(R"("shared":4)"), std::string::npos);
    const auto text = relayed_text(english(), project, statistics());
    EXPECT_NE(text.find("main"), std::string::npos);
    EXPECT_NE(text.find("12"), std::string::npos);
    EXPECT_EQ(relayed_text(english(), project, {}), "");
}

}  // namespace
}  // namespace takt::console
