// One slice is one device, or the lists of one line: between two slices the I/O thread serves its lines. A
// transaction ends between two slices, never inside one, so the members of a request are of one moment. The
// memory is the face's, with the capacity that it could know; where a list is longer, or another project
// runs, the face asks again.
#include "sessions/snapshot_request.hpp"

#include <algorithm>
#include <string>

#include "engine/project_engine.hpp"

namespace takt::host {
namespace {

/// A slot whose texts have the memory that they may need.
value::Slot slot_with_memory(const value::SlotInfo& info, std::size_t longest) {
    value::Slot slot;
    if (info.type != DataType::string) return slot;
    slot.value = std::string(longest, '\0');
    slot.wanted = std::string(longest, '\0');
    return slot;
}

constexpr std::size_t kLongestValueText = 250;

/// @param more  ranges of each kind, beyond those that the project file brings along
std::vector<model::Learnt> learnt_with_memory(const model::Line& line, std::size_t more) {
    std::vector<model::Learnt> learnt(line.devices.size());
    for (std::size_t d = 0; d < learnt.size(); ++d)
        for (std::size_t area = 0; area < learnt[d].refused.size(); ++area) {
            learnt[d].confirmed[area].reserve(line.devices[d].learnt.confirmed[area].size() + more);
            learnt[d].refused[area].reserve(line.devices[d].learnt.refused[area].size() + more);
        }
    return learnt;
}

}  // namespace

std::shared_ptr<SnapshotBuffer> make_snapshot_buffer(const ConfigurationPtr& configuration,
                                                     EndpointNames endpoints, const SnapshotParts& parts,
                                                     std::size_t more) {
    auto buffer = std::make_shared<SnapshotBuffer>();
    buffer->parts = parts;
    buffer->made_for = configuration;
    if (parts.endpoints && endpoints) buffer->snapshot.endpoints = *endpoints;
    buffer->endpoints = std::move(endpoints);
    auto& snapshot = buffer->snapshot;
    const auto& project = configuration->project();
    if (parts.values) {
        snapshot.values.reserve(configuration->slot_count());
        for (std::uint32_t i = 0; i < configuration->slot_count(); ++i)
            snapshot.values.push_back(slot_with_memory(configuration->info({i}), kLongestValueText));
    }
    snapshot.lines.resize(project.lines.size());
    if (parts.statistics && parts.times) snapshot.line_times.resize(project.lines.size());
    for (std::size_t l = 0; l < project.lines.size(); ++l) {
        auto& line = snapshot.lines[l];
        if (parts.learnt) line.learnt = learnt_with_memory(project.lines[l], more);
        if (!parts.statistics) continue;
        std::size_t variables = 0;
        for (const auto& device : project.lines[l].devices) variables += device.variables.size();
        line.devices.resize(project.lines[l].devices.size());
        line.times.resize(project.lines[l].devices.size());
        line.variables.resize(variables);
        line.requests.reserve(configuration->plan().lines[l].requests.size() + more);
        if (parts.times) line.request_times.reserve(line.requests.capacity());
    }
    return buffer;
}

void SnapshotFill::serve(ProjectEngine& engine, Instant /*t*/, std::unique_ptr<HostRequest> self) {
    std::unique_ptr<SnapshotFill> own(static_cast<SnapshotFill*>(self.release()));
    engine.add_snapshot(std::move(own));
}

void SnapshotFill::refuse(HostLink& /*link*/, std::unique_ptr<HostRequest> /*self*/) {
    buffer_->ready.release();
}

bool SnapshotFill::fill_slice(ProjectEngine& engine, Instant t) {
    if (step_ != Step::begin && buffer_->snapshot.configuration != engine.configuration()) {
        buffer_->too_small = true;  // another project was applied meanwhile: the face asks again
        step_ = Step::done;
    }
    switch (step_) {
        case Step::begin: begin(engine); break;
        case Step::locals: copy_locals(engine); break;
        case Step::endpoints: copy_endpoints(engine); break;
        case Step::devices: copy_device(engine); break;
        case Step::line: copy_line(engine, t); break;
        case Step::done: break;
    }
    if (step_ != Step::done) return true;
    engine.publish(t);  // who has the copy can read all events that led to it
    buffer_->snapshot.t = t;
    buffer_->ready.release();
    return false;
}

void SnapshotFill::begin(ProjectEngine& engine) {
    auto& snapshot = buffer_->snapshot;
    snapshot.first_newer_event = engine.next_event();
    snapshot.configuration = engine.configuration();
    snapshot.started = engine.started();
    const bool fits = buffer_->made_for == engine.configuration();
    buffer_->too_small = !fits;
    step_ = fits ? Step::locals : Step::done;
}

void SnapshotFill::copy_slot(ProjectEngine& engine, value::SlotId slot) {
    buffer_->snapshot.values[slot.value] = engine.master().store()[slot];
}

void SnapshotFill::copy_locals(ProjectEngine& engine) {
    const auto locals = engine.configuration()->project().locals.size();
    for (std::uint32_t i = 0; i < locals && buffer_->parts.values; ++i) copy_slot(engine, {i});
    step_ = Step::endpoints;
}

void SnapshotFill::copy_endpoints(ProjectEngine& engine) {
    if (buffer_->parts.endpoints && !engine.copy_endpoints(buffer_->endpoints, buffer_->snapshot.endpoints))
        buffer_->too_small = true;
    step_ = buffer_->snapshot.lines.empty() ? Step::done : Step::devices;
}

// A device at a time: the members of a request are never torn apart.
void SnapshotFill::copy_device(ProjectEngine& engine) {
    const auto& configuration = *engine.configuration();
    const auto& devices = configuration.project().lines[line_].devices;
    if (device_ == devices.size()) {
        step_ = Step::line;
        return;
    }
    auto& line = buffer_->snapshot.lines[line_];
    const auto& poller = engine.master().line(line_);
    for (std::size_t v = 0; v < devices[device_].variables.size(); ++v) {
        if (buffer_->parts.values) copy_slot(engine, configuration.slots().variable({line_, device_, v}));
        if (buffer_->parts.statistics) line.variables[variable_ + v] = poller.variable(device_, v);
    }
    variable_ += devices[device_].variables.size();
    if (buffer_->parts.statistics) {
        line.devices[device_] = poller.device(device_);
        line.times[device_] = poller.measured(device_);
    }
    ++device_;
}

void SnapshotFill::copy_line(ProjectEngine& engine, Instant t) {
    auto& line = buffer_->snapshot.lines[line_];
    const auto& poller = engine.master().line(line_);
    line.up = engine.link_up(line_);
    line.was_up = poller.was_up();
    if (!line.up) line.why = engine.link_error(line_);
    if (buffer_->parts.statistics) {
        line.statistics = poller.statistics(t);
        const auto count = poller.plan().requests.size();
        buffer_->too_small = buffer_->too_small || count > line.requests.capacity();
        for (std::size_t r = 0; r < std::min(count, line.requests.capacity()); ++r)
            line.requests.push_back(poller.request(r));
        for (std::size_t r = 0; buffer_->parts.times && r < line.requests.size(); ++r)
            line.request_times.push_back(poller.request_times(r));
        if (buffer_->parts.times) buffer_->snapshot.line_times[line_] = poller.line_times();
    }
    if (buffer_->parts.plan || buffer_->parts.statistics) line.plan = engine.running_plan(line_);
    if (buffer_->parts.learnt && !poller.copy_learnt(t, line.learnt)) buffer_->too_small = true;
    ++line_;
    device_ = variable_ = 0;
    step_ = line_ == buffer_->snapshot.lines.size() ? Step::done : Step::devices;
}

}  // namespace takt::host
