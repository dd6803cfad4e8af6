#include "live/why.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "live/live_values.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::web {
namespace {

using HopKind = WhyHop::Kind;
using HopState = WhyHop::State;

constexpr double kBusy = 0.95;  // of the line: requests wait for each other

std::string_view hop_kind_word(HopKind kind) {
    switch (kind) {
        case HopKind::enable: return "enable";
        case HopKind::period: return "period";
        case HopKind::trigger: return "trigger";
        case HopKind::queue: return "queue";
        case HopKind::line: return "line";
        case HopKind::device: return "device";
        case HopKind::back_off: return "back_off";
    }
    return "";
}

std::string_view hop_state_word(HopState state) {
    switch (state) {
        case HopState::ok: return "ok";
        case HopState::wait: return "wait";
        case HopState::trouble: return "trouble";
    }
    return "";
}

/// The hops of a variable of a device.
class Way {
public:
    Way(const report::Texts& texts, const host::Snapshot& snapshot, value::SlotId slot,
        const value::VariableIndex& index)
        : texts_(texts),
          snapshot_(snapshot),
          slot_(snapshot.values.at(slot.value)),
          index_(index),
          project_(snapshot.configuration->project()),
          line_(project_.lines[index.line]),
          device_(line_.devices[index.device]),
          variable_(device_.variables[index.variable]),
          state_(snapshot.lines.at(index.line)) {}

    std::vector<WhyHop> hops() {
        if (!variable_.read) return {{HopKind::period, HopState::wait, "web.why.not_read"}};
        if (!variable_.used) return {{HopKind::period, HopState::wait, "web.why.not_used"}};
        enable();
        period();
        queue();
        link();
        device();
        back_off();
        return std::move(hops_);
    }

private:
    void enable() {
        if (!device_.poll_enable) return;
        const auto slot = snapshot_.configuration->slots().local(*device_.poll_enable);
        const bool on = value::same(snapshot_.values.at(slot.value).value, true);
        hops_.push_back({HopKind::enable,
                         on ? HopState::ok : HopState::wait,
                         on ? "web.why.enabled" : "web.why.switched_off",
                         {{"device", device_.name}, {"local", project_.locals[*device_.poll_enable].name}}});
    }

    [[nodiscard]] bool is_polled() const {
        if (!state_.plan) return true;
        return std::ranges::any_of(state_.plan->requests, [this](const plan::Request& request) {
            return request.device == index_.device && request.read && request.period &&
                   std::ranges::find(request.variables, index_.variable) != request.variables.end();
        });
    }

    [[nodiscard]] const poll::VariableStatistics* statistics() const {
        std::size_t at = index_.variable;
        for (std::size_t device = 0; device < index_.device; ++device)
            at += line_.devices[device].variables.size();
        return at < state_.variables.size() ? &state_.variables[at] : nullptr;
    }

    void period() {
        if (variable_.read_trigger)
            hops_.push_back({HopKind::trigger,
                             is_polled() ? HopState::ok : HopState::wait,
                             is_polled() ? "web.why.also_trigger" : "web.why.trigger",
                             {{"local", project_.locals[*variable_.read_trigger].name}}});
        if (!is_polled()) return;
        const auto* const measured = statistics();
        const bool overrun = measured && measured->overrun;
        const auto set = variable_.period;
        const auto real = measured ? measured->recent_period : Duration{};
        if (set == Duration{}) {
            hops_.push_back({HopKind::period,
                             HopState::ok,
                             "web.why.period_free",
                             {{"real", texts_.duration(real)}},
                             real});
            return;
        }
        hops_.push_back({HopKind::period,
                         overrun ? HopState::trouble : HopState::ok,
                         overrun              ? "web.why.overrun"
                         : real == Duration{} ? "web.why.period_unmeasured"
                                              : "web.why.period",
                         {{"period", texts_.duration(set)}, {"real", texts_.duration(real)}},
                         overrun ? real : set});
    }

    void queue() {
        const auto& line = state_.statistics;
        const bool busy = line.recent_utilization >= kBusy;
        const auto cycle = line.measured_cycle > Duration{} ? line.measured_cycle : line.planned_cycle;
        hops_.push_back({HopKind::queue,
                         busy ? HopState::trouble : HopState::ok,
                         busy ? "web.why.busy" : "web.why.queue",
                         {{"line", line_.name},
                          {"load", report::percent_text(line.recent_utilization)},
                          {"cycle", texts_.duration(cycle)}},
                         cycle});
    }

    void link() {
        if (state_.up) {
            hops_.push_back({HopKind::line, HopState::ok, "web.why.connected", {{"line", line_.name}}});
            return;
        }
        hops_.push_back({.kind = HopKind::line,
                         .state = HopState::trouble,
                         .text = state_.was_up ? "web.why.lost" : "web.why.never_connected",
                         .arguments = {{"line", line_.name}},
                         .error = state_.why});
    }

    [[nodiscard]] report::DeviceTrouble trouble() const {
        return report::device_trouble(texts_, snapshot_, index_.line, index_.device);
    }

    void device() {
        if (!state_.up || index_.device >= state_.devices.size()) return;
        const auto& its = state_.devices[index_.device];
        const auto time = its.recent_time;
        WhyHop hop{.kind = HopKind::device,
                   .text = "web.why.answers",
                   .arguments = {{"device", device_.name}, {"time", texts_.duration(time)}},
                   .time = time};
        if (its.state == poll::DeviceState::not_answering) {
            hop = {.kind = HopKind::device,
                   .state = HopState::trouble,
                   .text = "web.why.silent",
                   .arguments = {{"problem", trouble().text}}};
        } else if (its.state == poll::DeviceState::unknown) {
            hop = {.kind = HopKind::device,
                   .state = HopState::wait,
                   .text = "web.why.not_asked",
                   .arguments = {{"device", device_.name}}};
        } else if (value::is_exception(slot_.reason)) {
            hop.state = HopState::trouble;
            hop.text = "web.why.refuses";
            hop.reason = slot_.reason;
        } else if (slot_.reason != value::Reason::ok && its.state == poll::DeviceState::answering) {
            hop.state = HopState::trouble;
            hop.text = "web.why.fails";
            hop.reason = slot_.reason;
        } else if (its.state == poll::DeviceState::switched_off) {
            return;
        }
        hops_.push_back(std::move(hop));
    }

    void back_off() {
        if (!state_.up || index_.device >= state_.devices.size() ||
            state_.devices[index_.device].state != poll::DeviceState::not_answering)
            return;
        hops_.push_back({HopKind::back_off,
                         HopState::wait,
                         "web.why.back_off",
                         {{"tried", trouble().tried}},
                         state_.devices[index_.device].back_off});
    }

    const report::Texts& texts_;
    const host::Snapshot& snapshot_;
    const value::Slot& slot_;
    value::VariableIndex index_;
    const model::Project& project_;
    const model::Line& line_;
    const model::Device& device_;
    const model::Variable& variable_;
    const host::Snapshot::Line& state_;
    std::vector<WhyHop> hops_;
};

file::Json hop_json(const report::Texts& texts, WhyHop hop) {
    if (hop.error) hop.arguments.emplace_back("error", texts.describe(*hop.error));
    if (hop.text == "web.why.lost" || hop.text == "web.why.never_connected")
        if (!hop.error) hop.arguments.emplace_back("error", "–");
    if (hop.reason) hop.arguments.emplace_back("reason", texts.quality(value::Quality::bad, *hop.reason));
    auto object = file::Json::object();
    object.set("hop", hop_kind_word(hop.kind));
    object.set("state", hop_state_word(hop.state));
    object.set("text", texts(hop.text, hop.arguments));
    if (hop.time && *hop.time > Duration{}) object.set("ms", report::milliseconds(*hop.time));
    return object;
}

}  // namespace

std::vector<WhyHop> why(const report::Texts& texts, const host::Snapshot& snapshot, value::SlotId slot) {
    const auto owner = snapshot.configuration->slots().owner(slot);
    if (const auto* const index = std::get_if<value::VariableIndex>(&owner))
        return Way(texts, snapshot, slot, *index).hops();
    return {{HopKind::period, HopState::ok, "web.why.local"}};
}

file::Json why_json(const report::Texts& texts, const host::Snapshot& snapshot, value::SlotId slot) {
    const auto& its = snapshot.values.at(slot.value);
    std::optional<Duration> age;
    if (its.sampled_at) age = std::max(Duration{}, snapshot.t - *its.sampled_at);
    std::optional<Duration> proved;
    const auto owner = snapshot.configuration->slots().owner(slot);
    if (const auto* const index = std::get_if<value::VariableIndex>(&owner))
        proved = proved_age(*snapshot.configuration, *index);
    auto hops = file::Json::array();
    for (auto& hop : why(texts, snapshot, slot)) hops.push_back(hop_json(texts, std::move(hop)));
    auto object = file::Json::object();
    object.set("variable", snapshot.configuration->info(slot).name);
    object.set("quality", value::name(its.quality));
    object.set("age_ms", milliseconds_or_null(age));
    object.set("proved_age_ms", milliseconds_or_null(proved));
    object.set("hops", std::move(hops));
    return object;
}

}  // namespace takt::web
