// The queue of polled reads against the simple comparison of all of them: by itself, and inside a poller on
// lines where everything happens (there each choice is compared, see request_offers.cpp).
#include "reads/read_queue.hpp"
#include "reads/eventful_requests.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "bench.hpp"

namespace takt::poll {
namespace read_queue_test {

using namespace test;

RC_GTEST_PROP(IndexedHeap, HasTheLeastOnTop, ()) {
    const auto n = *rc::gen::inRange<std::uint32_t>(1, 12);
    IndexedHeap<int> heap(n);
    std::map<std::uint32_t, int> model;
    const auto steps = *rc::gen::inRange(1, 60);
    for (int i = 0; i < steps; ++i) {
        const auto index = *rc::gen::inRange<std::uint32_t>(0, n);
        if (*rc::gen::inRange(0, 3) > 0) {
            model[index] = *rc::gen::inRange(0, 20);
            heap.put(index, model[index]);
        } else {
            model.erase(index);
            heap.remove(index);
        }
        std::vector<std::uint32_t> frontier;
        std::vector<int> keys;
        std::set<std::uint32_t> visited;
        heap.visit_in_order(frontier, [&](std::uint32_t element) {
            visited.insert(element);
            keys.push_back(model.at(element));
            return true;
        });
        RC_ASSERT(visited.size() == model.size() && keys.size() == model.size());
        RC_ASSERT(std::ranges::is_sorted(keys));
        if (model.empty()) continue;
        const auto least =
            std::ranges::min_element(model, {}, [](const auto& entry) { return entry.second; });
        RC_ASSERT(heap.top_key() == least->second);
        RC_ASSERT(model.at(heap.top()) == least->second);
    }
}

RC_GTEST_PROP(EventfulRequests, KeepsEachMemberOnceInTheOrderOfArrival, ()) {
    constexpr std::size_t kRequests = 8;
    EventfulRequests requests(kRequests);
    std::vector<std::size_t> model;
    const auto steps = *rc::gen::inRange(1, 40);
    for (int i = 0; i < steps; ++i) {
        const auto request = *rc::gen::inRange<std::size_t>(0, kRequests);
        if (*rc::gen::inRange(0, 3) > 0) {
            if (std::ranges::find(model, request) == model.end()) model.push_back(request);
            requests.add(request);
        } else {
            std::erase(model, request);
            requests.remove_unless([request](std::size_t member) { return member != request; });
        }
        RC_ASSERT(std::ranges::equal(requests.all(), model));
    }
}

/// A request of the model: due at a moment, and another priority once it has waited too long.
struct Job {
    std::optional<Instant> due;
    Priority priority;
    Instant ages = kNever;

    [[nodiscard]] std::optional<QueueEntry> entry(Instant t) const {
        if (!due) return std::nullopt;
        if (*due > t) return QueueEntry{.due = *due, .priority = {}};
        const bool aged = t >= ages;
        Priority now = priority;
        if (aged) now.urgency = bus::Urgency::commanded;
        return QueueEntry{*due, now, aged ? kNever : ages};
    }
};

Job random_job(Instant t, std::size_t place) {
    Job job;
    if (*rc::gen::inRange(0, 5) == 0) return job;
    job.due = t + *rc::gen::inRange(-2, 6) * 1ms;
    job.priority = {*rc::gen::element(bus::Urgency::overdue, bus::Urgency::polled, bus::Urgency::background),
                    *rc::gen::inRange(0, 3), place};
    if (*rc::gen::arbitrary<bool>()) job.ages = *job.due + *rc::gen::inRange(1, 6) * 1ms;
    return job;
}

RC_GTEST_PROP(ReadQueue, GivesTheSameFirstAsLookingAtAll, ()) {
    const auto devices = *rc::gen::container<std::vector<std::size_t>>(*rc::gen::inRange<std::size_t>(1, 10),
                                                                       rc::gen::inRange<std::size_t>(0, 3));
    std::vector<Job> jobs(devices.size());
    Instant t = at(1s);
    for (std::size_t r = 0; r < jobs.size(); ++r) jobs[r] = random_job(t, r);
    ReadQueue queue(devices, 3);
    const auto steps = *rc::gen::inRange(1, 30);
    for (int i = 0; i < steps; ++i) {
        t += *rc::gen::inRange(0, 3) * 1ms;
        const auto changed = *rc::gen::inRange<std::size_t>(0, jobs.size());
        if (*rc::gen::arbitrary<bool>()) {
            jobs[changed] = random_job(t, changed);
            queue.touch(changed);
        }
        queue.settle(t, [&](std::size_t request) { return jobs[request].entry(t); });
        for (std::size_t device = 0; device < 3; ++device) {
            std::optional<std::size_t> first;
            Instant next = kNever;
            std::vector<std::size_t> due;
            for (std::size_t r = 0; r < jobs.size(); ++r) {
                const auto entry = jobs[r].entry(t);
                if (devices[r] != device || !entry) continue;
                if (!entry->priority) next = std::min(next, entry->due);
                if (!entry->priority) continue;
                due.push_back(r);
                if (!first || *entry->priority < *jobs[*first].entry(t)->priority) first = r;
            }
            std::ranges::sort(due, {}, [&](std::size_t r) { return *jobs[r].entry(t)->priority; });
            RC_ASSERT(queue.first(device) == first);
            RC_ASSERT(queue.next_due(device) == next);
            std::vector<std::size_t> visited;
            queue.visit_due(device, [&](std::size_t request) {
                visited.push_back(request);
                return true;
            });
            RC_ASSERT(visited == due);
            if (due.empty()) continue;
            visited.clear();
            queue.visit_due(device, [&](std::size_t request) {
                visited.push_back(request);
                return false;
            });
            RC_ASSERT(visited == std::vector{due.front()});
        }
    }
}

/// Some devices with many requests of their own: all periods, triggers, writes.
model::Project crowded_project() {
    std::vector<model::Device> devices;
    const int count = *rc::gen::inRange(1, 4);
    for (int d = 1; d <= count; ++d) {
        std::vector<Item> items;
        const int requests = *rc::gen::inRange(3, 12);
        for (int r = 0; r < requests; ++r) {
            Item item = int16("v" + std::to_string(d) + "_" + std::to_string(r), 3 * r).read(3);
            item.period = *rc::gen::element<Duration>(0ms, 50ms, 100ms, 400ms, 1s);
            if (*rc::gen::inRange(0, 6) == 0) item = item.read_on(0);
            if (*rc::gen::inRange(0, 6) == 0) item = item.write(0x10).on_change();
            if (*rc::gen::inRange(0, 9) == 0) item = item.write(0x10).write_on(0);
            items.push_back(item);
        }
        auto made = device(d, items);
        made.strategy = model::Strategy::single;
        made.attempts = static_cast<std::uint16_t>(*rc::gen::inRange(1, 4));
        made.poll_enable = 1;
        devices.push_back(made);
    }
    auto on = local("on");
    on.default_value = model::Constant{.number = 1, .integer = 1};
    auto go = local("go");
    if (*rc::gen::arbitrary<bool>()) go.admission = model::RateLimit{300ms, 2};
    return project(std::move(devices), {go, on});
}

void disturb(Bench& bench, Player& player) {
    switch (*rc::gen::inRange(0, 9)) {
        case 0: player.dead = !player.dead; break;
        case 1: player.exception = *rc::gen::element<std::uint8_t>(2, 5, 6, 10); break;
        case 2: player.exception.reset(); break;
        case 3: player.turnaround = *rc::gen::inRange(0, 200) * 1ms; break;
        case 4: bench.link(false); break;
        case 5:
            player.silent_about.push_back(static_cast<std::uint16_t>(3 * *rc::gen::inRange(0, 10)));
            break;
        case 6: (void)bench.set("on", *rc::gen::arbitrary<bool>()); break;
        case 7: (void)bench.set("v1_" + std::to_string(*rc::gen::inRange(0, 3)), std::int64_t{5}); break;
        default: player = Player{}; break;
    }
    bench.link(true);
}

RC_GTEST_PROP(ReadQueue, ChoosesAsTheComparisonOfAllDoes, ()) {
    Bench bench(crowded_project());
    Duration end{};
    const auto steps = *rc::gen::inRange(1, 8);
    for (int i = 0; i < steps; ++i) {
        end += *rc::gen::inRange(0, 300) * 1ms;
        bench.run_until(end);
        disturb(bench, bench.players[*rc::gen::inRange<std::uint8_t>(1, 4)]);
        RC_ASSERT(bench.set("go", *rc::gen::arbitrary<bool>()).has_value());
    }
    for (auto& [unit, player] : bench.players) player = Player{};
    RC_ASSERT(bench.set("on", true).has_value());
    bench.run_until(end + 6s);
    for (const auto& device : bench.project.lines[0].devices)
        for (const auto& variable : device.variables)  // requests without a period may starve
            RC_ASSERT(variable.period == 0ms || bench.slot(variable.name).quality == value::Quality::good);
}

}  // namespace read_queue_test
}  // namespace takt::poll
