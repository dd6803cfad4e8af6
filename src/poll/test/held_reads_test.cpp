#include "reads/held_reads.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::poll {
namespace held_reads_test {

TEST(HeldReads, LeaveInTheirOrderAndKeepTheirResponses) {
    const wire::PreparedRequest asked(std::vector<std::uint8_t>{3, 0, 0, 0, 1});
    HeldReads held;
    for (std::size_t i = 0; i < HeldReads::kMost; ++i) {
        ASSERT_FALSE(held.full());
        const std::vector<std::uint8_t> bytes{3, 2, 0, static_cast<std::uint8_t>(i)};
        HeldRead read{.request = i, .sent = asked.shape(), .round = {}, .outcome = {}};
        read.outcome.response = wire::decode_response(asked.shape(), asked.pdu(), bytes).value();
        held.add(read);
    }
    EXPECT_TRUE(held.full());
    for (std::size_t i = 0; i < HeldReads::kMost; ++i, held.pop()) {
        EXPECT_EQ(held.front().request, i);
        EXPECT_EQ(held.front().outcome.response.pdu()[3], i);
    }
    EXPECT_TRUE(held.empty());
}

}  // namespace held_reads_test
}  // namespace takt::poll
