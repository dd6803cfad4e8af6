#include "reads/age_watch.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace takt::poll {

using value::Quality;
using value::Reason;

void AgeWatch::watch(std::size_t variables, const std::vector<Watched>& watched) {
    variables_.resize(variables);
    for (auto& variable : variables_) variable.group = AgeLimits::kNone;
    std::vector<AgeLimits::Group> groups;
    std::map<std::tuple<Duration, bool, std::vector<std::size_t>>, std::uint32_t> known;
    for (const auto& one : watched) {
        const std::tuple key(one.bound, one.split, one.readers);
        const auto [found, is_new] = known.try_emplace(key, static_cast<std::uint32_t>(groups.size()));
        if (is_new) groups.push_back({.bound = one.bound, .requests = one.readers, .variables = {}});
        groups[found->second].variables.push_back(one.variable);
        variables_[one.variable].group = found->second;
    }
    ages_ = AgeLimits(std::move(groups));
}

void AgeWatch::begin(Instant t) {
    for (std::size_t v = 0; v < variables_.size(); ++v)
        if (variables_[v].group != AgeLimits::kNone && store_[slot(v)].quality == Quality::good)
            ages_.notice(variables_[v].group, t);
}

void AgeWatch::note_read(std::span<const std::size_t> variables, Instant sampled, Instant read_at) {
    for (const auto v : variables) {
        const auto group = variables_[v].group;
        if (group == AgeLimits::kNone || ages_[group].read_at == read_at) continue;
        const auto& slot_of = store_[slot(v)];
        if (slot_of.quality == Quality::good && slot_of.good_at == read_at)
            ages_.refresh(group, sampled, read_at);
    }
}

void AgeWatch::note_updates(std::span<const value::Update> updates, Instant sampled, Instant read_at) {
    for (const auto& update : updates) {
        if (update.quality != Quality::good || update.slot.value < first_slot_.value) continue;
        auto& variable = variables_[update.slot.value - first_slot_.value];
        variable.age_when_published = read_at - sampled;
        if (variable.group != AgeLimits::kNone) ages_.notice(variable.group, sampled);
    }
}

void AgeWatch::forget(std::size_t variable) {
    if (variables_[variable].group != AgeLimits::kNone) ages_.forget(variables_[variable].group);
}

std::optional<AgeWatch::Stale> AgeWatch::take_stale(Instant t) {
    while (const auto group = ages_.take_expired(t))
        if (expire(t, *group)) return Stale{ages_[*group].variables, ages_[*group].requests};
    return std::nullopt;
}

// Some values of the group may have been read by something else than its requests.
// @returns whether a value became uncertain
bool AgeWatch::expire(Instant t, std::uint32_t index) {
    const auto& group = ages_[index];
    updates_.clear();
    std::optional<Instant> youngest_left;
    for (const auto v : group.variables) {
        const auto& slot_of = store_[slot(v)];
        if (slot_of.quality != Quality::good) continue;
        const Instant published = slot_of.good_at.value_or(group.read_at);
        const Instant sampled = published - variables_[v].age_when_published;
        if (published > group.read_at && after(sampled, group.bound) >= t)
            youngest_left = std::min(youngest_left.value_or(sampled), sampled);
        else
            updates_.push_back({slot(v), std::nullopt, Quality::uncertain, Reason::stale});
    }
    if (youngest_left) ages_.notice(index, *youngest_left);
    if (!updates_.empty()) store_.apply(t, updates_);
    return !updates_.empty();
}

}  // namespace takt::poll
