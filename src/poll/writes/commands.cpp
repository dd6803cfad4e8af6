// Commands: what the line does when they arrive, and when nothing can be sent (CommandQueue).
#include <algorithm>
#include <utility>

#include "line/run.hpp"

namespace takt::poll {

using value::Reason;

// Commands of a variable with a write trigger pass the bucket of the trigger.
Result<bool> LinePoller::Run::write(Instant t, const value::WriteCommand& command) {
    TAKT_TRY(const std::size_t v, writable(command.slot));
    const auto& device = devices_[variables_[v].device];
    TAKT_TRY(const Written written, as_written(*variables_[v].model, command.value));
    if (commands_.full()) return fail(Code::queue_full, static_cast<std::int64_t>(kMaxCommands));
    PendingCommand pending{.command = command,
                           .variable = v,
                           .device = variables_[v].device,
                           .rounded = written.rounded,
                           .group = write_groups_.on_change(v)};
    pending.command.value = written.value;
    if (!pending.group) {
        TAKT_TRY(pending.alone, single_write_of(*device.model, *variables_[v].model, written));
        const auto by_trigger = write_groups_.by_trigger(v);
        if (by_trigger && write_groups_.bucket(*by_trigger)) pending.alone.bucket_of = by_trigger;
    }
    if (!reachable(device)) {
        const Reason reason = device.health.unreachable(link_.no_link());
        statuses_.show_unavailable(t, v, reason);
        commands_.refuse(t, command, written.rounded, reason);
        return written.rounded;
    }
    pending.before = written_values_.wanted(v);
    pending.want = written_values_.want(v, written);
    const auto group = pending.group;
    if (group) write_groups_.ask(t, *group);
    pending.order = arrivals_.next();
    commands_.add(t, std::move(pending));
    if (group) offers_.note_event(*group);
    return written.rounded;
}

void LinePoller::Run::drop_pending(Instant t, std::size_t index, Reason reason) {
    drop_read_backs(t, index, reason);
    commands_.drop_waiting(t, index, reason);
    for (const auto r : devices_[index].requests) {
        if (requests_[r].read) reads_.drop_trigger(r);
        if (write_groups_.has(r)) write_groups_.drop_trigger(r);
    }
}

}  // namespace takt::poll
