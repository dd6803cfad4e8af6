// The steps that measures.cpp tries. A step changes the editor's line in place and notes each changed key
// with its old and new value; a device or variable that already has the value, or a milder one, is left
// alone. The lists of values go from mild to strong.
#include "proof/remedy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ranges>
#include <set>
#include <span>
#include <utility>

#include "takt/model/scalar.hpp"
#include "takt/plan/shares.hpp"

namespace takt::plan {
namespace {

using namespace std::chrono_literals;
using model::Strategy;

constexpr std::array kTimes = {1000ms, 500ms, 200ms, 100ms, 50ms, 30ms, 20ms, 15ms, 10ms, 5ms};
constexpr std::array kBitRates = {1200U,  2400U,   4800U,   9600U,   19200U, 38400U,
                                  57600U, 115200U, 230400U, 460800U, 921600U};
constexpr std::uint32_t kFastestOwen = 115200;
constexpr std::array kFactors = {1.25, 1.5,  2.0,  2.5,   3.0,   4.0,   5.0,   7.5,
                                 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0};
constexpr std::size_t kFactorsOfFew = 7;  // a few requests are not slowed down more than to a fifth
constexpr std::array kBackoffs = {2s, 5s, 10s, 30s, 60s};
constexpr std::array kRelayIntervals = {2s, 5s, 10s, 30s, 60s};
constexpr std::size_t kMostParts = 16;  // of a long read
constexpr std::size_t kMostSlowed = 8;  // requests that are slowed down while others are not

std::string device_path(std::size_t line, std::size_t device) {
    return fmt::format("lines[{}].devices[{}]", line, device);
}

void derive(Editor& editor) {
    if (editor.project().derive_timeouts) return;
    editor.project().derive_timeouts = true;
    editor.note_project("derive_timeouts", "false", "true");
}

// The least turnaround or time-out to propose: a fifth above the longest response time measured, late
// responses included, rounded up to a value of kTimes.
Duration least_wait(const model::Device& device) {
    const Duration worst = device.times.measured.worst();
    const Duration least = worst + worst / 5;
    const auto from_below = std::views::reverse(kTimes);
    const auto proposed = std::ranges::lower_bound(from_below, least);
    return proposed == from_below.end() ? least : Duration(*proposed);
}

// The proof takes the time-out for a turnaround that is not known. A shorter time-out would prove as much,
// and give up devices that answer later.
std::vector<Step> turnarounds() {
    std::vector<Step> steps;
    for (const Duration limit : kTimes)
        steps.emplace_back([=](Editor& editor) {
            auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d) {
                auto& device = devices[d];
                const Duration shorter = std::max<Duration>(limit, least_wait(device));
                if (device.expected_turnaround() || device.response_timeout <= shorter) continue;
                editor.note_device(d, "turnaround", device.learn_turnaround ? "learn" : "",
                                   model::to_text(shorter));
                device.turnaround = shorter;
            }
        });
    return steps;
}

// A written time-out counts even where the turnaround is known to be shorter.
std::vector<Step> time_outs() {
    std::vector<Step> steps{derive};
    for (const Duration time_out : kTimes)
        steps.emplace_back([=](Editor& editor) {
            auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d) {
                auto& device = devices[d];
                if (!device.turnaround || !device.response_timeout_set) continue;
                const Duration shorter =
                    std::max({Duration(time_out), *device.turnaround, least_wait(device)});
                if (device.response_timeout <= shorter) continue;
                editor.note_device(d, "response_timeout", model::to_text(device.response_timeout),
                                   model::to_text(shorter));
                device.response_timeout = shorter;
            }
        });
    return steps;
}

bool reads_registers(const Request& request) {
    return request.read && !wire::counts_bits(*request.read);
}

// Divides the longest read into 2, 3, … equal parts. Equal sizes are tried once, the largest size first.
std::vector<Step> splitting(const model::Line& line, const LinePlan& plan) {
    std::uint16_t longest = 0;
    std::vector<std::uint16_t> longest_of(line.devices.size(), 0);
    for (const Request& request : plan.requests)
        if (reads_registers(request)) {
            longest = std::max(longest, request.quantity);
            longest_of[request.device] = std::max(longest_of[request.device], request.quantity);
        }
    std::set<std::size_t, std::greater<>> sizes;
    for (std::size_t parts = 2; parts <= kMostParts; ++parts) {
        const std::size_t size = (longest + parts - 1) / parts;
        if (size >= 2 && size < longest) sizes.insert(size);
    }
    std::vector<Step> steps;
    for (const std::size_t size : sizes)
        steps.emplace_back([=](Editor& editor) {
            auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d) {
                if (longest_of[d] <= size) continue;
                editor.note_device(d, "registers_per_request",
                                   std::to_string(devices[d].registers_per_request), std::to_string(size));
                devices[d].registers_per_request = static_cast<std::uint16_t>(size);
                devices[d].registers_per_request_set = true;
            }
        });
    return steps;
}

void group_with(Editor& editor, Strategy strategy) {
    auto& devices = editor.line().devices;
    for (std::size_t d = 0; d < devices.size(); ++d) {
        if (devices[d].strategy >= strategy) continue;
        if (!devices[d].group_requests) editor.note_device(d, "group_requests", "false", "true");
        if (devices[d].strategy != Strategy::single || strategy != Strategy::classic)
            editor.note_device(d, "strategy", std::string(name(devices[d].strategy)),
                               std::string(name(strategy)));
        devices[d].group_requests = true;
        devices[d].strategy = strategy;
    }
}

std::vector<Step> grouping(model::Profile profile) {
    std::vector<Step> steps;
    steps.emplace_back([](Editor& editor) { group_with(editor, Strategy::classic); });
    if (profile == model::Profile::generic)
        steps.emplace_back([](Editor& editor) { group_with(editor, Strategy::optimal); });
    return steps;
}

std::vector<Step> bit_rate(const model::Line& line, model::Profile profile) {
    std::vector<Step> steps;
    if (!line.is_serial()) return steps;
    for (const std::uint32_t baud : kBitRates) {
        if (baud <= line.format.baud) continue;
        if (profile == model::Profile::owen_kc1 && baud > kFastestOwen) continue;
        steps.emplace_back([=](Editor& editor) {
            auto& format = editor.line().format;
            editor.note_line("baud", std::to_string(format.baud), std::to_string(baud));
            format.baud = baud;
        });
    }
    return steps;
}

// Rounds to a whole number of milliseconds with few digits.
Duration longer(Duration period, double factor) {
    const double ms = std::chrono::duration<double, std::milli>(period).count() * factor;
    const double step = ms >= 1000 ? 100 : ms >= 100 ? 10 : ms >= 20 ? 5 : 1;
    const auto whole = static_cast<std::int64_t>(ms / step + 0.999999) * static_cast<std::int64_t>(step);
    return std::min<Duration>(std::chrono::milliseconds(whole), 24h);
}

bool may_be_slower(const model::Variable& variable) {
    return variable.used && variable.read && !variable.deadline && variable.period > Duration::zero();
}

void slow_down(Editor& editor, std::size_t device, std::size_t variable, double factor) {
    auto& changed = editor.line().devices[device].variables[variable];
    if (!may_be_slower(changed)) return;
    const Duration to = longer(changed.period, factor);
    if (to <= changed.period) return;
    editor.note_period(device, variable, changed.period, to);
    changed.period = to;
}

Ladder slowed(const std::vector<Members>& requests) {
    Ladder ladder;
    for (std::size_t i = 0; i < kFactorsOfFew; ++i)
        ladder.steps.emplace_back([requests, factor = kFactors[i]](Editor& editor) {
            for (const auto& [device, variables] : requests)
                for (const std::size_t v : variables) slow_down(editor, device, v, factor);
        });
    return ladder;
}

Ladder all_slowed() {
    Ladder ladder;
    for (const double factor : kFactors)
        ladder.steps.emplace_back([factor](Editor& editor) {
            const auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d)
                for (std::size_t v = 0; v < devices[d].variables.size(); ++v) slow_down(editor, d, v, factor);
        });
    return ladder;
}

// Where the line is not overloaded, the late requests themselves come first. Else those with the largest
// shares: one, two, four and eight of them, then all requests.
std::vector<Ladder> periods(const Situation& situation) {
    std::vector<Ladder> all;
    if (!situation.overloaded && !situation.late.empty()) all.push_back(slowed(situation.late));
    const auto largest = largest_shares(situation.plan, kMostSlowed + 1);
    for (std::size_t count = 1; count < largest.size() && count <= kMostSlowed; count *= 2) {
        std::vector<Members> requests;
        double share = 0;
        for (const StreamShare& stream : std::span(largest).first(count)) {
            requests.push_back({stream.device, stream.variables});
            share += stream.share;
        }
        all.push_back(slowed(requests));
        all.back().largest_share = share;
        all.back().relief = share * (1 - 1 / kFactors[kFactorsOfFew - 1]);
    }
    all.push_back(all_slowed());
    if (largest.size() == 1) all.back().largest_share = largest.front().share;
    return all;
}

std::vector<Step> relay_interval(const model::Line& line) {
    std::vector<Step> steps;
    if (!line.relayed) return steps;
    for (const Duration interval : kRelayIntervals)
        if (interval > line.relay_interval)
            steps.emplace_back([interval](Editor& editor) {
                editor.note_line("relay_interval", model::to_text(editor.line().relay_interval),
                                 model::to_text(interval));
                editor.line().relay_interval = interval;
            });
    return steps;
}

std::vector<Step> attempts() {
    std::vector<Step> steps;
    for (const std::uint16_t count : {std::uint16_t{2}, std::uint16_t{1}})
        steps.emplace_back([=](Editor& editor) {
            auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d) {
                if (devices[d].attempts <= count) continue;
                editor.note_device(d, "attempts", std::to_string(devices[d].attempts), std::to_string(count));
                devices[d].attempts = count;
            }
        });
    for (const Duration first : kBackoffs)
        steps.emplace_back([=](Editor& editor) {
            auto& project = editor.project();
            if (project.backoff.first >= first) return;
            editor.note_project("backoff", model::to_text(project.backoff.first), model::to_text(first));
            project.backoff.first = first;
            project.backoff.limit = std::max(project.backoff.limit, first);
        });
    return steps;
}

}  // namespace

bool needs_plan(MeasureKind kind) {
    return kind == MeasureKind::splitting || kind == MeasureKind::periods;
}

std::vector<Ladder> ladders(MeasureKind kind, const model::Line& line, model::Profile profile,
                            const Situation& situation) {
    const auto ordered = [](std::vector<Step> steps) { return std::vector{Ladder{std::move(steps)}}; };
    const auto unordered = [](std::vector<Step> steps) {
        return std::vector{Ladder{.steps = std::move(steps), .ordered = false}};
    };
    switch (kind) {
        case MeasureKind::grouping: return unordered(grouping(profile));
        case MeasureKind::turnarounds: return ordered(turnarounds());
        case MeasureKind::time_outs: return unordered(time_outs());
        case MeasureKind::splitting: return unordered(splitting(line, situation.plan));
        case MeasureKind::relay_interval: return ordered(relay_interval(line));
        case MeasureKind::bit_rate: return ordered(bit_rate(line, profile));
        case MeasureKind::periods: return periods(situation);
        case MeasureKind::attempts: break;
    }
    return unordered(attempts());
}

void Editor::restart(bool recording) {
    recording_ = recording;
    count_ = 0;
    changes_.clear();
}

void Editor::note(std::string path, std::string name, const char* key, std::string from, std::string to) {
    ++count_;
    if (recording_)
        changes_.push_back({std::move(path), std::move(name), key, std::move(from), std::move(to)});
}

void Editor::note_project(const char* key, std::string from, std::string to) {
    note("", "", key, std::move(from), std::move(to));
}

void Editor::note_line(const char* key, std::string from, std::string to) {
    note(fmt::format("lines[{}]", number_), line().name, key, std::move(from), std::move(to));
}

void Editor::note_device(std::size_t device, const char* key, std::string from, std::string to) {
    note(device_path(number_, device), line().devices[device].name, key, std::move(from), std::move(to));
}

// Of many variables: the words are made only if they are kept.
void Editor::note_period(std::size_t device, std::size_t variable, Duration from, Duration to) {
    if (!recording_) {
        ++count_;
        return;
    }
    note(fmt::format("{}.variables[{}]", device_path(number_, device), variable),
         line().devices[device].variables[variable].name, "period", model::to_text(from), model::to_text(to));
}

}  // namespace takt::plan
