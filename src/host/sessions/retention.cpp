#include "sessions/retention.hpp"

#include <algorithm>
#include <utility>

#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::host {
namespace {

using Severity = endpoint::Notice::Severity;

constexpr std::size_t kMostNamed = 5;

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < kMostNamed; ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > kMostNamed ? text + ", …" : text;
}

/// The kept value in the type that the project has now.
/// @returns what value::convert() returns where it does not fit any more
Result<value::Value> fitted(const value::SlotInfo& info, const value::Value& kept) {
    if (value::is_empty(kept)) return Result<value::Value>(std::in_place);
    return value::convert(info.type, info.scaled, kept);
}

}  // namespace

Retention::~Retention() = default;

std::unique_ptr<Retention> Retention::open(const Configuration& configuration, const std::string& path,
                                           Post post, endpoint::NoticeSink notify) {
    std::unique_ptr<Retention> made(new Retention(path, std::move(post), std::move(notify)));
    made->kept_ = chosen(configuration);
    if (made->kept_.empty()) return nullptr;
    made->load(configuration);
    return made;
}

std::map<value::SlotId, Retention::Kept> Retention::chosen(const Configuration& configuration) {
    std::map<value::SlotId, Kept> kept;
    const auto& project = configuration.project();
    const auto& slots = configuration.slots();
    for (std::size_t i = 0; i < project.locals.size(); ++i)
        if (project.locals[i].retain) kept[slots.local(i)];
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& variables = project.lines[l].devices[d].variables;
            for (std::size_t v = 0; v < variables.size(); ++v)
                if (variables[v].retain) kept[slots.variable({l, d, v})].only_written = !variables[v].read;
        }
    return kept;
}

void Retention::load(const Configuration& configuration) {
    auto opened = store::RetainedFile::open(path_, [this, alive = std::weak_ptr(alive_)] {
        post_([this, alive] {
            if (!alive.expired()) settle();
        });
    });
    if (!opened) {
        const bool foreign = opened.error().code == Code::unsupported;
        notify_({Severity::error,
                 foreign ? "host.retain.foreign" : "host.retain.unavailable",
                 {{"file", path_}},
                 opened.error()});
        if (const auto entries = store::RetainedFile::read(path_)) take(configuration, *entries);
        return;
    }
    if (!opened->set_aside.empty())
        notify_(
            {Severity::warning, "host.retain.damaged", {{"file", path_}, {"aside", opened->set_aside}}, {}});
    take(configuration, opened->values);
    file_ = std::move(opened->file);
}

void Retention::take(const Configuration& configuration, const std::vector<store::Retained>& entries) {
    std::map<std::string_view, value::SlotId> by_name;
    for (const auto& [slot, kept] : kept_) by_name.emplace(configuration.info(slot).name, slot);
    std::vector<std::string> unknown;
    for (const auto& entry : entries) {
        const auto found = by_name.find(entry.name);
        if (found == by_name.end()) {
            unknown.push_back(entry.name);
            unclaimed_.emplace(entry.name, entry);
            continue;
        }
        auto& kept = kept_.at(found->second);
        auto restored =
            restored_from(entry, configuration.info(found->second), found->second, kept.only_written);
        kept.value = restored.value;
        kept.wanted = restored.wanted;
        restored_.push_back(std::move(restored));
    }
    if (!unknown.empty())
        notify_(
            {Severity::warning, "host.retain.unknown", {{"file", path_}, {"names", listed(unknown)}}, {}});
}

// A value that does not fit the type of today is reported and left out.
poll::Restored Retention::restored_from(const store::Retained& entry, const value::SlotInfo& info,
                                        value::SlotId slot, bool only_written) const {
    const auto value = fitted(info, entry.value);
    const auto wanted = fitted(info, entry.wanted);
    if (!value)
        notify_({Severity::warning,
                 "host.retain.other_type",
                 {{"file", path_},
                  {"name", entry.name},
                  {"value", value::format(entry.type, entry.scaled, entry.value)},
                  {"type", std::string(name(info.type))}},
                 {}});
    poll::Restored restored{.slot = slot};
    if (value) restored.value = *value;
    if (wanted) restored.wanted = *wanted;
    if (only_written && !value::is_empty(restored.wanted)) restored.value = restored.wanted;
    return restored;
}

void Retention::prepare(const Configuration& next) {
    restored_.clear();
    if (unclaimed_.empty()) return;
    for (const auto& [slot, kept] : chosen(next)) {
        const auto& info = next.info(slot);
        const auto entry = unclaimed_.find(info.name);
        if (entry != unclaimed_.end())
            restored_.push_back(restored_from(entry->second, info, slot, kept.only_written));
    }
}

// The kept value of a slot follows its name from one project to the next, so that the sweep writes only what
// differs from the file. The entry of a name that is not retained any more stays in the file.
void Retention::watch(const Configuration& configuration, const value::Store& slots) {
    if (slots_) {
        sweep();
        for (auto& [slot, kept] : kept_) {
            const auto& info = slots_->info(slot);
            unclaimed_.insert_or_assign(
                info.name, store::Retained{info.name, info.type, info.scaled, kept.value, kept.wanted});
        }
        kept_ = chosen(configuration);
        for (auto& [slot, kept] : kept_) {
            const auto entry = unclaimed_.find(configuration.info(slot).name);
            if (entry == unclaimed_.end()) continue;
            kept.value = std::move(entry->second.value);
            kept.wanted = std::move(entry->second.wanted);
            unclaimed_.erase(entry);
        }
    }
    slots_ = &slots;
}

// A value that is not good is the last good one or the default: neither is new.
std::uint64_t Retention::put(value::SlotId id, Kept& kept) {
    const auto& info = slots_->info(id);
    const auto& slot = (*slots_)[id];
    if (slot.quality == value::Quality::good) kept.value = slot.value;
    kept.wanted = slot.wanted;
    return file_->put({info.name, info.type, info.scaled, kept.value, kept.wanted});
}

void Retention::sweep() {
    if (!file_) return;
    for (auto& [id, kept] : kept_) {
        const auto& slot = (*slots_)[id];
        const bool other = slot.quality == value::Quality::good && !value::same(slot.value, kept.value);
        if (other || !value::same(slot.wanted, kept.wanted)) put(id, kept);
    }
}

void Retention::keep(value::SlotId slot, std::function<void(bool)> then) {
    if (!file_) return then(false);
    waiting_.push_back({put(slot, kept_.at(slot)), std::move(then)});
}

// Tickets are waited for in their order.
void Retention::settle() {
    if (!file_) return;
    const auto progress = file_->progress();
    if (progress.failed > progress.durable && failure_reported_ <= progress.durable) {
        failure_reported_ = progress.failed;
        notify_({Severity::error, "host.retain.failed", {}, progress.why});
    }
    while (!waiting_.empty() && waiting_.front().ticket <= std::max(progress.durable, progress.failed)) {
        const auto next = std::move(waiting_.front());
        waiting_.pop_front();
        next.then(next.ticket <= progress.durable);
    }
}

void Retention::on_tick(Instant t) {
    if (!file_ || t < next_sweep_) return;
    next_sweep_ = after(t, kSweepEvery);
    sweep();
}

void Retention::finish() {
    if (!file_) return;
    sweep();
    file_->close();
    settle();
    file_.reset();
}

}  // namespace takt::host
