#include "takt/report/states/live_screen.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>
#include <utility>

#include "states/problems.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/state_report.hpp"
#include "takt/text/escape.hpp"

namespace takt::report {
namespace {

using poll::DeviceState;
using value::Quality;

constexpr std::size_t kLeastLiveRows = 6;  // of a screen
constexpr std::size_t kCursorRows = 1;     // of the screen: the cursor is below the display
constexpr std::size_t kKeyRows = 1;        // the last line
constexpr std::size_t kHeadingRows = 1;
constexpr std::size_t kMostLiveProblems = 4;

// ---- lines and devices

bool has_trouble(const host::Snapshot::Line& line) {
    const auto silent = [](const poll::DeviceStatistics& device) {
        return device.state == DeviceState::not_answering || device.state == DeviceState::link_down;
    };
    return !line.up || std::ranges::any_of(line.devices, silent) ||
           std::ranges::any_of(line.requests, &poll::RequestStatistics::overrun);
}

std::string cycle_text(const Texts& texts, Duration cycle) {
    return cycle > Duration::zero() ? texts.duration(cycle) : "–";
}

std::string live_line_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t index) {
    const auto& line = snapshot.lines[index];
    auto text = texts("app.ctl.line", {{"line", snapshot.configuration->project().lines[index].name},
                                       {"state", texts(fmt::format("app.link.{}", link_word(line)))},
                                       {"load", percent_text(line.statistics.recent_utilization)},
                                       {"measured", cycle_text(texts, line.statistics.measured_cycle)},
                                       {"planned", cycle_text(texts, line.statistics.planned_cycle)}});
    const auto overrun = std::ranges::count_if(line.requests, &poll::RequestStatistics::overrun);
    if (overrun > 0)
        text += texts("app.ctl.overrun", {{"count", std::to_string(overrun)},
                                          {"requests", std::to_string(line.requests.size())}});
    return text;
}

/// "not answering (time-out): Pump, Fan; answering: Boiler", trouble first.
std::string devices_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t index) {
    const auto& devices = snapshot.configuration->project().lines[index].devices;
    std::string text;
    for (const auto state : {DeviceState::not_answering, DeviceState::link_down, DeviceState::unknown,
                             DeviceState::switched_off, DeviceState::answering}) {
        std::map<std::string, std::string> names;  // by what is shown of the state
        for (std::size_t d = 0; d < devices.size(); ++d) {
            const auto& device = snapshot.lines[index].devices[d];
            if (device.state != state) continue;
            auto& same = names[device_state_text(texts, device)];
            same += (same.empty() ? "" : ", ") + devices[d].name;
        }
        for (const auto& [shown, same] : names) text += (text.empty() ? "  " : "; ") + shown + ": " + same;
    }
    return text;
}

/// "late responses: Meter 3 (up to 412 ms); turnaround at most: Boiler 7.60 ms, Meter 9.10 ms". Empty if
/// nothing was measured.
std::string live_times_text(const Texts& texts, const host::Snapshot& snapshot, std::size_t index) {
    const auto& devices = snapshot.configuration->project().lines[index].devices;
    std::string late;
    std::string turnaround;
    for (std::size_t d = 0; d < devices.size(); ++d) {
        const auto& measured = snapshot.lines[index].times[d];
        if (measured.late > 0)
            late += (late.empty() ? "" : ", ") +
                    texts("app.live.late.device", {{"device", devices[d].name},
                                                   {"late", std::to_string(measured.late)},
                                                   {"lateness", texts.duration(measured.lateness)}});
        if (measured.exchanges > 0)
            turnaround +=
                (turnaround.empty() ? "" : ", ") + devices[d].name + ' ' + texts.duration(measured.longest);
    }
    if (!late.empty()) late = texts("app.live.late", {{"devices", late}});
    if (!turnaround.empty()) turnaround = texts("app.live.turnaround", {{"devices", turnaround}});
    return late.empty() && turnaround.empty()   ? std::string()
           : late.empty() || turnaround.empty() ? "  " + late + turnaround
                                                : "  " + late + "; " + turnaround;
}

/// Lines with trouble first. At most `most` lines of text; those that have no room are counted. Response
/// times are left out if they do not fit for every line.
std::vector<std::string> header(const Texts& texts, const host::Snapshot& snapshot, std::size_t most) {
    std::vector<std::size_t> order(snapshot.lines.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::stable_partition(order, [&](std::size_t i) { return has_trouble(snapshot.lines[i]); });
    std::vector<std::string> lines;
    const bool has_times = 3 * order.size() <= most;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool last = i + 1 == order.size();
        if (lines.size() + (last ? 2 : 3) > most) {
            const auto left = std::span(order).subspan(i);
            const auto trouble =
                std::ranges::count_if(left, [&](std::size_t l) { return has_trouble(snapshot.lines[l]); });
            lines.push_back(texts("app.live.more_lines", {{"count", std::to_string(left.size())},
                                                          {"trouble", std::to_string(trouble)}}));
            break;
        }
        lines.push_back(live_line_text(texts, snapshot, order[i]));
        if (auto devices = devices_text(texts, snapshot, order[i]); !devices.empty())
            lines.push_back(std::move(devices));
        if (auto times = has_times ? live_times_text(texts, snapshot, order[i]) : std::string();
            !times.empty())
            lines.push_back(std::move(times));
    }
    return lines;
}

/// The worst problems, the others counted; below each what is tried and the next step, while they fit.
/// @param most  lines
std::vector<std::string> problem_lines(const Texts& texts, const host::Snapshot& snapshot,
                                       std::size_t columns, std::size_t most) {
    auto problems = find_problems(texts, snapshot);
    std::erase_if(problems,
                  [](const Problem& problem) { return problem.severity == Problem::Severity::note; });
    const auto shown = std::min({problems.size(), most, kMostLiveProblems});
    const auto more = shown < problems.size() ? std::size_t{1} : std::size_t{0};
    std::size_t room = most - std::min(most, shown);
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < shown - std::min(shown, more); ++i) {
        lines.push_back(fitted("  " + problem_line(texts, problem_json(problems[i])), columns));
        for (const auto* const text : {&problems[i].tried, &problems[i].advice})
            if (!text->empty() && room > 0) {
                lines.push_back(fitted("    " + text::escape_line(*text), columns));
                --room;
            }
    }
    if (shown > 0 && more > 0)
        lines.push_back("  " +
                        texts("problem.more", {{"count", std::to_string(problems.size() - (shown - more))}}));
    return lines;
}

// ---- values

/// The position of a value in the display: what needs attention is at the top.
int rank(const value::Slot& slot) {
    switch (slot.quality) {
        case Quality::bad: return 0;
        case Quality::uncertain: return 1;
        case Quality::never_read: return 2;
        case Quality::good: break;
    }
    return 3;
}

std::vector<value::SlotId> selected_values(const host::Snapshot& snapshot, const LiveSelection& selection) {
    std::vector<value::SlotId> selected;
    for (std::uint32_t id = 0; id < snapshot.values.size(); ++id) {
        const auto& configuration = *snapshot.configuration;
        if (selection.not_good && snapshot.values[id].quality == Quality::good) continue;
        if (!selection.device.empty() && device_name(configuration, {id}) != selection.device) continue;
        if (is_selected(selection, configuration.info({id}).name)) selected.push_back({id});
    }
    std::ranges::stable_sort(selected, {}, [&](value::SlotId id) { return rank(snapshot.values[id.value]); });
    return selected;
}

std::vector<std::string> value_row(const Texts& texts, const host::Snapshot& snapshot, value::SlotId id) {
    const auto& configuration = *snapshot.configuration;
    const auto& slot = snapshot.values[id.value];
    const auto& info = configuration.info(id);
    const bool aged = !info.local && slot.sampled_at;
    return {device_name(configuration, id), info.name,
            value::is_empty(slot.value) ? "–" : value_text(configuration, id, slot.value),
            aged ? texts.duration(std::max(Duration{}, snapshot.t - *slot.sampled_at)) : "",
            slot.quality == Quality::good ? "" : texts.quality(slot.quality, slot.reason)};
}

}  // namespace

bool is_selected(const LiveSelection& selection, const std::string& name) {
    return name_matches(selection.filter, name);
}

std::size_t turn_page(LiveSelection& selection, std::size_t rows, std::size_t height) {
    selection.page = std::max<std::size_t>(height, 1);
    selection.first = std::min(selection.first, rows > height ? rows - height : 0);
    return std::min(height, rows - selection.first);
}

std::string keys_line(const Texts& texts, const LiveSelection& selection, std::size_t rows,
                      std::size_t shown) {
    if (selection.typing) return texts("app.live.typing", {{"filter", selection.filter}});
    if (!selection.takes_keys)
        return shown < rows ? texts("app.more_rows", {{"count", std::to_string(rows - shown)}})
                            : std::string();
    auto text = texts("app.live.rows", {{"first", std::to_string(rows == 0 ? 0 : selection.first + 1)},
                                        {"last", std::to_string(selection.first + shown)},
                                        {"all", std::to_string(rows)}});
    std::string chosen;
    for (const auto& part : {selection.device, selection.filter.empty() ? "" : '/' + selection.filter,
                             selection.not_good ? texts("app.live.not_good") : ""})
        if (!part.empty()) chosen += ", " + part;
    return text + chosen + "  " + texts(selection.has_devices ? "app.live.keys" : "app.live.keys.no_device");
}

std::vector<std::string> live_screen(const Texts& texts, const host::Snapshot& snapshot,
                                     LiveSelection& selection, const Screen& screen) {
    using enum TextTable::Align;
    const std::size_t height = std::max(screen.rows, kLeastLiveRows) - kCursorRows - kKeyRows - kHeadingRows;
    auto lines = header(texts, snapshot, std::max<std::size_t>(height / 2, 1));
    const auto most = height / 2 - std::min(height / 2, lines.size());
    for (auto& problem : problem_lines(texts, snapshot, screen.columns - 1, most))
        lines.push_back(std::move(problem));
    for (const auto& output : selection.outputs)
        if (lines.size() < height / 2) lines.push_back(fitted(output, screen.columns - 1));
    const auto values = selected_values(snapshot, selection);
    const auto shown = turn_page(selection, values.size(), height - std::min(height - 1, lines.size()));
    TextTable table({left, left, right, right, whole});
    table.add({texts("app.device"), texts("app.variable"), texts("app.value"), texts("app.age"), ""});
    for (std::size_t i = 0; i < shown; ++i)
        table.add(value_row(texts, snapshot, values[selection.first + i]));
    for (auto& line : table.lines(screen.columns - 1)) lines.push_back(std::move(line));
    if (auto keys = keys_line(texts, selection, values.size(), shown); !keys.empty())
        lines.push_back(std::move(keys));
    return lines;
}

}  // namespace takt::report
