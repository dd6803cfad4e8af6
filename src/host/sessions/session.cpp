#include "takt/host/session.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "engine/host_link.hpp"
#include "sessions/record_codec.hpp"
#include "sessions/snapshot_request.hpp"

namespace takt::host {

Session::Session(std::shared_ptr<HostLink> link, SessionId id, const SessionOptions& options)
    : link_(std::move(link)),
      id_(id),
      listens_(options.events),
      tap_(options.traffic),
      events_(options.from_beginning ? link_->events.begin() : link_->events.end()),
      traffic_(options.from_beginning ? link_->traffic.begin() : link_->traffic.end()),
      configuration_(link_->configuration()) {
    if (tap_) ++link_->taps;
}

Session::~Session() {
    if (tap_) --link_->taps;
    link_->close_session(id_);
}

const ConfigurationPtr& Session::configuration() const {
    auto current = listens_ ? nullptr : link_->configuration();
    if (current) configuration_ = std::move(current);
    return configuration_;
}

Result<CommandId> Session::submit(const Command& command) {
    if (link_->stopped) return fail(Code::connection_lost, "host");
    auto& slot = link_->slot(id_);
    if (slot.commands >= kMostCommands) return fail(Code::queue_full, kMostCommands);
    ++slot.commands;
    auto request = std::make_unique<CommandRequest>();
    request->command = command;
    request->session = id_;
    request->generation = configuration_->generation();
    auto& outcome = request->outcome;
    outcome.id = command.kind == Command::Kind::get ? 0 : ++link_->last_command;
    outcome.tag = command.tag;
    outcome.kind = command.kind;
    outcome.slot = command.slot;
    outcome.service = command.service;
    outcome.value = command.value;
    const auto id = outcome.id;
    (void)link_->post(std::move(request));
    return id;
}

std::optional<Outcome> Session::next_outcome() {
    auto& slot = link_->slot(id_);
    while (auto command = slot.outcomes.take()) {
        if (command->session != id_) continue;  // of an earlier session in this slot
        --slot.commands;
        return std::move(command->outcome);
    }
    return std::nullopt;
}

// The indices of an event whose configuration is forgotten mean nothing any more: it counts as missed.
std::optional<Event> Session::next_event() {
    while (listens_ && link_->events.read(events_, record_)) {
        Event event = decode_event(record_);
        event.number = events_.next - 1;
        if (event.generation == configuration_->generation()) return event;
        if (auto known = link_->configuration(event.generation)) {
            configuration_ = std::move(known);
            return event;
        }
        ++events_.missed;
    }
    return std::nullopt;
}

std::optional<TrafficRecord> Session::next_traffic() {
    if (!tap_ || !link_->traffic.read(traffic_, record_)) return std::nullopt;
    return decode_traffic(record_);
}

std::optional<model::Line> Session::line_of(const TrafficRecord& record) const {
    return link_->line_of(record.source, record.generation);
}

// A plan that was learnt meanwhile may have more requests than the buffer has memory for, and what was learnt
// more ranges.
Result<Snapshot> Session::snapshot(const SnapshotParts& parts, Duration limit) {
    for (std::size_t more = 0;; more = more_memory(more)) {
        if (link_->ended) return link_->last_state(parts);
        const auto buffer =
            make_snapshot_buffer(link_->configuration(), link_->endpoint_names(), parts, more);
        (void)link_->post(std::make_unique<SnapshotFill>(buffer));
        if (!buffer->ready.try_acquire_for(limit))
            return fail(Code::timed_out, "snapshot", limit / std::chrono::milliseconds(1));
        if (link_->ended && !buffer->snapshot.configuration) return link_->last_state(parts);
        if (!buffer->snapshot.configuration) return fail(Code::connection_lost, "host");
        if (!buffer->too_small) return std::move(buffer->snapshot);
    }
}

int Session::descriptor() const {
    return link_->slot(id_).bell.get();
}

bool Session::rearm() {
    auto& slot = link_->slot(id_);
    std::uint64_t rings = 0;
    [[maybe_unused]] const auto drained = ::read(slot.bell.get(), &rings, sizeof rings);
    slot.armed.exchange(true);
    return has_more();
}

bool Session::wait(Duration limit) {
    if (rearm()) return true;
    if (link_->ended) return false;
    pollfd bell{descriptor(), POLLIN, 0};
    const auto ms = std::clamp<std::int64_t>(limit / std::chrono::milliseconds(1), 0, 1 << 30);
    (void)::poll(&bell, 1, static_cast<int>(ms));
    return has_more();
}

bool Session::has_more() const {
    return (listens_ && link_->events.has_more(events_)) || (tap_ && link_->traffic.has_more(traffic_)) ||
           !link_->slot(id_).outcomes.empty();
}

}  // namespace takt::host
