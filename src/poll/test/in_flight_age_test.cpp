// The bounds of a connection with several requests in flight, against a server whose responses take as long
// as was measured. The master is the real one, in hand-moved time.
#include <gtest/gtest.h>

#include <map>
#include <queue>
#include <random>
#include <tuple>

#include "takt/plan/proof.hpp"
#include "tcp_frames.hpp"

namespace takt::poll {
namespace in_flight_age_test {

using namespace test;

constexpr Duration kLongest = 8ms;  // the measured round trip
constexpr std::uint16_t kDistance = 10;

/// How the server works.
enum class Server : std::uint8_t {
    together,  ///< each response takes what it takes
    in_order,  ///< one after the other, each a share of the longest round trip
};

struct Case {
    std::size_t in_flight = 1;
    Server server = Server::together;
    Duration longest = kLongest;
    int seed = 1;
};

/// Requests that fill 60 % of the slots, with periods of three lengths.
std::vector<Item> items_for(std::size_t in_flight) {
    std::vector<Item> items;
    for (const auto& [count, period] : {std::pair(1, 40ms), std::pair(2, 80ms), std::pair(8, 320ms)})
        for (std::size_t i = 0; i < static_cast<std::size_t>(count) * in_flight; ++i) {
            const auto number = static_cast<int>(items.size());
            items.push_back(int16("v" + std::to_string(number), number * kDistance).read(3).every(period));
        }
    return items;
}

model::Project project_for(std::size_t in_flight) {
    auto made = device(1, items_for(in_flight));
    made.strategy = model::Strategy::single;
    made.in_flight = static_cast<std::uint16_t>(in_flight);
    made.response_timeout = 500ms;
    made.measured_round_trip = model::MeasuredRoundTrip{
        .longest = kLongest, .usual = 2ms, .exchanges = 100'000, .in_flight = made.in_flight};
    return tcp_project({made});
}

/// Runs a master against a server. A value has the age of the instant at which its request reached the
/// server: a change just after it is seen with the next response only.
class Polling {
public:
    explicit Polling(const Case& given)
        : case_(given),
          random_(static_cast<unsigned>(given.seed)),
          project_(project_for(given.in_flight)),
          proof_(plan::prove(project_, false, false)),
          master_(project_, proof_.plan) {}

    void run(Duration length) {
        auto& line = master_.line(0);
        line.on_link(now_, true);
        while (now_ < at(length)) {
            send();
            const auto due = pending_.empty() ? kNever : pending_.top().at;
            const auto wakeup = late(line.next_wakeup());
            now_ = std::max(now_, std::min(due, wakeup));
            while (!pending_.empty() && pending_.top().at <= now_) respond();
            if (wakeup <= now_) line.on_tick(now_);
        }
    }

    /// The greatest age of a value and its bound, as a ratio; above 1: the bound does not hold.
    [[nodiscard]] double greatest() const {
        double ratio = 0;
        for (const auto& [start, age] : ages_) {
            const auto bound = proof_.lines[0].ages.at(0).at(start / kDistance);
            if (!bound) return 1e9;
            ratio = std::max(ratio, static_cast<double>(age.count()) / static_cast<double>(bound->count()));
        }
        return ratio;
    }
    [[nodiscard]] std::size_t values() const { return ages_.size(); }
    [[nodiscard]] std::size_t most_in_flight() const { return most_; }
    [[nodiscard]] std::uint64_t count(std::uint64_t RequestStatistics::* counter) const {
        std::uint64_t count = 0;
        for (std::size_t r = 0; r < proof_.plan.lines[0].requests.size(); ++r)
            count += master_.line(0).request(r).*counter;
        return count;
    }
    [[nodiscard]] LineTimes times() const { return master_.line(0).line_times(); }
    [[nodiscard]] const plan::LineGuarantee& proved() const { return proof_.lines[0]; }

private:
    struct Response {
        Instant at;
        Instant sampled;
        std::vector<std::uint8_t> request;
        bool operator<(const Response& other) const { return at > other.at; }  // the earliest is the top
    };

    /// A busy computer: timers are late by up to the jitter of the project.
    Instant late(Instant wakeup) {
        if (wakeup == kNever || wakeup == drawn_for_) return wakeup == kNever ? kNever : drawn_;
        drawn_for_ = wakeup;
        drawn_ = wakeup + Duration(static_cast<Duration::rep>(random_()) % project_.host.jitter.count());
        return drawn_;
    }

    void send() {
        for (;;) {
            const Bytes bytes = master_.line(0).transmit(now_);
            if (bytes.empty()) return;
            pending_.push({end_of_response(), now_, {bytes.begin(), bytes.end()}});
            most_ = std::max(most_, pending_.size());
        }
    }

    Instant end_of_response() {
        const auto share = case_.longest / static_cast<int>(case_.in_flight);
        const auto longest = case_.server == Server::in_order ? share : case_.longest;
        const auto taken =
            random_() % 4 > 0 ? longest : Duration(static_cast<Duration::rep>(random_()) % longest.count());
        if (case_.server == Server::together) return now_ + taken;
        idle_at_ = std::max(idle_at_, now_) + taken;
        return idle_at_;
    }

    void respond() {
        const auto response = pending_.top();
        pending_.pop();
        std::vector<std::uint8_t> frame(response.request.begin(), response.request.begin() + 7);
        frame[5] = 5;
        frame.insert(frame.end(), {3, 2, 0, 1});
        const auto start = static_cast<std::uint16_t>(response.request[8] << 8U | response.request[9]);
        if (const auto before = sampled_.find(start); before != sampled_.end())
            ages_[start] = std::max(ages_[start], now_ - before->second);
        sampled_[start] = response.sampled;
        master_.line(0).on_bytes(now_, frame);
    }

    Case case_;
    std::mt19937 random_;
    model::Project project_;
    plan::Proof proof_;
    Master master_;
    Instant now_ = at(0ms);
    Instant drawn_for_;
    Instant drawn_;
    Instant idle_at_;
    std::priority_queue<Response> pending_;
    std::map<std::uint16_t, Instant> sampled_;  // by start: of the value shown
    std::map<std::uint16_t, Duration> ages_;
    std::size_t most_ = 0;
};

TEST(InFlightAges, NoValueIsOlderThanItsBoundAtTheMeasuredRoundTrip) {
    for (const std::size_t in_flight : {1U, 2U, 4U, 16U})
        for (const auto server : {Server::together, Server::in_order})
            for (int seed = 1; seed <= 5; ++seed) {
                SCOPED_TRACE(std::to_string(in_flight) + " in flight, server " +
                             std::to_string(static_cast<int>(server)) + ", seed " + std::to_string(seed));
                Polling polling({.in_flight = in_flight, .server = server, .seed = seed});
                ASSERT_TRUE(polling.proved().feasible);
                polling.run(10s);
                EXPECT_EQ(polling.values(), 11 * in_flight);
                EXPECT_EQ(polling.most_in_flight(), in_flight) << "the connection is never full";
                EXPECT_LE(polling.greatest(), 1.0);
                EXPECT_GT(polling.greatest(), 0.7) << "the bound says nothing";
                EXPECT_EQ(polling.count(&RequestStatistics::over_cost), 0U);
                EXPECT_EQ(polling.count(&RequestStatistics::late_refreshes), 0U);
            }
}

TEST(InFlightAges, ASlowerServerBreaksTheBoundsAndIsCounted) {
    for (const std::size_t in_flight : {1U, 2U, 4U, 16U}) {
        Polling polling({.in_flight = in_flight, .longest = 2 * kLongest});
        polling.run(10s);
        EXPECT_GT(polling.greatest(), 1.0) << in_flight;
        EXPECT_GT(polling.count(&RequestStatistics::over_cost), 100U) << in_flight;
        EXPECT_GT(polling.count(&RequestStatistics::late_refreshes), 0U) << in_flight;
        EXPECT_EQ(polling.times().turnaround.longest, 2 * kLongest) << in_flight;
    }
}

}  // namespace in_flight_age_test
}  // namespace takt::poll
