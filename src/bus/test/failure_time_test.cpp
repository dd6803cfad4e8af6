#include "takt/bus/failure_time.hpp"

#include <gtest/gtest.h>

#include "rig.hpp"

namespace takt::bus {
namespace failure_time_test {

using namespace test;

/// From the start of a request without a response to the earliest start of the next one.
Duration measured(const LineConfig& config, Duration wait) {
    Rig rig(config);
    rig.now = at(10ms);
    rig.submit(rig.now, transaction(1, 1, "03 00 00 00 02", wait));
    rig.run_until(at(1s));
    EXPECT_EQ(rig.outcomes.size(), 1U);
    EXPECT_EQ(rig.last().status, Status::timeout);
    return std::max(rig.last().ended_at + rig.engine.silence(), rig.sent_at[0] + config.request_gap) -
           rig.sent_at[0];
}

TEST(FailureTime, IsWhatTheEngineTakes) {
    LineConfig gap = kLine;
    gap.request_gap = 400ms;
    LineConfig spaced = kLine;
    spaced.frame_gap = 80ms;
    LineConfig ascii = kLine;
    ascii.framing = wire::Framing::ascii;
    LineConfig stream = kLine;
    stream.format.baud = 0;
    LineConfig tcp = kLine;
    tcp.framing = wire::Framing::tcp;
    for (const auto& config : {kLine, gap, spaced, ascii, stream, tcp})
        for (const Duration wait : {Duration(0), Duration(1ms), Duration(50ms), Duration(300ms)}) {
            EXPECT_EQ(failure_time(config, 5, 6, wait), measured(config, wait))
                << wire::name(config.framing) << ", " << wait.count();
        }
}

}  // namespace failure_time_test
}  // namespace takt::bus
