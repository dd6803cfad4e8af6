// The poller keeps the bounds that the plan proves: no response is later than its bound.
#include "takt/plan/guarantee.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <tuple>

#include "bench.hpp"
#include "takt/plan/proof.hpp"

namespace takt::poll {
namespace guarantee_test {

using namespace test;

constexpr Duration kTurnaround = 4ms;

std::vector<Item> random_items(std::mt19937& random, int device) {
    constexpr Duration kPeriods[] = {60ms, 100ms, 150ms, 240ms, 500ms};
    std::vector<Item> items;
    const int count = 1 + static_cast<int>(random() % 5);
    for (int i = 0; i < count; ++i) {
        const auto name = "v" + std::to_string(device) + "_" + std::to_string(i);
        items.push_back(int16(name, 40 * i).read(3).every(kPeriods[random() % 5]));
        if (random() % 3 == 0) items.back().deadline = items.back().period / 2;
        for (auto more = random() % 20; more > 0; --more) {
            Item next = items.back();
            next.name += "x";
            ++next.register_number;
            items.push_back(next);
        }
    }
    return items;
}

model::Project random_project(std::mt19937& random) {
    std::vector<model::Device> devices;
    for (int d = 1; d <= 1 + static_cast<int>(random() % 4); ++d) {
        devices.push_back(device(d, random_items(random, d)));
        devices.back().turnaround = kTurnaround;
    }
    auto made = project(devices);
    if (random() % 3 == 0) made.lines[0].order = model::PollOrder::address;
    return made;
}

/// How much later than its bound the latest answer came; negative: none did.
Duration latest(const Bench& bench, const plan::LineGuarantee& proved) {
    std::map<std::tuple<std::uint8_t, std::uint16_t>, std::size_t> index;
    std::vector<std::int64_t> count(proved.requests.size(), 0);
    const auto& requests = bench.plan.lines[0].requests;
    for (std::size_t r = 0; r < requests.size(); ++r)
        index[{bench.project.lines[0].devices[requests[r].device].address.value, requests[r].start}] = r;
    auto worst = Duration::min();
    for (const auto& sent : bench.sent) {
        const std::size_t r = index.at({sent.unit, sent.start});
        const auto& bound = proved.requests[r];
        const Instant due = at(requests[r].phase + *requests[r].period * count[r]++);
        const Duration silence = wire::t3_5(bench.project.lines[0].format);
        const Instant answered = sent.t + bound.transaction - silence - bench.project.host.overhead;
        worst = std::max(worst, answered - due - *bound.response);
    }
    return worst;
}

TEST(KeepsGuarantees, NoAnswerIsLaterThanItsBound) {
    std::mt19937 random(7);
    int feasible = 0;
    for (int round = 0; round < 60; ++round) {
        const auto described = random_project(random);
        const auto proved = plan::guarantee(described, plan::make_plan(described)).at(0);
        if (!proved.feasible) continue;
        ++feasible;
        auto planned = plan::make_plan(described);
        plan::put_ages(planned, {proved});
        Bench bench(described, planned);
        for (auto& [unit, player] : bench.players) player.turnaround = kTurnaround;
        bench.run_until(2s);
        EXPECT_LE(latest(bench, proved), Duration::zero()) << "round " << round;
        for (std::size_t r = 0; r < planned.lines[0].requests.size(); ++r)
            EXPECT_EQ(bench.master.line(0).request(r).late_refreshes, 0U) << "round " << round;
    }
    EXPECT_GT(feasible, 20);
}

}  // namespace guarantee_test
}  // namespace takt::poll
