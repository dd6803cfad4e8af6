// The effect of each kind of fault on frames, seen at the other end.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>

#include "fault_plant.hpp"
#include "sim/faults/frames.hpp"
#include "sim/faults/line_faults.hpp"
#include "support.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {
namespace altered_frames_test {

using wire::Framing;

struct Received {
    ByteVector sent, received;
};

/// Answers on an RTU line that arrived otherwise than they were sent.
std::vector<Received> altered_answers(FaultKind kind, std::size_t sender = 1) {
    struct Keep final : WireObserver {
        void on_transmission(const Transmission& t) override {
            if (t.sender == sender && !t.collided && !std::ranges::equal(t.bytes, t.received))
                found.push_back({{t.bytes.begin(), t.bytes.end()}, {t.received.begin(), t.received.end()}});
        }
        std::size_t sender = 1;
        std::vector<Received> found;
    };
    Keep keep;
    keep.sender = sender;
    const model::Project described = project(Medium::rtu);
    const plan::Plan plan = plan::make_plan(described);
    poll::Master master(described, plan);
    SimulatedLine::Options options;
    options.faults = faults_of(only(kind));
    SimulatedLine line(described.lines[0], master.line(0), options);
    line.set_observer(&keep);
    line.start(at(0s));
    line.advance(at(30s));
    EXPECT_GE(keep.found.size(), 5u);
    return keep.found;
}

int different_bits(const ByteVector& a, const ByteVector& b) {
    int count = 0;
    for (std::size_t i = 0; i < a.size(); ++i) count += std::popcount(static_cast<unsigned>(a[i] ^ b[i]));
    return count;
}

bool is_subsequence(const ByteVector& part, const ByteVector& whole) {
    std::size_t found = 0;
    for (const std::uint8_t byte : whole) found += found < part.size() && part[found] == byte;
    return found == part.size();
}

TEST(AlteredFrames, CharactersAreSpoiledOnBothWays) {
    for (const std::size_t sender : {0u, 1u}) {
        for (const auto& [sent, received] : altered_answers(FaultKind::bit_error, sender)) {
            ASSERT_EQ(sent.size(), received.size());
            EXPECT_GE(different_bits(sent, received), 1);
            EXPECT_LE(different_bits(sent, received), 3);
        }
        for (const auto& [sent, received] : altered_answers(FaultKind::lost_byte, sender)) {
            EXPECT_EQ(received.size() + 1, sent.size());
            EXPECT_TRUE(is_subsequence(received, sent));
        }
        for (const FaultKind kind : {FaultKind::extra_byte, FaultKind::repeated_byte})
            for (const auto& [sent, received] : altered_answers(kind, sender)) {
                EXPECT_EQ(received.size(), sent.size() + 1);
                EXPECT_TRUE(is_subsequence(sent, received));
            }
    }
}

TEST(AlteredFrames, AnswersThatCheckAndAreWrong) {
    const auto opened = [](const ByteVector& frame) { return open_frame(Framing::rtu, frame); };
    for (const auto& [sent, received] : altered_answers(FaultKind::wrong_unit)) {
        ASSERT_TRUE(opened(received));
        EXPECT_NE(opened(received)->unit, opened(sent)->unit);
        EXPECT_EQ(opened(received)->pdu, opened(sent)->pdu);
    }
    for (const auto& [sent, received] : altered_answers(FaultKind::wrong_function)) {
        ASSERT_TRUE(opened(received));
        EXPECT_NE(opened(received)->pdu[0] & 0x7F, opened(sent)->pdu[0] & 0x7F);
    }
    for (const auto& [sent, received] : altered_answers(FaultKind::wrong_byte_count)) {
        ASSERT_TRUE(opened(received));
        EXPECT_NE(received.size(), sent.size());
        EXPECT_EQ(opened(received)->pdu.size(), 2u + opened(received)->pdu[1]);
    }
    bool beyond = false;
    for (const auto& [sent, received] : altered_answers(FaultKind::oversized)) {
        EXPECT_GT(received.size(), sent.size());
        beyond = beyond || received.size() > 200;
    }
    EXPECT_TRUE(beyond);
}

TEST(AlteredFrames, FramesThatAreCutDoubledOrReplaced) {
    for (const auto& [sent, received] : altered_answers(FaultKind::truncated)) {
        EXPECT_LT(received.size(), sent.size());
        EXPECT_TRUE(std::equal(received.begin(), received.end(), sent.begin()));
    }
    for (const auto& [sent, received] : altered_answers(FaultKind::duplicate_response)) {
        ByteVector twice = sent;
        twice.insert(twice.end(), sent.begin(), sent.end());
        EXPECT_EQ(received, twice);
    }
    for (const auto& [sent, received] : altered_answers(FaultKind::lost_response))
        EXPECT_TRUE(received.empty());
    for (const auto& [sent, received] : altered_answers(FaultKind::lost_request, 0))
        EXPECT_TRUE(received.empty());
    for (const auto& [sent, received] : altered_answers(FaultKind::garbage))
        EXPECT_FALSE(open_frame(Framing::rtu, received));
}

}  // namespace altered_frames_test
}  // namespace takt::sim
