// Between n transactions of a unit in a time there are at most n + 1 gaps. If together they are longer than
// n + 1 pauses, one of them is a pause. Half of the interval counts: relayed requests to the unit are held
// back in the other half.
#include "step_check.hpp"

#include <algorithm>
#include <set>

#include "demand.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/line_timing.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::plan {
namespace {

constexpr Microseconds kInterval =
    std::chrono::duration_cast<std::chrono::microseconds>(wire::kStepCheckInterval).count();

constexpr Microseconds kFree = kInterval / 2;  // of relayed requests

// Requests for two shapes are sent in each interval: a unit that is behind answers with the wrong one.
bool asks_for_two_shapes(const model::Line& line, const LinePlan& plan, UnitId unit) {
    std::set<std::pair<wire::Function, std::size_t>> shapes;
    for (const Request& request : plan.requests) {
        if (line.devices[request.device].address != unit || !request.read || !request.period) continue;
        if (*request.period == Duration::zero() || 2 * *request.period > wire::kStepCheckInterval) continue;
        shapes.emplace(*request.read, wire::response_pdu_length(*request.read, request.quantity));
    }
    return shapes.size() > 1;
}

/// The reads of a line, by task. Writes are left out: their responses show that the unit is in step.
class Reads {
public:
    Reads(const model::Line& line, const LinePlan& plan, const LineTasks& made)
        : made_(made), unit_(made.tasks.size()) {
        for (const LineJob& job : made.jobs) {
            const Request& request = plan.requests[job.request];
            const bool reads =
                job.cause != Cause::write || request.write == wire::Function::read_write_multiple_registers;
            if (job.task && reads) unit_[*job.task] = line.devices[request.device].address;
        }
    }

    /// @returns nothing if the pause comes anyway
    [[nodiscard]] std::optional<StepHold> hold_of(UnitId unit) const {
        StepHold made;
        Microseconds pause = 0;
        Microseconds longest_other = 0;
        WideTime busy = 0;
        WideTime gaps = 1;
        for (std::size_t i = 0; i < made_.tasks.size(); ++i) {
            const Task& task = made_.tasks[i];
            const Demand demand(task);
            Microseconds& longest = unit_[i] == unit ? pause : longest_other;
            longest = std::max(longest, demand.longest_frame());
            if (unit_[i] != unit) continue;
            made.tasks.push_back(i);
            if (task.period == 0) {
                busy = kFree;
                continue;
            }
            std::size_t frames = task.frames.size();
            for (const auto& shape : task.shapes) frames = std::max(frames, shape.size());
            const std::int64_t jobs = task.burst + (kFree + task.jitter) / task.period;
            busy += demand.most(jobs);
            gaps += static_cast<WideTime>(frames) * jobs;
        }
        if (kFree - busy >= gaps * pause) return std::nullopt;
        made.hold = pause + longest_other;
        return made;
    }

private:
    const LineTasks& made_;
    std::vector<std::optional<UnitId>> unit_;
};

// The first hold in a window may have begun before it.
Task task_of(const StepHold& hold) {
    return {.frames = {hold.hold},
            .period = kInterval,
            .deadline = kInterval + hold.hold,
            .jitter = hold.hold,
            .device = UINT32_MAX};
}

}  // namespace

std::vector<StepHold> step_holds(const model::Line& line, const LinePlan& plan, const LineTasks& made) {
    std::vector<StepHold> holds;
    if (line.framing == wire::Framing::tcp) return holds;
    const Reads reads(line, plan, made);
    std::set<UnitId> units;
    for (const Request& request : plan.requests)
        if (request.read) units.insert(line.devices[request.device].address);
    for (const UnitId unit : units)
        if (!asks_for_two_shapes(line, plan, unit))
            if (auto hold = reads.hold_of(unit)) holds.push_back(*std::move(hold));
    return holds;
}

// For the reads of the unit a hold is like a task that goes before them. At its end another transaction may
// just have begun. For all others the reads come up to that much later: a longer jitter.
Responses responses_with_holds(const LineTasks& line,
                               const std::function<Responses(const std::vector<Task>&)>& analyse) {
    if (line.holds.empty()) return analyse(line.tasks);
    std::vector<Task> later = line.tasks;
    for (const StepHold& hold : line.holds)
        for (const std::size_t i : hold.tasks) later[i].jitter += hold.hold;
    Responses made = analyse(later);
    for (const StepHold& hold : line.holds) {
        std::vector<Task> tasks = later;
        for (Task& task : tasks) ++task.priority;
        for (const std::size_t i : hold.tasks) tasks[i].jitter = line.tasks[i].jitter;
        tasks.push_back(task_of(hold));
        const Responses own = analyse(tasks);
        for (const std::size_t i : hold.tasks) made[i] = own[i];
    }
    return made;
}

std::vector<Task> tasks_and_holds(const LineTasks& line) {
    std::vector<Task> tasks = line.tasks;
    for (const StepHold& hold : line.holds) tasks.push_back(task_of(hold));
    return tasks;
}

}  // namespace takt::plan
