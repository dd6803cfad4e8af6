#include "live/live_hub.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "running_host.hpp"

namespace takt::web {
namespace live_hub_test {

using namespace test;

const std::string kProject = host::test::project_with(
    host::test::line_of("plant", host::test::boiler() + host::test::pump()), "- {name: go, type: bool}\n");

struct Fixture : ::testing::Test {
    RunningHost running{kProject};
    std::atomic<int> pokes = 0;
    LiveHub hub{running.access(), [this] { ++pokes; }};
};

using LiveHubTest = Fixture;

TEST_F(LiveHubTest, BeginsWithAllValuesThenChangesAndTheState) {
    const auto stream = hub.open(text::Language::english);
    ASSERT_TRUE(stream);
    const auto text = take_until(*stream, [](const std::string& its) {
        return its.find("event: status") != std::string::npos && count_of(its, "event: values") >= 2;
    });
    EXPECT_TRUE(text.starts_with("event: snapshot\ndata: {\"generation\":1,\"time\":"))
        << text.substr(0, 300);
    EXPECT_NE(text.find("\"name\":\"Level\",\"line\":\"plant\",\"device\":"), std::string::npos);
    EXPECT_NE(text.find("\"area\":\"holding\""), std::string::npos);
    EXPECT_NE(text.find("\"outputs\":[]"), std::string::npos);
    EXPECT_EQ(text.find("event: snapshot", 1), std::string::npos);
    EXPECT_GT(pokes, 0);
}

// The registers of a simulated device that can be written stay as they are.
TEST(LiveHub, ReportsReadsThatFindValuesUnchanged) {
    const auto constant = [](const std::string& name, int reg) {
        return "          - {name: " + name + ", type: string, length: 2, register: " + std::to_string(reg) +
               ", read: 0x03}\n";
    };
    RunningHost running(host::test::project_with(host::test::line_of(
        "plant",
        host::test::device_of("Boiler", 1, constant("A", 0) + constant("B", 1) + constant("C", 50)))));
    LiveHub hub(running.access(), [] {});
    const auto stream = hub.open(text::Language::english);
    const auto text =
        take_until(*stream, [](const std::string& its) { return count_of(its, "event: reads") > 5; });
    const auto at = text.rfind("event: reads");
    const auto end = text.find('\n', text.find("data: ", at));
    const auto data = text.find("data: ", at) + 6;
    const auto event = file::Json::parse(text.substr(data, end - data));
    ASSERT_TRUE(event) << text.substr(at);
    const auto& reads = std::get<file::Json::Array>(event->find("reads")->value());
    ASSERT_FALSE(reads.empty());
    for (const auto& read : reads) EXPECT_EQ(std::get<file::Json::Array>(read.value()).size(), 3u);
}

TEST_F(LiveHubTest, GivesAllStreamsTheSameFramesEachInItsLanguage) {
    const auto english = hub.open(text::Language::english);
    const auto russian = hub.open(text::Language::russian);
    const auto first = take_until(*english, "event: status");
    const auto second = take_until(*russian, "event: status");
    EXPECT_EQ(first.substr(0, 100), second.substr(0, 100));
}

TEST_F(LiveHubTest, AdmitsALimitedNumberOfStreams) {
    std::vector<std::unique_ptr<StreamSource>> streams;
    for (std::size_t i = 0; i < LiveHub::kMostStreams; ++i)
        streams.push_back(hub.open(text::Language::english));
    EXPECT_TRUE(streams.back());
    EXPECT_FALSE(hub.open(text::Language::english));
    streams.pop_back();
    EXPECT_TRUE(hub.open(text::Language::english));
}

TEST_F(LiveHubTest, ReportsAChangedProject) {
    const auto stream = hub.open(text::Language::english);
    take_until(*stream, "event: status");
    running.apply(host::test::project_with(host::test::line_of("plant", host::test::pump())));
    const auto text = take_until(*stream, "\"generation\":2,\"time\"");
    EXPECT_NE(text.find("event: configuration\ndata: {\"generation\":2}"), std::string::npos);
    EXPECT_LT(text.find("event: configuration"), text.find("event: snapshot"));
    EXPECT_EQ(text.substr(text.rfind("event: snapshot")).find("\"Level\""), std::string::npos);
}

TEST(LiveHub, GivesASlowReaderANewSnapshot) {
    RunningHost running(kProject);
    LiveHub hub(running.access(), [] {}, 4);
    const auto slow = hub.open(text::Language::english);
    const auto quick = hub.open(text::Language::english);
    take_until(*slow, "event: values");
    take_until(*quick, [](const std::string& text) { return count_of(text, "event: ") > 10; });
    std::string rest;
    EXPECT_TRUE(slow->take(rest));
    EXPECT_EQ(rest, "");
    rest = take_until(*slow, "event: values");
    EXPECT_TRUE(rest.starts_with("event: snapshot")) << rest.substr(0, 100);
    EXPECT_EQ(count_of(rest, "event: snapshot"), 1u);
}

TEST_F(LiveHubTest, EndsItsStreams) {
    const auto stream = hub.open(text::Language::english);
    take_until(*stream, "event: snapshot");
    hub.end();
    std::string text;
    EXPECT_FALSE(stream->take(text));
    EXPECT_FALSE(hub.open(text::Language::english));
}

TEST(LiveHub, OutlivesItsHost) {
    RunningHost running(kProject);
    LiveHub hub(running.access(), [] {});
    const auto stream = hub.open(text::Language::english);
    take_until(*stream, "event: status");
    running.host->stop();
    std::this_thread::sleep_for(1200ms);  // past the next state
    hub.end();
}

TEST(LiveValues, HasTheRangeOfWrittenValues) {
    const auto variable = [](const std::string& name, const std::string& range) {
        return host::test::variable_of(name, 0, ", write: 0x06, write_range: " + range);
    };
    RunningHost running(host::test::project_with(host::test::line_of(
        "plant", host::test::device_of("Boiler", 1, variable("A", "-5..40") + variable("B", "0..")))));
    const auto session = running.host->open_session({.events = false});
    const auto snapshot = (*session)->snapshot({.values = true, .statistics = true});
    ASSERT_TRUE(snapshot);
    const auto text = LiveValues(*snapshot).list_text(snapshot->t);
    EXPECT_NE(text.find(R"("write_range":{"least":-5.0,"greatest":40.0})"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("write_range":{"least":0.0})"), std::string::npos);
}

TEST(LiveValues, MarksTriggersAndLocals) {
    RunningHost running(host::test::project_with(
        host::test::line_of(
            "plant",
            host::test::device_of("Boiler", 1, host::test::variable_of("Level", 0, ", read_trigger: go"))),
        "- {name: go, type: bool}\n- {name: limit, type: int}\n"));
    const auto session = running.host->open_session({.events = false});
    const auto snapshot = (*session)->snapshot({.values = true, .statistics = true});
    ASSERT_TRUE(snapshot);
    const auto text = LiveValues(*snapshot).list_text(snapshot->t);
    EXPECT_NE(text.find("\"writable\":true,\"trigger\":true,\"local\":true"), std::string::npos) << text;
    EXPECT_NE(text.find("\"writable\":true,\"trigger\":false,\"local\":true"), std::string::npos);
    EXPECT_NE(text.find("\"writable\":false,\"trigger\":false,\"local\":false"), std::string::npos);
}

}  // namespace live_hub_test
}  // namespace takt::web
