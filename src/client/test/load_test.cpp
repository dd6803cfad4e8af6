// Loads on a server in the same loop, which answers as a script says.
#include "takt/client/load.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "takt/line/tcp_server.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::client {
namespace load_test {

using namespace std::chrono_literals;

struct Reply {
    Duration delay{};
    std::vector<std::uint8_t> pdu{0x03, 2, 0, 7};
    std::uint8_t other_transaction = 0;  // XOR with the low byte of the id
    std::uint8_t other_unit = 0;         // likewise with the unit
};
/// The reply to the request of that number, from 0; nothing: there is none.
using Script = std::function<std::optional<Reply>(std::size_t number)>;

/// Answers requests of 12 bytes, each after its own delay: also out of order.
class ScriptEngine final : public Engine {
public:
    ScriptEngine(const Script& script, std::size_t& number) : script_(script), number_(number) {}
    void on_link(Instant, bool) override {}
    void on_bytes(Instant t, Bytes bytes) override {
        input_.insert(input_.end(), bytes.begin(), bytes.end());
        for (; input_.size() >= 12; input_.erase(input_.begin(), input_.begin() + 12)) {
            const auto reply = script_(number_++);
            if (!reply) continue;
            std::vector<std::uint8_t> frame(input_.begin(), input_.begin() + 7);
            frame[1] ^= reply->other_transaction;
            frame[6] ^= reply->other_unit;
            frame[5] = static_cast<std::uint8_t>(reply->pdu.size() + 1);
            frame.insert(frame.end(), reply->pdu.begin(), reply->pdu.end());
            waiting_.emplace_back(t + reply->delay, frame);
        }
        std::ranges::stable_sort(waiting_, {}, [](const auto& each) { return each.first; });
    }
    void on_tick(Instant) override {}
    Bytes transmit(Instant t) override {
        if (waiting_.empty() || waiting_.front().first > t) return {};
        output_ = waiting_.front().second;
        waiting_.erase(waiting_.begin());
        return output_;
    }
    Instant next_wakeup() const override { return waiting_.empty() ? kNever : waiting_.front().first; }

private:
    const Script& script_;
    std::size_t& number_;
    std::vector<std::uint8_t> input_, output_;
    std::vector<std::pair<Instant, std::vector<std::uint8_t>>> waiting_;
};

class ScriptSession final : public line::Session {
public:
    ScriptSession(const Script& script, std::size_t& number) : engine_(script, number) {}
    Engine& engine() override { return engine_; }
    Instant last_received() const override { return line::now(); }

private:
    ScriptEngine engine_;
};

class LoadTest : public testing::Test {
protected:
    LoadTest() : loop(*line::Loop::create()) {
        server = *line::TcpServer::listen(*loop, {"127.0.0.1", 0}, [this](Instant, const line::Peer&) {
            return std::make_unique<ScriptSession>(script, number);
        });
        options.target.target = "tcp://127.0.0.1:" + std::to_string(server->port());
        options.request =
            *wire::prepare(wire::ReadRequest{wire::Function::read_holding_registers, DataAddress{0}, 1});
    }

    /// Measures; the load must end well.
    const capture::Series& measure() {
        load = std::make_unique<Load>(*loop, options, report);
        const auto connected = load->connect();
        EXPECT_TRUE(connected);
        if (connected) {
            EXPECT_TRUE(load->run());
        }
        return report.total();
    }

    std::unique_ptr<line::Loop> loop;
    Script script = [](std::size_t) { return Reply{}; };
    std::size_t number = 0;
    std::unique_ptr<line::TcpServer> server;
    LoadOptions options;
    capture::LatencyReport report{{.limit = 50ms}};
    std::unique_ptr<Load> load;
};

TEST(Rate, IntendedInstantsAreExact) {
    const Rate third{3, 1s};
    EXPECT_EQ(third.offset(1), 333'333'333ns);
    EXPECT_EQ(third.offset(3), 1s);
    EXPECT_EQ(third.offset(3'000'000'001), 1'000'000'000s + 333'333'333ns);
    for (const auto& rate : {third, Rate{1000, 1s}, Rate{7, 60s}, Rate{999'983, 1s}}) {
        for (const auto time : {0ns, 1ns, 333'333'333ns, 333'333'334ns, 1'000'000'000ns, 61'234'567'891ns}) {
            const auto count = rate.before(time);
            EXPECT_GE(rate.offset(count), time);
            if (count > 0) {
                EXPECT_LT(rate.offset(count - 1), time);
            }
        }
    }
}

TEST_F(LoadTest, SendsTheCountAsFastAsTheServerAnswers) {
    options.count = 500;
    const auto& total = measure();
    EXPECT_EQ(total.requests, 500U);
    EXPECT_EQ(total.answered, 500U);
    EXPECT_EQ(number, 500U);
    EXPECT_EQ(load->counts().sent, 500U);
    EXPECT_EQ(load->counts().from_sending.max(), total.times.max());
}

TEST_F(LoadTest, KeepsTheRateOnManyConnections) {
    options.connections = 5;
    options.rate = Rate{500, 1s};
    options.time = 400ms;
    const auto& total = measure();
    EXPECT_EQ(total.requests, 200U);
    EXPECT_EQ(total.answered + total.unanswered, 200U);
    EXPECT_EQ(server->connections(), 5U);
}

TEST_F(LoadTest, HasSoManyRequestsInFlight) {
    std::size_t most = 0;
    std::size_t waiting = 0;
    script = [&](std::size_t n) {
        if (n % 8 == 0) waiting = 0;
        most = std::max(most, ++waiting);
        return Reply{.delay = 20ms};
    };
    options.in_flight = 8;
    options.count = 32;
    EXPECT_EQ(measure().answered, 32U);
    EXPECT_EQ(most, 8U);
}

// The server stops for 200 ms once. At 1000 requests a second about 200 of them wait; each counts with its
// own delay, although two at most are in flight.
TEST_F(LoadTest, AStallDelaysEveryRequestThatWasDue) {
    script = [](std::size_t n) { return Reply{.delay = n >= 100 && n < 102 ? 200ms : 0ms}; };
    options.in_flight = 2;
    options.rate = Rate{1000, 1s};
    options.time = 600ms;
    const auto& total = measure();
    EXPECT_EQ(total.requests, 600U);
    EXPECT_EQ(total.answered + total.unanswered, 600U);
    EXPECT_GE(total.exceeded, 140U);  // those due in the first 150 ms of the stall took longer than 50 ms
    EXPECT_GE(total.times.percentile(80), 50ms);
    EXPECT_GE(load->counts().from_sending.max(), 200ms);
    EXPECT_LT(load->counts().from_sending.percentile(80), total.times.percentile(80));
}

TEST_F(LoadTest, WithoutARateAStallHidesTheRequestsBehindIt) {
    script = [](std::size_t n) { return Reply{.delay = n == 10 ? 100ms : 0ms}; };
    options.count = 200;
    const auto exceeded = measure().exceeded;
    EXPECT_GE(exceeded, 1U);
    EXPECT_LT(exceeded, 20U);  // at a rate of 1000 requests a second about 50 would exceed the limit
}

TEST_F(LoadTest, RequestsThatFoundNoRoomAreUnanswered) {
    script = [](std::size_t n) { return n < 10 ? std::optional(Reply{}) : std::nullopt; };
    options.target.timeout = 300ms;
    options.rate = Rate{1000, 1s};
    options.time = 100ms;
    const auto& total = measure();
    EXPECT_EQ(total.requests, 100U);
    EXPECT_EQ(total.answered, 10U);
    EXPECT_EQ(total.unanswered, 90U);
    EXPECT_EQ(total.exceeded, 90U);
    EXPECT_EQ(load->counts().unsent, 89U);
    EXPECT_EQ(load->counts().timed_out, 1U);
}

TEST_F(LoadTest, RecordsALateResponse) {
    script = [](std::size_t n) { return Reply{.delay = n == 1 ? 150ms : n == 3 ? 200ms : 0ms}; };
    options.target.timeout = 100ms;
    report = capture::LatencyReport({.timeout = 100ms});
    options.count = 4;
    options.time = 2s;
    const auto& total = measure();
    EXPECT_EQ(total.answered, 3U);
    EXPECT_EQ(total.late, 1U);
    EXPECT_EQ(total.unanswered, 1U);  // the last one: nothing waits for late responses at the end
    EXPECT_EQ(load->counts().timed_out, 2U);
    EXPECT_GE(total.times.max(), 150ms);
}

TEST_F(LoadTest, RecordsALateException) {
    script = [](std::size_t n) { return n == 1 ? Reply{.delay = 150ms, .pdu = {0x83, 6}} : Reply{}; };
    options.target.timeout = 100ms;
    options.count = 40;
    options.rate = Rate{100, 1s};
    const auto& total = measure();
    EXPECT_EQ(total.answered, 40U);
    EXPECT_EQ(load->counts().timed_out, 1U);
    EXPECT_EQ(total.exceptions, (std::map<std::uint8_t, std::uint64_t>{{6, 1}}));
}

/// Answers the first two requests of RTU (8 bytes each) in one write, so long after the second one; then at
/// once. The exceptions to the first two differ.
class LatePairSession final : public line::Session, private Engine {
public:
    explicit LatePairSession(Duration delay) : delay_(delay) {}
    Engine& engine() override { return *this; }
    Instant last_received() const override { return line::now(); }

private:
    void on_link(Instant, bool) override {}
    void on_bytes(Instant t, Bytes bytes) override {
        for (bytes_ += bytes.size(); bytes_ >= 8; bytes_ -= 8) {
            ++requests_;
            if (requests_ <= 2) add({17, 0x83, static_cast<std::uint8_t>(requests_ == 1 ? 2 : 6)});
            if (requests_ > 2) add({17, 0x03, 2, 0, 7});
            if (requests_ >= 2) at_ = requests_ == 2 ? t + delay_ : t;
        }
    }
    void on_tick(Instant) override {}
    Bytes transmit(Instant t) override {
        if (t < at_) return {};
        at_ = kNever;
        sent_.swap(output_);
        output_.clear();
        return sent_;
    }
    Instant next_wakeup() const override { return at_; }

    void add(std::vector<std::uint8_t> frame) {
        const auto sum = wire::crc16(frame);
        frame.push_back(static_cast<std::uint8_t>(sum & 0xFFU));
        frame.push_back(static_cast<std::uint8_t>(sum >> 8U));
        output_.insert(output_.end(), frame.begin(), frame.end());
    }

    Duration delay_;
    std::size_t bytes_ = 0;
    std::size_t requests_ = 0;
    Instant at_ = kNever;
    std::vector<std::uint8_t> output_, sent_;
};

TEST_F(LoadTest, LateResponsesInOneReadKeepTheirOwnContents) {
    server = *line::TcpServer::listen(*loop, {"127.0.0.1", 0}, [](Instant, const line::Peer&) {
        return std::make_unique<LatePairSession>(150ms);
    });
    options.target.target = "rtu+tcp://127.0.0.1:" + std::to_string(server->port());
    options.target.unit = 17;
    options.target.timeout = 50ms;
    options.rate = Rate{2, 1s};
    options.count = 5;
    const auto& total = measure();
    EXPECT_EQ(load->counts().timed_out, 2U);
    EXPECT_EQ(total.exceptions, (std::map<std::uint8_t, std::uint64_t>{{2, 1}, {6, 1}}));
    EXPECT_EQ(total.answered, 5U);
}

// More late responses at a time than the engine remembers, the last request first.
TEST_F(LoadTest, EachLateResponseHasItsOwnTime) {
    script = [](std::size_t n) { return Reply{.delay = n < 8 ? 400ms - static_cast<int>(n) * 20ms : 0ms}; };
    options.target.timeout = 100ms;
    options.in_flight = 8;
    options.time = 700ms;
    const auto& total = measure();
    EXPECT_EQ(load->counts().timed_out, 8U);
    EXPECT_EQ(total.unanswered, 0U);
    EXPECT_EQ(load->counts().unexpected, 0U);
    std::vector<Duration> late;
    for (const auto& exchange : report.slowest()) late.push_back(exchange.time());
    ASSERT_GE(late.size(), 8U);
    for (std::size_t i = 0; i < 8; ++i) {
        const Duration delay = 400ms - static_cast<int>(i) * 20ms;
        EXPECT_GE(late[i], delay);
        EXPECT_LT(late[i], delay + 20ms) << "of its own request";
    }
}

TEST_F(LoadTest, CountsFramesThatAnswerNoRequest) {
    script = [](std::size_t n) {
        return n == 0   ? Reply{.other_transaction = 0x55}
               : n == 1 ? Reply{.other_unit = 1}
               : n == 2 ? Reply{.pdu = {0x04, 2, 0, 7}}
                        : Reply{};
    };
    options.target.timeout = 50ms;
    options.count = 10;
    const auto& total = measure();
    EXPECT_EQ(total.answered, 7U);
    EXPECT_EQ(total.unanswered, 3U);
    EXPECT_EQ(load->counts().unexpected, 3U);
}

TEST_F(LoadTest, CountsExceptionsAndWrongAndDifferentResponses) {
    const std::vector<std::vector<std::uint8_t>> pdus{
        {0x03, 2, 0, 7}, {0x83, 2}, {0x83, 6}, {0x03, 4, 0, 7, 0, 8}, {0x03, 2, 0, 8}, {0x03, 2, 0, 7}};
    script = [&](std::size_t n) { return Reply{.pdu = pdus[n]}; };
    options.same_content = true;
    options.count = pdus.size();
    const auto& total = measure();
    EXPECT_EQ(total.answered, 5U);
    EXPECT_EQ(total.exceptions, (std::map<std::uint8_t, std::uint64_t>{{2, 1}, {6, 1}}));
    EXPECT_EQ(total.unanswered, 1U);
    EXPECT_EQ(load->counts().wrong, 1U);
    EXPECT_EQ(load->counts().different, 1U);
}

TEST_F(LoadTest, AStoppedLoopLeavesOpenRequests) {
    script = [this](std::size_t n) -> std::optional<Reply> {
        if (n < 5) return Reply{};
        loop->stop();
        return std::nullopt;
    };
    const auto& total = measure();
    EXPECT_EQ(total.answered, 5U);
    EXPECT_EQ(total.open, 1U);
    EXPECT_EQ(total.unanswered, 0U);
}

TEST_F(LoadTest, ReportsWhatALineDoesNotAllow) {
    const auto refused = [&] {
        Load load_on_line(*loop, options, report);
        const auto connected = load_on_line.connect();
        return connected ? Code::overflow : connected.error().code;
    };
    options.target.target = "rtu:///dev/ttyS0";
    options.connections = 2;
    EXPECT_EQ(refused(), Code::unsupported);
    options.connections = 1;
    options.in_flight = 2;
    EXPECT_EQ(refused(), Code::unsupported);
    options.target.target = "tcp://127.0.0.1:1";
    EXPECT_EQ(refused(), Code::cannot_open);
}

}  // namespace load_test
}  // namespace takt::client
