#include "takt/app/retention.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::app {
namespace {

constexpr Duration kSweepEvery = std::chrono::seconds(1);
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

std::string default_state_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".state").string();
}

Retention::Retention(line::Loop& loop, const Texts& texts)
    : loop_(loop), texts_(texts), sweep_timer_(loop, [this](Instant t) {
          sweep();
          sweep_timer_.set(after(t, kSweepEvery));
      }) {}

Retention::~Retention() = default;

std::unique_ptr<Retention> Retention::open(line::Loop& loop, const Texts& texts,
                                           const model::Project& project, const std::string& path) {
    std::unique_ptr<Retention> made(new Retention(loop, texts));
    made->choose(project);
    if (made->kept_.empty()) return nullptr;
    made->load(path, poll::slot_infos(project));
    return made;
}

void Retention::choose(const model::Project& project) {
    const poll::ProjectSlots slots(project);
    for (std::size_t i = 0; i < project.locals.size(); ++i)
        if (project.locals[i].retain) kept_[slots.local(i)];
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& variables = project.lines[l].devices[d].variables;
            for (std::size_t v = 0; v < variables.size(); ++v)
                if (variables[v].retain) kept_[slots.variable({l, d, v})].only_written = !variables[v].read;
        }
}

void Retention::load(const std::string& path, const std::vector<value::SlotInfo>& infos) {
    auto opened = store::RetainedFile::open(path, [this, alive = std::weak_ptr(alive_)] {
        loop_.post([this, alive] {
            if (!alive.expired()) settle();
        });
    });
    if (!opened) {
        const bool foreign = opened.error().code == Code::unsupported;
        const auto why = foreign ? texts_("app.retain.foreign", {{"file", path}})
                                 : without_stop(texts_.describe(opened.error()));
        print_error(texts_("app.retain.unavailable", {{"error", why}}));
        if (const auto entries = store::RetainedFile::read(path)) take(path, *entries, infos);
        return;
    }
    if (!opened->set_aside.empty())
        print_error(texts_("app.retain.damaged", {{"file", path}, {"aside", opened->set_aside}}));
    take(path, opened->values, infos);
    file_ = std::move(opened->file);
}

void Retention::take(const std::string& path, const std::vector<store::Retained>& entries,
                     const std::vector<value::SlotInfo>& infos) {
    std::map<std::string_view, value::SlotId> by_name;
    for (const auto& [slot, kept] : kept_) by_name.emplace(infos[slot.value].name, slot);
    std::vector<std::string> unknown;
    for (const auto& entry : entries) {
        const auto found = by_name.find(entry.name);
        if (found == by_name.end()) {
            unknown.push_back(entry.name);
            continue;
        }
        const auto& info = infos[found->second.value];
        const auto value = fitted(info, entry.value);
        const auto wanted = fitted(info, entry.wanted);
        if (!value)
            print_error(texts_("app.retain.other_type",
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
        print_error(texts_("app.retain.unknown", {{"file", path}, {"names", listed(unknown)}}));
}

void Retention::follow(const value::Store& slots) {
    slots_ = &slots;
    sweep_timer_.set(after(line::now(), kSweepEvery));
}

// A value that is not good is the last good one or the default: neither is news.
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
    if (progress.failed > progress.durable && failure_told_ <= progress.durable) {
        failure_told_ = progress.failed;
        print_error(texts_("app.retain.failed", {{"error", without_stop(texts_.describe(progress.why))}}));
    }
    while (!waiting_.empty() && waiting_.front().ticket <= std::max(progress.durable, progress.failed)) {
        const auto next = std::move(waiting_.front());
        waiting_.pop_front();
        next.then(next.ticket <= progress.durable);
    }
}

void Retention::finish() {
    if (!file_) return;
    sweep();
    sweep_timer_.set(kNever);
    file_->close();
    settle();
    file_.reset();
}

}  // namespace takt::app
