// The proof counts a failed attempt as long as the engine takes for it.
#include <gtest/gtest.h>

#include "takt/bus/failure_time.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/plan.hpp"
#include "takt/plan/request_job.hpp"
#include "takt/poll/line_poller.hpp"

namespace takt::poll {
namespace failed_attempt_test {

using namespace std::chrono_literals;

model::Project project(const model::Line& line) {
    model::Project made;
    made.lines.push_back(line);
    auto& device = made.lines[0].devices.emplace_back();
    device.name = "Device";
    device.response_timeout = 70ms;
    auto& variable = device.variables.emplace_back();
    variable.name = "Value";
    variable.read = wire::Function::read_holding_registers;
    variable.period = 1s;
    return made;
}

model::Line serial(wire::Framing framing, std::uint32_t baud) {
    model::Line line;
    line.name = "line";
    line.framing = framing;
    line.format.baud = baud;
    return line;
}

/// F of the proof must not be shorter; the proof rounds up twice to microseconds, and counts bytes over TCP.
void expect_equal_failures(const model::Project& made) {
    const auto plan = plan::make_plan(made);
    const auto& line = made.lines[0];
    ASSERT_EQ(plan.lines[0].requests.size(), 1U);
    const auto job = plan::job_of(made, line, plan.lines[0].requests[0], plan::Cause::period);
    ASSERT_TRUE(job && job->costs.size() == 1);
    const Duration proved = std::chrono::microseconds(job->costs[0].failure) - made.host.overhead;
    const Duration taken = bus::failure_time(line_config(made, line), 5, job->response_length,
                                             plan::answer_wait(made, line, line.devices[0]));
    EXPECT_GE(proved, taken);
    EXPECT_LE(proved, taken + 3us);
}

TEST(FailedAttempt, CostsInTheProofWhatTheEngineTakes) {
    for (const std::uint32_t baud : {1200U, 9600U, 115200U}) {
        expect_equal_failures(project(serial(wire::Framing::rtu, baud)));
        expect_equal_failures(project(serial(wire::Framing::ascii, baud)));
    }
    auto tcp = serial(wire::Framing::tcp, 0);
    tcp.transport = model::Transport::tcp;
    expect_equal_failures(project(tcp));
}

TEST(FailedAttempt, CountsGapsAndTheWaitThatT35Lengthens) {
    auto line = serial(wire::Framing::rtu, 1200);
    line.frame_gap = 100ms;
    auto made = project(line);
    made.lines[0].devices[0].response_timeout = 5ms;  // t3.5 is longer
    expect_equal_failures(made);
    made.lines[0].frame_gap = 0ms;
    expect_equal_failures(made);
    made.lines[0].request_gap = 900ms;
    made.host.overhead = 0ms;
    expect_equal_failures(made);
}

}  // namespace failed_attempt_test
}  // namespace takt::poll
