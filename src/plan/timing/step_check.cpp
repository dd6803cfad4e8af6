// A chain is a sequence of reads of one unit with responses of one shape, each of which begins less than a
// pause after the response before. Its first read is the last one that is known to be in step. The poller
// holds a read if its chain is as old as the interval. So a unit is never held if no chain gets that old:
//   - another shape is asked for in each interval, or
//   - for no D from the interval on, n reads start within D, and D < their costs + n pauses.
// A chain that gets old was younger at its last read but one, so only D up to the interval + one cost + one
// pause count. The start of a read is its release, and at most its response without its cost later.
// Relayed requests to the unit may fill the first half of the interval; in the other half they are held back.
#include "timing/step_check.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "takt/wire/function.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/pdu.hpp"
#include "timing/demand.hpp"

namespace takt::plan {
namespace {

constexpr Microseconds kInterval =
    std::chrono::duration_cast<std::chrono::microseconds>(wire::kStepCheckInterval).count();

using ReadShape = std::pair<wire::Function, std::size_t>;  // of a response

/// The reads of a unit while they are collected.
struct UnitReads {
    std::map<std::size_t, std::set<ReadShape>> shapes;  // by task
    std::set<std::size_t> polled;
};

// Writes are left out: their responses show that the unit is in step.
std::map<UnitId, UnitReads> reads_of(const model::Line& line, const LinePlan& plan, const LineTasks& made) {
    std::map<UnitId, UnitReads> units;
    for (const LineJob& job : made.jobs) {
        const Request& request = plan.requests[job.request];
        const bool reads =
            job.cause != Cause::write || request.write == wire::Function::read_write_multiple_registers;
        if (!job.task || !reads) continue;
        const auto function = request.read.value_or(wire::Function::read_write_multiple_registers);
        UnitReads& unit = units[line.devices[request.device].address];
        unit.shapes[*job.task].emplace(function, wire::response_pdu_length(function, request.quantity));
        if (job.cause == Cause::period) unit.polled.insert(*job.task);
    }
    return units;
}

StepHold hold_of(const UnitReads& unit, const LineTasks& made) {
    StepHold hold;
    std::map<ReadShape, std::vector<std::size_t>> by_shape;
    for (const auto& [task, shapes] : unit.shapes) {
        hold.tasks.push_back(task);
        for (const ReadShape& shape : shapes) by_shape[shape].push_back(task);
        if (shapes.size() == 1 && unit.polled.contains(task)) hold.periodic.push_back(task);
    }
    for (auto& [shape, tasks] : by_shape) hold.by_shape.push_back(std::move(tasks));
    Microseconds longest_other = 0;
    for (std::size_t i = 0; i < made.tasks.size(); ++i) {
        Microseconds& longest = unit.shapes.contains(i) ? hold.pause : longest_other;
        longest = std::max(longest, Demand(made.tasks[i]).longest_frame());
    }
    hold.hold = hold.pause + longest_other;
    return hold;
}

/// One task of a chain.
struct ChainedReads {
    Demand demand;
    Arrivals starts;
    std::int64_t frames = 0;  ///< of one job
    Microseconds shortest = 0;

    /// @param response  from the release to the end
    ChainedReads(const Task& task, Microseconds response) : demand(task), shortest(demand.longest_frame()) {
        const auto note = [this](const std::vector<Microseconds>& job) {
            frames = std::max(frames, static_cast<std::int64_t>(job.size()));
            for (const Microseconds frame : job) shortest = std::min(shortest, frame);
        };
        note(task.frames);
        for (const auto& job : task.shapes) note(job);
        const Microseconds latest = std::max<Microseconds>(response - shortest, 0);
        starts = {.period = task.period, .jitter = latest, .burst = task.burst};
    }
    /// Two starts in a row are not further apart.
    [[nodiscard]] Microseconds longest_gap() const { return starts.period + starts.jitter; }
};

/// The reads whose responses have one shape.
class ReadChain {
public:
    ReadChain(std::vector<ChainedReads> reads, Microseconds pause)
        : reads_(std::move(reads)), pause_(pause) {}

    [[nodiscard]] bool reaches(Microseconds interval) const {
        Microseconds longest = 0;
        for (const ChainedReads& reads : reads_) longest = std::max(longest, reads.demand.longest_frame());
        if (may_last(interval)) return true;
        for (const ChainedReads& reads : reads_) {
            const auto& [period, jitter, late, burst] = reads.starts;
            for (auto n = (interval + jitter) / period + 1;
                 n * period - jitter <= interval + longest + pause_; ++n)
                if (may_last(n * period - jitter)) return true;
        }
        return false;
    }

private:
    // The read that starts at the end is not part of the time before it.
    [[nodiscard]] bool may_last(Microseconds time) const {
        WideTime busy = 0;
        std::int64_t starts = 0;
        Microseconds shortest = kLongestBusyPeriod;
        for (const ChainedReads& reads : reads_) {
            const std::int64_t jobs = reads.starts.closed(time);
            busy += reads.demand.most(jobs);
            starts += reads.frames * jobs;
            shortest = std::min(shortest, reads.shortest);
        }
        return busy - shortest + WideTime{starts - 1} * pause_ > time;
    }

    std::vector<ChainedReads> reads_;
    Microseconds pause_;
};

/// @param responses  of all tasks
bool is_needed(const LineTasks& line, const StepHold& hold, const Responses& responses) {
    const auto other_shape_is_certain = [&](const std::vector<std::size_t>& tasks) {
        return std::ranges::any_of(hold.periodic, [&](std::size_t i) {
            const bool same = std::ranges::find(tasks, i) != tasks.end();
            if (same || line.tasks[i].period == 0 || !responses[i]) return false;
            return ChainedReads(line.tasks[i], *responses[i]).longest_gap() <= kInterval;
        });
    };
    const Microseconds interval = line.relayed ? kInterval / 2 : kInterval;
    return std::ranges::any_of(hold.by_shape, [&](const std::vector<std::size_t>& tasks) {
        if (other_shape_is_certain(tasks)) return false;
        std::vector<ChainedReads> reads;
        for (const std::size_t i : tasks) {
            if (line.tasks[i].period == 0 || !responses[i]) return true;
            reads.emplace_back(line.tasks[i], *responses[i]);
        }
        return ReadChain(std::move(reads), hold.pause).reaches(interval);
    });
}

// The first hold in a window may have begun before it.
Task task_of(const StepHold& hold) {
    return {.frames = {hold.hold},
            .period = kInterval,
            .deadline = kInterval + hold.hold,
            .jitter = hold.hold,
            .device = kNoDevice};
}

// For the reads of the unit a hold is like a task that goes before them. At its end another transaction may
// just have begun. For all others the reads come up to that much later: a longer jitter.
Responses responses_with(const LineTasks& line, const std::vector<bool>& held,
                         const std::function<Responses(const std::vector<Task>&)>& analyse) {
    std::vector<Task> later = line.tasks;
    for (std::size_t h = 0; h < held.size(); ++h)
        if (held[h])
            for (const std::size_t i : line.holds[h].tasks) later[i].jitter += line.holds[h].hold;
    Responses made = analyse(later);
    for (std::size_t h = 0; h < held.size(); ++h) {
        if (!held[h]) continue;
        const StepHold& hold = line.holds[h];
        std::vector<Task> tasks = later;
        for (Task& task : tasks) ++task.priority;
        for (const std::size_t i : hold.tasks) tasks[i].jitter = line.tasks[i].jitter;
        tasks.push_back(task_of(hold));
        const Responses own = analyse(tasks);
        for (const std::size_t i : hold.tasks) made[i] = own[i];
    }
    return made;
}

}  // namespace

std::vector<StepHold> step_holds(const model::Line& line, const LinePlan& plan, const LineTasks& made) {
    std::vector<StepHold> holds;
    if (line.framing == wire::Framing::tcp) return holds;
    for (const auto& [unit, reads] : reads_of(line, plan, made)) holds.push_back(hold_of(reads, made));
    return holds;
}

std::vector<bool> holds_needed(const LineTasks& line, const Responses& responses) {
    std::vector<bool> needed;
    for (const StepHold& hold : line.holds) needed.push_back(is_needed(line, hold, responses));
    return needed;
}

// Least fixed point. Until the first hold of a unit that is not held, all responses are those computed
// without it; they exclude that hold.
Responses responses_with_holds(const LineTasks& line,
                               const std::function<Responses(const std::vector<Task>&)>& analyse) {
    std::vector<bool> held(line.holds.size());
    for (;;) {
        Responses responses = responses_with(line, held, analyse);
        const auto needed = holds_needed(line, responses);
        bool more = false;
        for (std::size_t h = 0; h < held.size(); ++h) {
            more |= needed[h] && !held[h];
            held[h] = held[h] || needed[h];
        }
        if (!more) return responses;
    }
}

std::vector<Task> tasks_and_holds(const LineTasks& line) {
    std::vector<Task> tasks = line.tasks;
    Responses deadlines;
    for (const Task& task : line.tasks) deadlines.emplace_back(task.deadline);
    const auto needed = holds_needed(line, deadlines);
    for (std::size_t h = 0; h < needed.size(); ++h)
        if (needed[h]) tasks.push_back(task_of(line.holds[h]));
    return tasks;
}

}  // namespace takt::plan
