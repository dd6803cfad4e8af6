#include "retention.hpp"

#include <algorithm>
#include <utility>

#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::host {
namespace {

constexpr std::size_t kMostNamed = 5;

std::string listed(const std::vector<std::string>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < kMostNamed; ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > kMostNamed ? text + ", …" : text;
}

/// The kept value as the project has it now.
/// @returns what value::convert() returns where it does not fit any more
Result<value::Value> fitted(const value::SlotInfo& info, const value::Value& kept) {
    if (value::is_empty(kept)) return Result<value::Value>(std::in_place);
    return value::convert(info.type, info.scaled, kept);
}

}  // namespace

Retention::~Retention() = default;

std::unique_ptr<Retention> Retention::open(const Configuration& configuration, const std::string& path, Post post,
                                           endpoint::NoticeSink notify) {
    std::unique_ptr<Retention> made(new Retention(std::move(post), std::move(notify)));
    made->choose(configuration);
    if (made->kept_.empty()) return nullptr;
    made->load(configuration, path);
    return made;
}

void Retention::choose(const Configuration& configuration) {
    const auto& project = configuration.project();
    const auto& slots = configuration.slots();
    for (std::size_t i = 0; i < project.locals.size(); ++i)
        if (project.locals[i].retain) kept_[slots.local(i)];
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& variables = project.lines[l].devices[d].variables;
            for (std::size_t v = 0; v < variables.size(); ++v)
                if (variables[v].retain) kept_[slots.variable({l, d, v})].only_written = !variables[v].read;
        }
}

void Retention::load(const Configuration& configuration, const std::string& path) {
    auto opened = store::RetainedFile::open(path, [this, alive = std::weak_ptr(alive_)] {
        post_([this, alive] {
            if (!alive.expired()) settle();
        });
    });
    if (!opened) {
        const bool foreign = opened.error().code == Code::unsupported;
        notify_(endpoint::make_notice(foreign ? "app.retain.foreign" : "app.retain.unavailable", {{"file", path}}, opened.error()));
        if (const auto entries = store::RetainedFile::read(path)) take(configuration, path, *entries);
        return;
    }
    if (!opened->set_aside.empty())
        notify_(endpoint::make_notice("app.retain.damaged", {{"file", path}, {"aside", opened->set_aside}}));
    take(configuration, path, opened->values);
    file_ = std::move(opened->file);
}

void Retention::take(const Configuration& configuration, const std::string& path,
                     const std::vector<store::Retained>& entries) {
    std::map<std::string_view, value::SlotId> by_name;
    for (const auto& [slot, kept] : kept_) by_name.emplace(configuration.info(slot).name, slot);
    std::vector<std::string> unknown;
    for (const auto& entry : entries) {
        const auto found = by_name.find(entry.name);
        if (found == by_name.end()) {
            unknown.push_back(entry.name);
            continue;
        }
        const auto& info = configuration.info(found->second);
        const auto value = fitted(info, entry.value);
        const auto wanted = fitted(info, entry.wanted);
        if (!value)
            notify_(endpoint::make_notice("app.retain.other_type",
                            {{"file", path},
                             {"name", entry.name},
                             {"value", value::format(entry.type, entry.scaled, entry.value)},
                             {"type", std::string(name(info.type))}}));
        poll::Restored restored{.slot = found->second};
        if (value) restored.value = *value;
        if (wanted) restored.wanted = *wanted;
        auto& kept = kept_.at(found->second);
        if (kept.only_written && !value::is_empty(restored.wanted)) restored.value = restored.wanted;
        kept.value = restored.value;
        kept.wanted = restored.wanted;
        restored_.push_back(std::move(restored));
    }
    if (!unknown.empty())
        notify_(endpoint::make_notice("app.retain.unknown", {{"file", path}, {"names", listed(unknown)}}));
}

// A slot that is still retained keeps what was written of it: the next sweep writes it only if it differs.
void Retention::watch(const Configuration& configuration, const value::Store& slots) {
    if (slots_) {
        std::map<std::string, Kept, std::less<>> by_name;
        for (auto& [slot, kept] : kept_) by_name.emplace(slots_->info(slot).name, std::move(kept));
        kept_.clear();
        choose(configuration);
        for (auto& [slot, kept] : kept_) {
            const auto known = by_name.find(configuration.info(slot).name);
            if (known == by_name.end()) continue;
            const bool only_written = kept.only_written;
            kept = std::move(known->second);
            kept.only_written = only_written;
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
        notify_(endpoint::make_notice("app.retain.failed", {}, progress.why));
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
