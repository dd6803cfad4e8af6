#include "live/traffic_hub.hpp"

#include <gtest/gtest.h>

#include "running_host.hpp"

namespace takt::web {
namespace traffic_hub_test {

using namespace test;

const std::string kProject =
    host::test::project_with(host::test::line_of("plant", host::test::boiler() + host::test::pump()));

TEST(TrafficHub, StreamsFramesWithTheirWords) {
    RunningHost running(kProject);
    TrafficHub hub(running.access(), [] {});
    const auto stream = hub.open(text::Language::english);
    ASSERT_TRUE(stream);
    const auto text = take_until(*stream, [](const std::string& its) {
        return its.find("\"rx\"") != std::string::npos && its.find("\"tx\"") != std::string::npos;
    });
    EXPECT_NE(text.find("event: frames\ndata: [{\"t\":"), std::string::npos);
    EXPECT_NE(text.find("\"line\":\"plant\",\"device\":\"Boiler\",\"unit\":1"), std::string::npos);
    EXPECT_NE(text.find("read holding registers"), std::string::npos);
    const auto other = hub.open(text::Language::russian);
    const auto russian = take_until(*other, [](const std::string& its) { return its.ends_with("\n\n"); });
    EXPECT_NE(russian.find("чтение регистров хранения"), std::string::npos);
    EXPECT_EQ(russian.find("read holding"), std::string::npos);
}

TEST(TrafficHub, BeginsToRecordWithTheFirstCapture) {
    RunningHost running(kProject);
    TrafficHub hub(running.access(), [] {});
    EXPECT_EQ(hub.capture().value(), "");
    const auto frames = [&] { return hub.capture().value().find("Boiler") != std::string::npos; };
    const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!frames() && std::chrono::steady_clock::now() < limit)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_TRUE(frames());
}

TEST(TrafficHub, CapturesWhatTheTapSaw) {
    RunningHost running(kProject);
    TrafficHub hub(running.access(), [] {});
    {
        const auto stream = hub.open(text::Language::english);
        take_until(*stream, "\"rx\"");
    }
    const auto capture = hub.capture();
    ASSERT_TRUE(capture);
    EXPECT_GT(capture->size(), 300u);
    EXPECT_NE(capture->find("plant"), std::string::npos);
    EXPECT_NE(capture->find("Boiler"), std::string::npos);
}

TEST(TrafficHub, AdmitsALimitedNumberOfStreamsAndEndsThem) {
    RunningHost running(kProject);
    TrafficHub hub(running.access(), [] {});
    std::vector<std::unique_ptr<StreamSource>> streams;
    for (std::size_t i = 0; i < TrafficHub::kMostStreams; ++i)
        streams.push_back(hub.open(text::Language::english));
    EXPECT_FALSE(hub.open(text::Language::english));
    hub.end();
    std::string text;
    EXPECT_FALSE(streams[0]->take(text));
}

}  // namespace traffic_hub_test
}  // namespace takt::web
