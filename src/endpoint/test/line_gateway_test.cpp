// A gateway at a line that the test plays.
#include "takt/endpoint/line_gateway.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support.hpp"

namespace takt::endpoint {
namespace line_gateway_test {

using namespace std::chrono_literals;
using test::FakeLine;
using test::pdu;
using test::to_hex;

constexpr Instant kNow{1h};

struct Bench {
    Bench()
        : gateway({}, line, [this](const serve::Gateway::Reply& reply) {
              replies.push_back(std::to_string(reply.token) + ": " + to_hex(reply.pdu.span()));
              if (on_reply) on_reply();
          }) {
        gateway.after_line_event(kNow);
    }
    void ask(serve::Token token, std::uint64_t client = 1) {
        const auto request = pdu("03 00 00 00 01");
        const auto answer = gateway.gateway().ask(kNow, {0, client, token}, {},
                                                  UnitId{static_cast<std::uint8_t>(token)}, request);
        EXPECT_FALSE(answer);
    }

    FakeLine line;
    std::vector<std::string> replies;
    std::function<void()> on_reply;
    LineGateway gateway;
};

TEST(LineGateway, MovesRequestsToTheLineAndAnswersBack) {
    Bench bench;
    EXPECT_EQ(bench.gateway.next_wakeup(kNow), kNever);
    bench.ask(1);
    EXPECT_EQ(bench.gateway.next_wakeup(kNow), kNow) << "the line is free";
    bench.gateway.work(kNow);
    ASSERT_TRUE(bench.line.flight);
    EXPECT_EQ(bench.line.flight->unit, UnitId{1});
    EXPECT_EQ(bench.line.pokes, 1);
    bench.line.answer("03 02 00 07");
    bench.gateway.after_line_event(kNow);
    EXPECT_TRUE(bench.replies.empty()) << "nothing is delivered from inside the line's driver";
    EXPECT_EQ(bench.gateway.next_wakeup(kNow), kNow);
    bench.gateway.work(kNow);
    EXPECT_EQ(bench.replies, std::vector<std::string>{"1: 03 02 00 07"});
}

TEST(LineGateway, TheNextRequestGoesOutWithTheEndOfTheOneBefore) {
    Bench bench;
    bench.ask(1, 1);
    bench.ask(2, 2);
    bench.gateway.work(kNow);
    bench.line.answer("03 02 00 07");
    bench.gateway.after_line_event(kNow);
    ASSERT_TRUE(bench.line.flight);
    EXPECT_EQ(bench.line.flight->unit, UnitId{2});
}

TEST(LineGateway, WaitsWhileTheLineIsTaken) {
    Bench bench;
    bench.ask(1, 1);
    bench.gateway.work(kNow);
    bench.ask(2, 2);
    EXPECT_GT(bench.gateway.next_wakeup(kNow), kNow) << "until its turn must have come";
    EXPECT_LT(bench.gateway.next_wakeup(kNow), kNever);
}

// As while the response to it could be mistaken for a late one.
TEST(LineGateway, ARequestThatTheLineHoldsBackKeepsNoOtherOneFromTheLine) {
    Bench bench;
    bench.line.sent = false;
    bench.line.held_back = UnitId{1};
    bench.ask(1, 1);
    bench.gateway.work(kNow);
    ASSERT_TRUE(bench.line.flight) << "nothing else waits";
    bench.ask(2, 2);
    bench.gateway.work(kNow);
    ASSERT_TRUE(bench.line.flight);
    EXPECT_EQ(bench.line.flight->unit, UnitId{2});
    bench.line.answer("03 02 00 07");
    bench.gateway.work(kNow);
    ASSERT_TRUE(bench.line.flight);
    EXPECT_EQ(bench.line.flight->unit, UnitId{1}) << "it waits on the line again";
}

TEST(LineGateway, RequestsThatTheLineRejectsAreAnswered) {
    Bench bench;
    bench.line.rejects = true;
    bench.ask(1);
    bench.gateway.work(kNow);
    EXPECT_EQ(bench.replies, std::vector<std::string>{"1: 83 0A"});
}

TEST(LineGateway, AClosedLineEndsWhatWaits) {
    Bench bench;
    bench.ask(1, 1);
    bench.gateway.work(kNow);
    bench.ask(2, 2);
    bench.line.up = false;
    bench.line.outcome =
        bus::Outcome{.id = bench.line.flight->id, .status = bus::Status::link_lost, .sent = true};
    bench.line.flight.reset();
    bench.gateway.work(kNow);
    EXPECT_EQ(bench.replies, (std::vector<std::string>{"1: 83 0B", "2: 83 0A"}));
    const auto at_once = bench.gateway.gateway().ask(kNow, {0, 1, 3}, {}, UnitId{1},
                                                     wire::PreparedRequest(pdu("03 00 00 00 01")));
    ASSERT_TRUE(at_once);
    EXPECT_EQ(to_hex(at_once->span()), "83 0A");
}

TEST(LineGateway, AClientMayAskAgainFromInsideItsAnswer) {
    Bench bench;
    bench.ask(1);
    bench.gateway.work(kNow);
    bench.line.answer("03 02 00 07");
    bench.on_reply = [&] { bench.ask(2); };
    bench.gateway.work(kNow);
    bench.on_reply = {};
    EXPECT_EQ(bench.gateway.next_wakeup(kNow), kNow);
    bench.gateway.work(kNow);
    ASSERT_TRUE(bench.line.flight);
    EXPECT_EQ(bench.line.flight->unit, UnitId{2});
}

}  // namespace line_gateway_test
}  // namespace takt::endpoint
