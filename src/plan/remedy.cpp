// The steps that measures.cpp tries. A step changes the editor's line in place and notes each changed key
// with its old and new value; a device or variable that already has the value, or a milder one, is left
// alone. The lists of values go from mild to strong, so the first step that is sufficient is the mildest one.
#include "remedy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace takt::plan {
namespace {

using namespace std::chrono_literals;
using model::Strategy;

constexpr std::array kTimes = {1000ms, 500ms, 200ms, 100ms, 50ms, 30ms, 20ms, 15ms, 10ms, 5ms};
constexpr std::array kBitRates = {1200U,  2400U,   4800U,   9600U,   19200U, 38400U,
                                  57600U, 115200U, 230400U, 460800U, 921600U};
constexpr std::uint32_t kFastestOwen = 115200;
constexpr std::array kFactors = {1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 7.5, 10.0, 20.0};
constexpr std::array kBackoffs = {2s, 5s, 10s, 30s, 60s};
constexpr std::size_t kMostParts = 16;  // of a long read
constexpr std::size_t kMostSlowed = 8;  // periods that are tried alone

std::string duration_text(Duration time) {
    const auto whole = [&](auto unit) { return time % unit == Duration::zero(); };
    if (whole(1s)) return fmt::format("{}s", time / 1s);
    if (whole(1ms)) return fmt::format("{}ms", time / 1ms);
    return fmt::format("{}us", time / 1us);
}

std::string device_path(std::size_t line, std::size_t device) {
    return fmt::format("lines[{}].devices[{}]", line, device);
}

void derive(Editor& editor) {
    if (editor.project().derive_timeouts) return;
    editor.project().derive_timeouts = true;
    editor.note_project("derive_timeouts", "false", "true");
}

// The proof takes the time-out for a turnaround that is not known. A shorter time-out would prove as much,
// and give up devices that answer later.
std::vector<Step> turnarounds() {
    std::vector<Step> steps;
    for (const Duration limit : kTimes)
        steps.emplace_back([=](Editor& editor) {
            auto& devices = editor.line().devices;
            for (std::size_t d = 0; d < devices.size(); ++d) {
                if (devices[d].turnaround || devices[d].response_timeout <= limit) continue;
                editor.note_device(d, "turnaround", "", duration_text(limit));
                devices[d].turnaround = limit;
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
                const Duration shorter = std::max<Duration>(time_out, *device.turnaround);
                if (device.response_timeout <= shorter) continue;
                editor.note_device(d, "response_timeout", duration_text(device.response_timeout),
                                   duration_text(shorter));
                device.response_timeout = shorter;
            }
        });
    return steps;
}

bool reads_registers(const Request& request) {
    return request.read && *request.read != wire::Function::read_coils &&
           *request.read != wire::Function::read_discrete_inputs;
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
    editor.note_variable(device, variable, duration_text(changed.period), duration_text(to));
    changed.period = to;
}

/// The variables of one request.
struct Members {
    std::size_t device = 0;
    std::vector<std::size_t> variables;
};

/// The members of the requests with the greatest load.
std::vector<Members> heaviest(const LinePlan& plan) {
    std::vector<const Request*> requests;
    for (const Request& request : plan.requests)
        if (request.read && request.period > Duration::zero()) requests.push_back(&request);
    const auto load = [](const Request* request) {
        return static_cast<double>(request->bus_time.count()) / static_cast<double>(request->period->count());
    };
    std::stable_sort(requests.begin(), requests.end(),
                     [&](const Request* a, const Request* b) { return load(a) > load(b); });
    if (requests.size() > kMostSlowed) requests.resize(kMostSlowed);
    std::vector<Members> members;
    for (const Request* const request : requests) members.push_back({request->device, request->variables});
    return members;
}

// For each factor first the heaviest requests alone, then all variables: fewer changes are milder.
std::vector<Step> periods(const LinePlan& plan) {
    std::vector<Step> steps;
    const auto requests = heaviest(plan);
    const auto slow_all = [](Editor& editor, double factor) {
        const auto& devices = editor.line().devices;
        for (std::size_t d = 0; d < devices.size(); ++d)
            for (std::size_t v = 0; v < devices[d].variables.size(); ++v) slow_down(editor, d, v, factor);
    };
    for (const double factor : kFactors) {
        for (const Members& members : requests)
            steps.emplace_back([=](Editor& editor) {
                for (const std::size_t v : members.variables) slow_down(editor, members.device, v, factor);
            });
        if (requests.size() > 1) steps.emplace_back([=](Editor& editor) { slow_all(editor, factor); });
    }
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
            editor.note_project("backoff", duration_text(project.backoff.first), duration_text(first));
            project.backoff.first = first;
            project.backoff.limit = std::max(project.backoff.limit, first);
        });
    return steps;
}

}  // namespace

bool needs_plan(MeasureKind kind) {
    return kind == MeasureKind::splitting || kind == MeasureKind::periods;
}

std::vector<Step> steps(MeasureKind kind, const model::Line& line, model::Profile profile,
                        const LinePlan& plan) {
    switch (kind) {
        case MeasureKind::grouping: return grouping(profile);
        case MeasureKind::turnarounds: return turnarounds();
        case MeasureKind::time_outs: return time_outs();
        case MeasureKind::splitting: return splitting(line, plan);
        case MeasureKind::bit_rate: return bit_rate(line, profile);
        case MeasureKind::periods: return periods(plan);
        case MeasureKind::attempts: break;
    }
    return attempts();
}

void Editor::note_project(const char* key, std::string from, std::string to) {
    changes_.push_back({"", "", key, std::move(from), std::move(to)});
}

void Editor::note_line(const char* key, std::string from, std::string to) {
    changes_.push_back({fmt::format("lines[{}]", number_), line().name, key, std::move(from), std::move(to)});
}

void Editor::note_device(std::size_t device, const char* key, std::string from, std::string to) {
    changes_.push_back(
        {device_path(number_, device), line().devices[device].name, key, std::move(from), std::move(to)});
}

void Editor::note_variable(std::size_t device, std::size_t variable, std::string from, std::string to) {
    changes_.push_back({fmt::format("{}.variables[{}]", device_path(number_, device), variable),
                        line().devices[device].variables[variable].name, "period", std::move(from),
                        std::move(to)});
}

}  // namespace takt::plan
