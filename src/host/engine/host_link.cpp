#include "engine/host_link.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

namespace takt::host {
namespace {

// A full counter means that the descriptor is readable already.
void ring(const os::Descriptor& bell) {
    constexpr std::uint64_t kOnce = 1;
    [[maybe_unused]] const auto written = ::write(bell.get(), &kOnce, sizeof kOnce);
}

}  // namespace

// A new id differs from every earlier one of its slot, so that outcomes for a closed session are recognised.
SessionId HostLink::open_session() {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < kMostSessions; ++i) {
        auto& slot = slots_[i];
        if (slot.id != 0) continue;
        if (!slot.bell) slot.bell.reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
        if (!slot.bell) return 0;
        while (auto left = slot.outcomes.take()) {}
        slot.commands = 0;
        slot.armed = false;
        const auto id = static_cast<SessionId>(++opened_ * kMostSessions + i);
        slot.id = id;
        return id;
    }
    return 0;
}

void HostLink::close_session(SessionId id) {
    const std::lock_guard lock(mutex_);
    slot(id).armed = false;
    slot(id).id = 0;
}

// The second check, of `ended`, refuses a request that was pushed after the I/O thread's last turn.
bool HostLink::post(std::unique_ptr<HostRequest> request) {
    if (stopped) {
        auto* const unserved = request.get();
        unserved->refuse(*this, std::move(request));
        return false;
    }
    const auto& posted = *request;
    requests.push(std::move(request));
    if (on_posted)
        on_posted(posted);
    else
        ring(bell);
    if (ended) refuse_rest();
    return true;
}

void HostLink::refuse_rest() {
    const std::lock_guard lock(mutex_);
    while (auto request = requests.take()) {
        auto* const unserved = request.get();
        unserved->refuse(*this, std::move(request));
    }
}

void HostLink::deliver(std::unique_ptr<CommandRequest> command) {
    auto& slot = this->slot(command->session);
    if (slot.id == command->session) slot.outcomes.push(std::move(command));
}

void HostLink::notify() {
    for (auto& slot : slots_) {
        // The exchange orders the records before it with the flag: a session that arms later sees them.
        if (slot.id.load(std::memory_order_relaxed) == 0 || !slot.armed.exchange(false)) continue;
        ring(slot.bell);
    }
}

ConfigurationPtr HostLink::configuration(std::uint32_t number) const {
    const std::lock_guard lock(mutex_);
    const auto found = std::ranges::find(configurations_, number, &Configuration::generation);
    return found == configurations_.end() ? nullptr : *found;
}

void HostLink::add_configuration(ConfigurationPtr configuration) {
    const std::lock_guard lock(mutex_);
    configurations_.push_back(std::move(configuration));
    if (configurations_.size() > kGenerations) configurations_.pop_front();
}

EndpointNames HostLink::endpoint_names() const {
    const std::lock_guard lock(mutex_);
    return endpoint_names_;
}

void HostLink::set_endpoint_names(EndpointNames names) {
    const std::lock_guard lock(mutex_);
    endpoint_names_ = std::move(names);
}

std::size_t HostLink::add_endpoint_line(const model::Line& line) {
    const std::lock_guard lock(mutex_);
    auto& kept = endpoint_lines_.emplace_back(line);
    for (auto& device : kept.devices) device.variables.clear();
    return endpoint_lines_.size() - 1;
}

std::optional<model::Line> HostLink::line_of(const TrafficSource& source, std::uint32_t number) const {
    const auto known = configuration(number);
    if (source.kind == TrafficSource::Kind::line)
        return known ? std::optional(known->project().lines.at(source.index)) : std::nullopt;
    const std::lock_guard lock(mutex_);
    return endpoint_lines_.at(source.index);
}

Result<Snapshot> HostLink::last_state(const SnapshotParts& parts) const {
    const std::lock_guard lock(mutex_);
    if (!last_state_) return fail(Code::connection_lost, "host");
    return last_state_(parts);
}

void HostLink::set_last_state(std::function<Snapshot(const SnapshotParts&)> source) {
    const std::lock_guard lock(mutex_);
    last_state_ = std::move(source);
}

// An accepted command that was never sent.
void CommandRequest::refuse(HostLink& link, std::unique_ptr<HostRequest> self) {
    outcome.result = value::CommandResult::expired;
    std::unique_ptr<CommandRequest> own(static_cast<CommandRequest*>(self.release()));
    link.deliver(std::move(own));
}

}  // namespace takt::host
