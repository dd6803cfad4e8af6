// From requests to tasks (docs/guarantees.md, "Model"):
//   - a stream of alternating requests is one cyclic task with a shape per tick, if its cycle is short
//     enough; else each of its requests is a task;
//   - a request with period 0 is a task that only blocks;
//   - a trigger or write on change with a rate limit is a sporadic task: period = least interval, burst;
//   - without a rate limit a cause has no task and no bound;
//   - commands of clients without a rate limit of their own, and relayed requests, are two tasks each.
// Priorities: commands, those of clients, relayed requests, polling; then by deadline; ties by the order of
// the plan. With `order: address` all polled tasks are equal. Periods and deadlines are rounded down to
// microseconds, costs and jitter up, so that rounding never makes a bound too small.
#include "proof/line_tasks.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "cost/transaction_cost.hpp"
#include "takt/base/assert.hpp"
#include "timing/admission.hpp"
#include "timing/calendar.hpp"
#include "timing/step_check.hpp"
#include "timing/streams.hpp"

namespace takt::plan {
namespace {

constexpr std::int64_t kMostShapes = 4096;  // limit per stream; beyond it each request is a task of its own

Microseconds microseconds_up(Duration time) {
    return std::chrono::ceil<std::chrono::microseconds>(time).count();
}

Microseconds microseconds_down(Duration time) {
    return std::chrono::floor<std::chrono::microseconds>(time).count();
}

/// A stream: periodic requests that alternate. Holds its ticks and the length of its cycle in ticks.
struct StreamCycle {
    std::vector<std::size_t> requests;
    Duration tick{};
    std::int64_t ticks = 1;
};

// Returns nothing if the cycle is too long to enumerate.
std::optional<StreamCycle> cycle_of(const LinePlan& plan, const std::vector<std::size_t>& requests) {
    StreamCycle stream{.requests = requests};
    const Request& first = plan.requests[requests.front()];
    std::int64_t tick = 0;
    for (const std::size_t i : requests) {
        const Request& request = plan.requests[i];
        tick = std::gcd(tick, std::gcd(request.period->count(), (request.phase - first.phase).count()));
    }
    for (const std::size_t i : requests) {
        const std::int64_t turn = plan.requests[i].period->count() / tick;
        const auto ticks = common_multiple(stream.ticks, turn, kMostShapes);
        if (!ticks) return std::nullopt;
        stream.ticks = *ticks;
    }
    stream.tick = Duration(tick);
    return stream;
}

bool due_at(const Request& request, Duration first, const StreamCycle& stream, std::int64_t tick) {
    const auto since = (first + stream.tick * tick - request.phase).count();
    return since % request.period->count() == 0;
}

std::vector<std::vector<std::size_t>> requests_by_stream(const LinePlan& plan) {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> index;
    std::vector<std::vector<std::size_t>> streams;
    for (std::size_t i = 0; i < plan.requests.size(); ++i) {
        const Request& request = plan.requests[i];
        if (!is_periodic(request)) continue;
        const std::pair key(request.device, request.stream);
        const auto [known, is_new] = index.try_emplace(key, streams.size());
        if (is_new) streams.emplace_back();
        streams[known->second].push_back(i);
    }
    return streams;
}

LineJob line_job(std::size_t request, const RequestJob& job) {
    LineJob made{.request = request, .cause = job.cause};
    for (const auto& cost : job.costs) {
        made.transaction += cost.transaction;
        made.failure = std::max(made.failure, cost.failure);
    }
    return made;
}

class TaskMaker {
public:
    TaskMaker(const model::Project& project, const LinePlan& plan)
        : project_(project), plan_(plan), line_(project.lines[plan.line]), costs_(project, line_) {}

    LineTasks make();

private:
    void add_polled();
    void add_stream(const std::vector<std::size_t>& requests);
    void add_shapes(const StreamCycle& stream);
    void add_alone(std::size_t request);
    void add_relayed();
    void add_clients();
    [[nodiscard]] std::optional<TransactionCost> longest_command() const;
    void add_admitted(Task task, Microseconds cost, Duration interval, std::uint16_t burst);
    void add_commanded(std::size_t request, const RequestJob& job);
    std::size_t add_task(const Request& request, const RequestJob& job);
    [[nodiscard]] RequestJob polled_job(const Request& request) const;
    void set_priorities();
    void set_connection();
    [[nodiscard]] std::vector<Lane> lanes() const;

    const model::Project& project_;
    const LinePlan& plan_;
    const model::Line& line_;
    TransactionCosts costs_;
    LineTasks made_;
    std::vector<LineJob> commanded_;
    /// Task order before deadlines are compared.
    enum class Rank : std::uint8_t { command, client, relayed, polled };
    std::vector<Rank> ranks_;              // by task
    std::vector<std::size_t> writes_;      // tasks of writes
    std::vector<std::size_t> alone_;       // tasks with a read-modify-write
    std::vector<std::size_t> tie_breaks_;  // by task: the request that breaks ties
};

LineTasks TaskMaker::make() {
    add_polled();
    for (std::size_t i = 0; i < plan_.requests.size(); ++i) {
        const Request& request = plan_.requests[i];
        for (const Cause cause : {Cause::read_trigger, Cause::write})
            if (const auto job = job_of(project_, line_, request, cause)) add_commanded(i, *job);
    }
    add_clients();
    if (line_.relayed) add_relayed();
    set_connection();
    made_.holds = step_holds(line_, plan_, made_);
    std::stable_sort(made_.jobs.begin(), made_.jobs.end(), [](const LineJob& a, const LineJob& b) {
        return std::tie(a.request, a.cause) < std::tie(b.request, b.cause);
    });
    set_priorities();
    return std::move(made_);
}

void TaskMaker::add_polled() {
    for (const auto& requests : requests_by_stream(plan_)) add_stream(requests);
    for (std::size_t i = 0; i < plan_.requests.size(); ++i)
        if (plan_.requests[i].read && plan_.requests[i].period == Duration::zero()) add_alone(i);
}

void TaskMaker::add_stream(const std::vector<std::size_t>& requests) {
    const auto cycle = requests.size() > 1 ? cycle_of(plan_, requests) : std::nullopt;
    if (cycle)
        add_shapes(*cycle);
    else
        for (const std::size_t i : requests) add_alone(i);
}

void TaskMaker::add_shapes(const StreamCycle& stream) {
    const Request& first = plan_.requests[stream.requests.front()];
    const std::size_t task = add_task(first, polled_job(first));
    Task& made = made_.tasks[task];
    made.frames.clear();
    made.shapes.resize(static_cast<std::size_t>(stream.ticks));
    made.period = microseconds_down(stream.tick);
    for (const std::size_t i : stream.requests) {
        const Request& request = plan_.requests[i];
        const RequestJob job = polled_job(request);
        LineJob polled = line_job(i, job);
        polled.task = task;
        polled.deadline = made.deadline;
        made_.jobs.push_back(polled);
        made.failure = std::max(made.failure, polled.failure);
        for (std::int64_t tick = 0; tick < stream.ticks; ++tick)
            if (due_at(request, first.phase, stream, tick))
                for (const auto& cost : job.costs)
                    made.shapes[static_cast<std::size_t>(tick)].push_back(cost.transaction);
    }
}

void TaskMaker::add_alone(std::size_t request) {
    const RequestJob job = polled_job(plan_.requests[request]);
    LineJob polled = line_job(request, job);
    polled.task = add_task(plan_.requests[request], job);
    tie_breaks_.back() = request;
    const Task& task = made_.tasks[*polled.task];
    if (task.period > 0) polled.deadline = task.deadline;
    made_.jobs.push_back(polled);
}

std::size_t TaskMaker::add_task(const Request& request, const RequestJob& job) {
    const model::Device& device = line_.devices[request.device];
    const model::Backoff& backoff = backoff_of(project_, device);
    Task task{.device = static_cast<std::uint32_t>(request.device)};
    for (const auto& cost : job.costs) {
        task.frames.push_back(cost.transaction);
        task.failure = std::max(task.failure, cost.failure);
    }
    task.period = microseconds_down(job.period);
    task.deadline = microseconds_down(job.deadline.value_or(Duration::zero()));
    task.jitter = microseconds_up(project_.host.jitter);
    task.attempts = std::max<std::uint16_t>(device.attempts, 1);
    task.backoff = microseconds_down(backoff.first);
    if (line_.framing != wire::Framing::tcp && !device.turnaround)
        task.late = microseconds_up(device.response_timeout);
    made_.tasks.push_back(std::move(task));
    ranks_.push_back(Rank::polled);
    tie_breaks_.push_back(static_cast<std::size_t>(&request - plan_.requests.data()));
    return made_.tasks.size() - 1;
}

RequestJob TaskMaker::polled_job(const Request& request) const {
    auto job = job_of(project_, line_, request, Cause::period);
    TAKT_ASSERT(job);
    return *std::move(job);
}

void TaskMaker::add_commanded(std::size_t index, const RequestJob& job) {
    LineJob commanded = line_job(index, job);
    if (job.job_class != JobClass::best_effort) {
        const std::size_t number = add_task(plan_.requests[index], job);
        Task& task = made_.tasks[number];
        task.period = std::max<Microseconds>(1, task.period);
        task.burst = std::max<std::uint16_t>(job.admission->burst, 1);
        ranks_[number] = Rank::command;
        if (job.cause == Cause::write) writes_.push_back(number);
        if (job.read_before) alone_.push_back(number);
        commanded.task = number;
        commanded.deadline = task.deadline;
    }
    made_.jobs.push_back(commanded);
}

// Transactions that bus::TransactionGate admits ahead of polling, and those that start while nothing is due,
// which may delay polling. With costs c <= C, n starts in a window t need the sum of n - 1 costs and
// n - burst intervals: their cost is at most (burst + floor((t + C) / (interval + C))) * C, which is a period
// of interval + C with a jitter of C. The overhead of the host is a part of C.
void TaskMaker::add_admitted(Task task, Microseconds cost, Duration interval, std::uint16_t burst) {
    const Microseconds free = microseconds_down(interval - project_.host.overhead);
    task.frames = {cost};
    // Several in flight end at the same time, so that the interval alone separates their starts.
    task.period = requests_in_flight(line_) > 1 ? std::max<Microseconds>(1, free)
                                                : std::max<Microseconds>(0, free) + cost;
    task.jitter = cost;
    task.deadline = task.period + task.jitter;
    Task idle = task;
    idle.period = 0;
    task.burst = burst;
    made_.tasks.push_back(std::move(task));
    made_.tasks.push_back(std::move(idle));
}

// The cost of a relayed request is that of a failed attempt, so no retry is added.
void TaskMaker::add_relayed() {
    made_.relayed = made_.tasks.size();
    add_admitted({.device = static_cast<std::uint32_t>(line_.devices.size())}, costs_.of_relayed(),
                 line_.relay_interval, 1);
    ranks_.insert(ranks_.end(), 2, Rank::relayed);
    tie_breaks_.insert(tie_breaks_.end(), 2, plan_.requests.size());
}

// Commands of servers (`writes_to`) without a rate limit of their own: at the rate of the line. Together they
// count as a device of their own, which may die.
void TaskMaker::add_clients() {
    const auto longest = longest_command();
    if (!longest) return;
    Task task{.failure = longest->failure, .device = static_cast<std::uint32_t>(line_.devices.size()) + 1};
    for (const auto& device : line_.devices) {
        task.attempts = std::max<std::uint32_t>(task.attempts, device.attempts);
        if (line_.framing != wire::Framing::tcp && !device.turnaround)
            task.late = std::max(task.late, microseconds_up(device.response_timeout));
    }
    task.backoff = microseconds_down(project_.backoff.first);
    made_.clients = made_.tasks.size();
    add_admitted(std::move(task), longest->transaction, line_.commands.min_interval, line_.commands.burst);
    ranks_.insert(ranks_.end(), 2, Rank::client);
    tie_breaks_.insert(tie_breaks_.end(), 2, plan_.requests.size());
}

// The greatest C of a command, all its transactions together, and the greatest F of one of them.
std::optional<TransactionCost> TaskMaker::longest_command() const {
    std::optional<TransactionCost> longest;
    const auto note = [&](const RequestCosts& costs) {
        TransactionCost sum;
        for (const auto& cost : costs) {
            sum.transaction += cost.transaction;
            sum.failure = std::max(sum.failure, cost.failure);
        }
        if (!longest) longest.emplace();
        longest->transaction = std::max(longest->transaction, sum.transaction);
        longest->failure = std::max(longest->failure, sum.failure);
    };
    for (const auto& device : line_.devices)
        for (const auto& variable : device.variables) {
            const bool apart =
                !variable.write_on_change && !trigger_admission(project_, variable.write_trigger);
            if (variable.written_by_clients && variable.used && variable.write && apart)
                note(costs_.of_command(device, variable));
        }
    for (const Request& request : plan_.requests) {
        if (!request.write || !request.write_on_change || request.admission) continue;
        const auto& variables = line_.devices[request.device].variables;
        if (std::ranges::any_of(request.variables,
                                [&](std::size_t v) { return variables[v].written_by_clients; }))
            note(costs_.of_write(request));
    }
    return longest;
}

// The poller sends to each device as much as that device takes, and one write at a time. A task of many
// devices counts in the lanes of all of them. A read-modify-write waits until its device has answered.
void TaskMaker::set_connection() {
    const std::size_t in_flight = requests_in_flight(line_);
    if (in_flight <= 1) return;
    Connection made{.in_flight = static_cast<std::uint32_t>(in_flight)};
    made.pause = microseconds_up(line_.request_gap + line_.frame_gap + project_.host.overhead);
    made.lanes = lanes();
    made.alone.resize(made_.tasks.size());
    for (const auto task : alone_) made.alone[task] = true;
    const bool modifying = std::ranges::any_of(line_.devices, &model::Device::read_modify_write);
    if (made_.clients && modifying) made.alone[*made_.clients] = made.alone[*made_.clients + 1] = true;
    made_.connection = std::move(made);
}

std::vector<Lane> TaskMaker::lanes() const {
    std::vector<std::size_t> of_any;
    for (const auto& first : {made_.clients, made_.relayed})
        if (first) of_any.insert(of_any.end(), {*first, *first + 1});
    std::vector<Lane> lanes;
    const auto add = [&](std::size_t device, std::uint16_t in_flight, const std::vector<std::size_t>& tasks) {
        Lane lane{.tasks = of_any, .in_flight = in_flight};
        for (const auto i : tasks)
            if (made_.tasks[i].device == device) lane.tasks.push_back(i);
        if (lane.tasks.size() > 1) lanes.push_back(std::move(lane));
    };
    std::vector<std::size_t> all(made_.tasks.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (std::size_t device = 0; device < line_.devices.size(); ++device) {
        const auto most = line_.devices[device].in_flight;
        if (most < requests_in_flight(line_)) add(device, most, all);
        if (most > 1) add(device, 1, writes_);
    }
    return lanes;
}

void TaskMaker::set_priorities() {
    std::vector<std::size_t> order(made_.tasks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        const auto key = [&](std::size_t i) {
            return std::tuple(ranks_[i], made_.tasks[i].deadline, tie_breaks_[i], i);
        };
        return key(a) < key(b);
    });
    const bool rounds = line_.order == model::PollOrder::address;
    std::uint32_t next = 0;
    for (const std::size_t i : order) {
        made_.tasks[i].priority = next;
        if (ranks_[i] != Rank::polled || !rounds) ++next;
    }
}

// The longest interval between two reads of a variable in the stream's cycle, including the wrap-around.
Duration longest_gap(const LinePlan& plan, const StreamCycle& stream,
                     const std::vector<std::size_t>& readers) {
    const Duration first = plan.requests[stream.requests.front()].phase;
    std::optional<std::int64_t> begin;
    std::int64_t last = 0;
    std::int64_t longest = 0;
    for (std::int64_t tick = 0; tick < stream.ticks; ++tick) {
        const bool read = std::any_of(readers.begin(), readers.end(), [&](std::size_t i) {
            return due_at(plan.requests[i], first, stream, tick);
        });
        if (!read) continue;
        if (begin) longest = std::max(longest, tick - last);
        if (!begin) begin = tick;
        last = tick;
    }
    return stream.tick * std::max(longest, begin.value_or(0) + stream.ticks - last);
}

bool holds_whole(const Request& request, const model::Variable& variable) {
    return variable.start() >= request.start &&
           variable.start() + variable.items() <= request.start + request.quantity;
}

using Distances = std::vector<std::vector<std::optional<Duration>>>;

void note_stream(const model::Line& line, const LinePlan& plan, const std::vector<std::size_t>& requests,
                 Distances& distances) {
    const auto cycle = requests.size() > 1 ? cycle_of(plan, requests) : std::nullopt;
    std::map<std::size_t, std::vector<std::size_t>> readers;
    for (const std::size_t i : requests)
        for (const std::size_t v : plan.requests[i].variables) readers[v].push_back(i);
    const std::size_t device = plan.requests[requests.front()].device;
    for (const auto& [v, by] : readers) {
        const model::Variable& variable = line.devices[device].variables[v];
        const bool whole = std::all_of(
            by.begin(), by.end(), [&](std::size_t i) { return holds_whole(plan.requests[i], variable); });
        auto& distance = distances[device][v];
        if (whole && cycle && by.size() > 1) {
            distance = longest_gap(plan, *cycle, by);
        } else if (whole) {
            for (const std::size_t i : by)
                distance = std::min(distance.value_or(*plan.requests[i].period), *plan.requests[i].period);
        } else {  // a value in parts: its age is that of the rarest part
            for (const std::size_t i : by)
                distance = std::max(distance.value_or(Duration::zero()), *plan.requests[i].period);
        }
    }
}

}  // namespace

LineTasks line_tasks(const model::Project& project, const LinePlan& plan) {
    return TaskMaker(project, plan).make();
}

Distances read_distances(const model::Line& line, const LinePlan& plan) {
    Distances distances;
    for (const auto& device : line.devices) distances.emplace_back(device.variables.size());
    for (const auto& requests : requests_by_stream(plan)) note_stream(line, plan, requests, distances);
    return distances;
}

}  // namespace takt::plan
