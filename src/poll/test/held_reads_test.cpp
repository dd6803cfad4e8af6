#include "../held_reads.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::poll {
namespace held_reads_test {

using Verdict = HeldReads::Verdict;

HeldRead read_of(std::size_t device, std::size_t request) {
    static std::vector<std::uint8_t> bytes;
    const wire::PreparedRequest asked(std::vector<std::uint8_t>{3, 0, 0, 0, 1});
    bytes = {3, 2, static_cast<std::uint8_t>(request >> 8U), static_cast<std::uint8_t>(request)};
    HeldRead made{.device = device, .request = request, .outcome = {}, .response = {}};
    made.outcome.response = wire::decode_response(asked.shape(), asked.pdu(), bytes).value();
    return made;
}

std::size_t carried(const HeldRead& read) {
    const auto pdu = read.outcome.response.pdu();
    return static_cast<std::size_t>(pdu[2] << 8U | pdu[3]);
}

TEST(HeldReads, AreSettledInTheirOrderAndKeepTheirResponses) {
    HeldReads held;
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(held.add(read_of(i % 2, i)), nullptr);
    std::vector<std::size_t> settled;
    const auto publish = [&](const HeldRead& read, value::Quality quality) {
        EXPECT_EQ(quality, read.request == 1 ? value::Quality::uncertain : value::Quality::good);
        EXPECT_EQ(carried(read), read.request);
        settled.push_back(read.request);
    };
    held.settle(
        [](const HeldRead& read) {
            if (read.device == 0) return Verdict::waits;
            return read.request == 1 ? Verdict::uncertain : Verdict::good;
        },
        publish);
    EXPECT_EQ(settled, (std::vector<std::size_t>{1, 3, 5}));
    held.settle([](const HeldRead&) { return Verdict::good; }, publish);
    EXPECT_EQ(settled, (std::vector<std::size_t>{1, 3, 5, 0, 2, 4}));
    EXPECT_TRUE(held.empty());
}

TEST(HeldReads, GiveUpTheOldestOfTooMany) {
    HeldReads held;
    for (std::size_t i = 0; i < HeldReads::kMost; ++i) EXPECT_EQ(held.add(read_of(0, i)), nullptr);
    for (std::size_t i = 0; i < 3; ++i) {
        const auto* const oldest = held.add(read_of(0, HeldReads::kMost + i));
        ASSERT_NE(oldest, nullptr);
        EXPECT_EQ(oldest->request, i);
        EXPECT_EQ(carried(*oldest), i);
    }
    EXPECT_EQ(held.reads().size(), HeldReads::kMost);
    EXPECT_EQ(carried(held.reads().front()), 3U);
    EXPECT_EQ(carried(held.reads().back()), HeldReads::kMost + 2);
}

}  // namespace held_reads_test
}  // namespace takt::poll
