#include "live/event_log.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "devices/command_api.hpp"
#include "live/wall_time.hpp"
#include "running_host.hpp"

namespace takt::web {
namespace event_log_test {

using namespace std::chrono_literals;

constexpr const char* kProject =
    "{takt: 1, lines: [{name: plant, transport: simulated, devices: [{name: Tank, address: 1, poll_period: "
    "100ms, variables: [{name: Setpoint, type: int16, register: 0, read: 0x03, write: 0x06}]}]}], "
    "locals: [{name: Start, type: bool}]}";

class EventLogTest : public testing::Test {
protected:
    /// All events, once `enough` is true of them.
    file::Json::Array wait_for(const std::function<bool(const file::Json::Array&)>& enough) {
        file::Json::Array events;
        for (const auto end = std::chrono::steady_clock::now() + 10s;
             std::chrono::steady_clock::now() < end;) {
            events = std::get<file::Json::Array>(
                marks.json(text::Language::english, 0, INT64_MAX).find("events")->value());
            if (enough(events)) return events;
            std::this_thread::sleep_for(10ms);
        }
        ADD_FAILURE() << "missing: " << file::Json(std::move(events)).dump();
        return {};
    }
    static std::string text(const file::Json& event, std::string_view key) {
        const auto* const value = event.find(key);
        return value == nullptr ? "" : std::get<std::string>(value->value());
    }
    file::Json::Array commands(std::size_t count) {
        file::Json::Array found;
        wait_for([&](const file::Json::Array& events) {
            found.clear();
            std::ranges::copy_if(events, std::back_inserter(found),
                                 [](const auto& its) { return text(its, "kind") == "command"; });
            return found.size() >= count;
        });
        return found;
    }
    ApiResponse call(const std::string& body) {
        return command_routes(access, log, stopping)
            .front()
            .handler({.query = {}, .body = body, .texts = texts, .peer = "192.0.2.7"});
    }

    test::RunningHost running{kProject};
    const HostAccess access = running.access();
    const std::atomic<bool> stopping = false;
    const report::Texts texts{text::Language::english};
    Marks marks{WallTime().ms(access.started)};
    EventLog log{access, marks};
};

TEST_F(EventLogTest, KeepsCommandsOfBrowsersOnce) {
    EXPECT_EQ(call(R"({"kind":"write","variable":"Setpoint","value":"7"})").status, 200);
    EXPECT_EQ(call(R"({"kind":"trigger","variable":"Start"})").status, 200);
    EXPECT_EQ(call(R"({"kind":"set","variable":"Start","value":"false"})").status, 200);
    const auto found = commands(3);
    ASSERT_EQ(found.size(), 3u);
    EXPECT_EQ(text(found[0], "text"), "Setpoint = 7: acknowledged, not read back");
    EXPECT_EQ(text(found[0], "outcome"), "done");
    EXPECT_EQ(text(found[0], "severity"), "info");
    EXPECT_EQ(text(found[0], "origin"), "192.0.2.7");
    EXPECT_EQ(text(found[1], "text"), "Start = true");
    EXPECT_EQ(text(found[2], "text"), "Start = false");
}

TEST_F(EventLogTest, KeepsWritesOfOtherFaces) {
    const auto session = access.open_session({.events = false}).value();
    const auto slot = *session->configuration()->find("Setpoint");
    ASSERT_TRUE(
        session->submit({.kind = host::Command::Kind::write, .slot = slot, .value = std::int64_t{3}}));
    const auto found = commands(1);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(text(found[0], "text"), "Setpoint = 3: acknowledged, not read back");
    EXPECT_EQ(text(found[0], "origin"), "");
}

TEST(OutcomeText, NamesWhatAWriteProves) {
    using host::Command;
    const test::RunningHost running(
        "{takt: 1, lines: [{name: plant, transport: simulated, devices: ["
        "{name: Tank, address: 1, variables: ["
        "{name: Plain, type: int16, register: 0, read: 0x03, write: 0x06, unit: °C},"
        "{name: Scaled, type: int16, register: 1, read: 0x03, write: 0x06, scale: 0.5},"
        "{name: Verified, type: int16, register: 2, read: 0x03, write: 0x06, verify: true}]},"
        "{name: All, address: 0, variables: [{name: Sent, type: int16, register: 0, write: 0x06}]}]}],"
        "locals: [{name: Local, type: int16}]}");
    const auto configuration = running.host->configuration();
    const struct {
        std::string_view name;
        Command::Kind kind;
        value::Value value;
        bool rounded;
        std::string_view expected;
    } cases[] = {
        {"Plain", Command::Kind::write, std::int64_t{5}, false, "Plain = 5 °C: acknowledged, not read back"},
        {"Plain", Command::Kind::set, std::int64_t{5}, false, "Plain = 5 °C"},
        {"Scaled", Command::Kind::write, 2.4, true, "Scaled = 2.5: acknowledged, not read back"},
        {"Verified", Command::Kind::write, std::int64_t{5}, false, "Verified = 5: written and read back"},
        {"Sent", Command::Kind::write, std::int64_t{5}, false,
         "Sent = 5: sent; a broadcast is not acknowledged"},
        {"Local", Command::Kind::set, std::int64_t{5}, false, "Local = 5"},
    };
    for (const auto& [name, kind, value, rounded, expected] : cases) {
        host::Outcome outcome{.kind = kind, .slot = *configuration->find(name), .rounded = rounded};
        outcome.value = value;
        EXPECT_EQ(outcome_text(report::Texts(text::Language::english), *configuration, outcome), expected);
        EXPECT_EQ(outcome_word(outcome), "done");
    }
}

TEST_F(EventLogTest, KeepsMessagesFromTheStartOn) {
    const auto events = wait_for([](const file::Json::Array& its) {
        return std::ranges::any_of(its,
                                   [](const auto& one) { return text(one, "text") == "Tank: answering"; });
    });
    ASSERT_FALSE(events.empty());
    EXPECT_EQ(text(events.front(), "kind"), "message");
    const auto none = marks.json(text::Language::english, 0, 1);
    EXPECT_EQ(none.find("events")->dump(), "[]");
    const auto russian = marks.json(text::Language::russian, 0, INT64_MAX).dump();
    EXPECT_EQ(russian.find("answering"), std::string::npos) << russian;
}

TEST_F(EventLogTest, ForgetsTheOldestAndReportsSinceWhen) {
    const auto since = [this] {
        return std::get<std::int64_t>(marks.json(text::Language::english, 0, 1).find("since")->value());
    };
    const auto before = since();
    const auto configuration = access.configuration();
    const host::Outcome outcome{.slot = *configuration->find("Start"), .t = line::now(), .value = true};
    for (std::size_t i = 0; i <= Marks::kMost; ++i) log.add(outcome, *configuration, "192.0.2.7");
    EXPECT_GT(since(), before);
    EXPECT_EQ(commands(1).size(), Marks::kMost);
}

}  // namespace event_log_test
}  // namespace takt::web
