// Trials. The plan with all untried gaps shows which gaps are worth bridging. Each such gap becomes part of
// one trial: the longest request that bridges it. Gaps that are confirmed need no trial. A refused gap is
// tried alone, together with the shortest neighbouring values, at long intervals.
#include "takt/plan/learning.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>
#include <utility>

#include "requests/boundary.hpp"
#include "requests/grouping.hpp"
#include "requests/one_line.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/proof.hpp"
#include "takt/plan/request_job.hpp"

namespace takt::plan {
namespace {

using model::ItemRange;
using model::ItemRanges;

constexpr std::array kReads{wire::Function::read_coils, wire::Function::read_discrete_inputs,
                            wire::Function::read_holding_registers, wire::Function::read_input_registers};

ItemRange items_of(const model::Variable& v) {
    const std::uint32_t last = std::uint32_t{v.start()} + std::max<std::uint32_t>(v.items(), 1) - 1;
    return {v.start(), static_cast<std::uint16_t>(std::min<std::uint32_t>(last, 65535))};
}

/// The items of a device's variables that one function reads.
class UsedItems {
public:
    UsedItems(const model::Device& device, wire::Function read) {
        for (const auto& v : device.variables)
            if (is_read(v) && v.read == read) spans_.push_back(items_of(v));
        std::ranges::sort(spans_, [](const ItemRange& a, const ItemRange& b) {
            return std::pair(a.first, a.last) < std::pair(b.first, b.last);
        });
        runs_ = model::united(spans_, {});
    }

    [[nodiscard]] const ItemRanges& runs() const { return runs_; }

    /// A gap inside a read, with the shortest values at its two ends, as far as the read contains them.
    [[nodiscard]] Gap gap(const ItemRange& items, const ItemRange& inside) const {
        Gap made{items, inside.first, inside.last};
        for (const auto& span : spans_) {
            if (span.first < items.first && span.last + 1 >= items.first)
                made.before = std::max(made.before, span.first);
            if (span.first <= items.last + 1 && span.last > items.last)
                made.after = std::min(made.after, span.last);
        }
        return made;
    }

private:
    ItemRanges spans_;
    ItemRanges runs_;
};

ItemRange range_of(const Request& request) {
    return {request.start, static_cast<std::uint16_t>(request.start + request.quantity - 1)};
}

/// The trials of one function of one device.
class TrialMaker {
public:
    TrialMaker(const model::Project& project, const model::Line& line, std::size_t device,
               wire::Function read)
        : device_(line.devices[device]),
          index_(device),
          read_(read),
          area_(static_cast<std::size_t>(area_of(read))),
          used_(device_, read),
          limit_(ItemLimit(project, line, device_, read, model::Strategy::optimal).items()) {}

    /// If requests contain each other's gaps, the longest one tries them.
    void add(std::vector<ItemRange> requests);
    void add_refused();
    [[nodiscard]] std::vector<Trial> take() { return std::move(trials_); }

private:
    const model::Device& device_;
    std::size_t index_;
    wire::Function read_;
    std::size_t area_;
    UsedItems used_;
    std::size_t limit_;
    std::vector<Trial> trials_;
};

void TrialMaker::add(std::vector<ItemRange> requests) {
    std::ranges::sort(requests, [](const ItemRange& a, const ItemRange& b) {
        return std::tuple(b.last - b.first, a.first) < std::tuple(a.last - a.first, b.first);
    });
    ItemRanges taken = device_.learnt.confirmed[area_];
    for (const auto& request : requests) {
        Trial trial{.device = index_, .read = read_, .gaps = {}};
        for (const auto& items : model::without({request}, used_.runs())) {
            if (model::holds(taken, items)) continue;
            trial.gaps.push_back(used_.gap(items, request));
            taken = model::united(taken, {items});
        }
        if (!trial.gaps.empty()) trials_.push_back(std::move(trial));
    }
}

// A refused gap is tried again together with its neighbouring values, if they fit into one read.
void TrialMaker::add_refused() {
    const auto& runs = used_.runs();
    for (std::size_t i = 1; i < runs.size(); ++i) {
        const ItemRange items{static_cast<std::uint16_t>(runs[i - 1].last + 1),
                              static_cast<std::uint16_t>(runs[i].first - 1)};
        const auto& refused = device_.learnt.refused[area_];
        const bool is_refused = std::ranges::any_of(
            refused, [&](const auto& range) { return model::overlap(range.items, items); });
        const Gap gap = used_.gap(items, {runs[i - 1].first, runs[i].last});
        if (is_refused && gap.after - gap.before < static_cast<int>(limit_))
            trials_.push_back({index_, read_, {gap}, true});
    }
}

model::Device device_confirmed_only(model::Device device) {
    if (!learns(device)) return device;
    for (std::size_t area = 0; area < device.no_read.size(); ++area)
        device.no_read[area] =
            model::united(device.no_read[area], model::all_but(device.learnt.confirmed[area]));
    return device;
}

/// A project with this line only, at index 0.
model::Project only_line(const model::Project& project, std::size_t line,
                         const std::vector<model::Learnt>& learnt) {
    auto made = with_one_line(project, project.lines[line]);
    for (std::size_t d = 0; d < learnt.size(); ++d) made.lines[0].devices[d].learnt = learnt[d];
    return made;
}

std::vector<Trial> trials_of(const model::Project& project, const LinePlan& plan) {
    const model::Line& line = project.lines[plan.line];
    std::map<std::pair<std::size_t, wire::Function>, std::vector<ItemRange>> requests;
    for (const Request& request : plan.requests)
        if (request.read && request.quantity > 0 && learns(line.devices[request.device]))
            requests[{request.device, *request.read}].push_back(range_of(request));
    std::vector<Trial> trials;
    for (std::size_t d = 0; d < line.devices.size(); ++d) {
        if (!learns(line.devices[d])) continue;
        for (const auto read : kReads) {
            TrialMaker maker(project, line, d, read);
            if (const auto found = requests.find({d, read}); found != requests.end())
                maker.add(found->second);
            maker.add_refused();
            for (Trial& trial : maker.take()) trials.push_back(std::move(trial));
        }
    }
    return trials;
}

// The holes that were confirmed before and still are.
std::vector<model::Learnt> as_before(const model::Line& line, std::vector<model::Learnt> learnt) {
    for (std::size_t d = 0; d < learnt.size(); ++d)
        for (std::size_t area = 0; area < learnt[d].confirmed.size(); ++area) {
            auto& confirmed = learnt[d].confirmed[area];
            confirmed = model::without(line.devices[d].learnt.confirmed[area], model::all_but(confirmed));
        }
    return learnt;
}

}  // namespace

bool learns(const model::Device& device) {
    return device.gaps == model::Gaps::learn && device.strategy == model::Strategy::optimal;
}

bool learns(const model::Project& project) {
    return std::ranges::any_of(project.lines, [](const model::Line& line) { return learns(line); });
}

bool learns(const model::Line& line) {
    return std::ranges::any_of(line.devices, [](const model::Device& device) { return learns(device); });
}

model::Line confirmed_only(model::Line line) {
    for (auto& device : line.devices) device = device_confirmed_only(std::move(device));
    return line;
}

model::Project confirmed_only(const model::Project& project) {
    model::Project made = project;
    for (auto& line : made.lines) line = confirmed_only(std::move(line));
    return made;
}

model::Project without_learning(const model::Project& project) {
    auto made = confirmed_only(project);
    for (auto& line : made.lines)
        for (auto& device : line.devices) {
            if (device.turnaround || !device.measured_turnaround() || device.response_timeout_set) continue;
            device.response_timeout = device.wait(project.derive_timeouts && requests_in_flight(line) == 1);
            device.response_timeout_set = true;
        }
    return made;
}

LearningPlan learning_plan(const model::Project& project, std::size_t line,
                           const std::vector<model::Learnt>& learnt) {
    const model::Project own = only_line(project, line, learnt);
    LearningPlan made;
    made.trials = trials_of(own, plan_line(own, 0));
    const model::Project sure = confirmed_only(own);
    made.plan = plan_line(sure, 0);
    if (!learnt.empty()) {
        auto proved = guarantee_line(sure, made.plan);
        if (!proved.feasible) {
            const model::Project before =
                confirmed_only(only_line(project, line, as_before(project.lines[line], learnt)));
            LinePlan plan = plan_line(before, 0);
            auto proved_before = guarantee_line(before, plan);
            if (proved_before.feasible) {
                made.plan = std::move(plan);
                proved = std::move(proved_before);
            }
        }
        put_refresh_bounds(made.plan, proved);
    }
    made.plan.line = line;
    return made;
}

std::vector<ItemRange> gaps_in(const model::Device& device, wire::Function read, const ItemRange& range) {
    return model::without({range}, UsedItems(device, read).runs());
}

}  // namespace takt::plan
