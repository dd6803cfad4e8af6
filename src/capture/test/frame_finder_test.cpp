// Frames among the bytes of a line: chunks of any size, noise, damaged frames, frames without silences.
#include "takt/capture/frame_finder.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "hex.hpp"

namespace takt::capture {
namespace frame_finder_test {

using namespace std::chrono_literals;
using takt::test::from_hex;
using takt::test::to_hex;

struct Kept final : LineSink {
    std::string text;
    std::vector<std::pair<Instant, Instant>> times;
    void on_frame(const LineFrame& frame) override {
        text += std::to_string(frame.unit) + ":" + to_hex(frame.pdu) + " ";
        times.emplace_back(frame.begin, frame.end);
    }
    void on_damaged(const DamagedBytes& damaged) override {
        text += "!" + std::to_string(damaged.bytes.size()) + " ";
        times.emplace_back(damaged.begin, damaged.end);
    }
};

constexpr Instant at(Duration t) {
    return Instant(t);
}

std::vector<std::uint8_t> frame(std::string_view pdu, std::uint8_t unit = 1,
                                wire::Framing framing = wire::Framing::rtu) {
    const auto encoded = wire::encode_frame(framing, UnitId{unit}, 0, from_hex(pdu));
    return {encoded.begin(), encoded.end()};
}

std::vector<std::uint8_t> joined(const std::vector<std::vector<std::uint8_t>>& parts) {
    std::vector<std::uint8_t> all;
    for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

const auto kRequest = frame("03 00 00 00 02");
const auto kResponse = frame("03 04 00 01 00 02");
constexpr const char* kBoth = "1:0300000002 1:030400010002 ";

std::string strip(std::string text) {
    std::erase(text, ' ');
    return text;
}

TEST(FrameFinder, CutsAtEachPositionAndInOneChunk) {
    const auto all = joined({kRequest, kResponse});
    for (std::size_t cut = 0; cut <= all.size(); ++cut) {
        Kept kept;
        FrameFinder finder({}, kept);
        finder.push(at(0ms), Bytes(all).first(cut));
        finder.push(at(1ms), Bytes(all).subspan(cut));
        EXPECT_EQ(strip(kept.text), strip(kBoth)) << cut;
    }
}

TEST(FrameFinder, TimesFollowFromTheCharactersOfAChunk) {
    Kept kept;
    FrameFinder finder({.character = 1ms}, kept);
    finder.push(at(100ms), joined({kRequest, kResponse}));
    ASSERT_EQ(kept.times.size(), 2U);
    EXPECT_EQ(kept.times[1], std::pair(at(91ms), at(100ms)));
    EXPECT_EQ(kept.times[0], std::pair(at(83ms), at(91ms)));
}

TEST(FrameFinder, FindsTheNextFrameBehindADamagedOne) {
    auto damaged = kRequest;
    damaged[5] ^= 1;
    Kept kept;
    FrameFinder finder({}, kept);
    finder.push(at(0ms), joined({damaged, kResponse, kRequest}));
    EXPECT_EQ(kept.text.substr(0, 3), "!8 ");
    finder.on_tick(at(100ms));
    EXPECT_EQ(strip(kept.text), strip("!8 1:030400010002 1:0300000002 "));
}

TEST(FrameFinder, AnIncompleteFrameIsDamagedAfterThePause) {
    Kept kept;
    FrameFinder finder({}, kept);
    EXPECT_EQ(finder.next_wakeup(), kNever);
    finder.push(at(0ms), Bytes(kRequest).first(7));
    EXPECT_EQ(finder.next_wakeup(), at(30ms) + 1ns);
    finder.on_tick(at(30ms));
    EXPECT_EQ(kept.text, "");
    finder.on_tick(finder.next_wakeup());
    EXPECT_EQ(kept.text, "!7 ");
    finder.push(at(60ms), Bytes(kResponse).first(3));
    finder.push(at(200ms), kRequest);
    EXPECT_EQ(strip(kept.text), strip("!7 !3 1:0300000002 "));
}

TEST(FrameFinder, DataInsideALongFramePassForNoFrame) {
    const auto response = frame("03 10 " + to_hex(kRequest) + " 00 00 00 00 00 00 00 00");
    for (std::size_t cut = 1; cut < response.size(); ++cut) {
        Kept kept;
        FrameFinder finder({}, kept);
        finder.push(at(0ms), Bytes(response).first(cut));
        finder.push(at(5ms), Bytes(response).subspan(cut));
        EXPECT_EQ(kept.times.size(), 1U) << cut << ": " << kept.text;
    }
}

TEST(FrameFinder, AFrameOfAnUnknownFunctionEndsAtThePause) {
    for (const bool known_only : {false, true}) {
        Kept kept;
        FrameFinder finder({.known_only = known_only}, kept);
        finder.push(at(0ms), frame("65 01 02 03"));
        finder.on_tick(at(100ms));
        EXPECT_EQ(strip(kept.text), known_only ? "!7" : "1:65010203");
    }
}

TEST(FrameFinder, ARequestAndResponseOfAnUnknownFunctionAreTwoFrames) {
    const auto request = frame("41 01 02 03 04");
    const auto response = frame("41 AA BB");
    const auto refused = frame("C1 01");
    for (const auto& next :
         {std::vector<std::uint8_t>{}, kRequest, std::vector<std::uint8_t>{1, 0x42, 3, 4, 5}}) {
        Kept kept;
        FrameFinder finder({}, kept);
        finder.push(at(0ms), request);
        finder.push(at(5ms), response);
        finder.push(at(10ms), joined({request, refused}));
        finder.push(at(15ms), next);
        finder.end();
        const std::string after = next.empty() ? "" : next == kRequest ? "1:0300000002" : "!5";
        EXPECT_EQ(strip(kept.text), "1:41010203041:41AABB1:41010203041:C101" + after);
    }
    Kept kept;
    FrameFinder finder({.known_only = true}, kept);
    finder.push(at(0ms), joined({request, response}));
    finder.end();
    EXPECT_EQ(strip(kept.text), "!14");
}

TEST(FrameFinder, FindsAsciiFrames) {
    const auto request = frame("03 00 00 00 02", 1, wire::Framing::ascii);
    auto damaged = request;
    damaged[3] = 'x';
    Kept kept;
    FrameFinder finder({.framing = wire::Framing::ascii, .pause = 1s}, kept);
    finder.push(at(0ms), joined({{0x55}, request, damaged, request}));
    EXPECT_EQ(strip(kept.text), strip("!1 1:0300000002 !17 1:0300000002 "));
    finder.push(at(10ms), Bytes(request).first(5));
    finder.push(at(20ms), request);
    finder.push(at(30ms), Bytes(request).first(5));
    finder.end();
    EXPECT_EQ(strip(kept.text), strip("!1 1:0300000002 !17 1:0300000002 !5 1:0300000002 !5 "));
}

TEST(FrameFinder, ReportsEveryByteOnceAndFindsTheFramesInAnyNoise) {
    std::mt19937 rng(1);
    int found = 0;
    constexpr int kRounds = 300;
    for (int round = 0; round < kRounds; ++round) {
        std::vector<std::uint8_t> all(rng() % 1500);
        for (auto& byte : all) byte = static_cast<std::uint8_t>(rng());
        all.insert(all.end(), kRequest.begin(), kRequest.end());
        struct Count final : LineSink {
            std::size_t bytes = 0;
            bool request = false;
            void on_frame(const LineFrame& frame) override {
                bytes += frame.raw.size();
                request = request || to_hex(frame.raw) == to_hex(kRequest);
            }
            void on_damaged(const DamagedBytes& damaged) override { bytes += damaged.bytes.size(); }
        } count;
        FrameFinder finder({}, count);
        for (std::size_t done = 0; done < all.size();) {
            const auto size = std::min<std::size_t>(1 + rng() % 60, all.size() - done);
            finder.push(at(done * 1us), Bytes(all).subspan(done, size));
            done += size;
        }
        finder.end();
        EXPECT_EQ(count.bytes, all.size());
        found += count.request ? 1 : 0;
    }
    EXPECT_EQ(found, kRounds);
}

}  // namespace frame_finder_test
}  // namespace takt::capture
