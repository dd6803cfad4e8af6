#include "takt/file/learnt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "json/learnt_reader.hpp"
#include "takt/base/iso_time.hpp"
#include "takt/file/json.hpp"

namespace takt::file {
namespace {

using model::ItemRange;
using model::Learnt;

constexpr std::size_t kMostFindings = 20;

std::string range_text(const ItemRange& range) {
    return fmt::format("{}..{}", range.first, range.last);
}

/// The moment that was this age ago.
std::string time_text(Seconds now, Duration age) {
    const auto moment = now - std::chrono::floor<std::chrono::seconds>(age);
    return utc_time_text(nanoseconds_of(moment), Fraction::none);
}

std::optional<Json> area_json(const Learnt& learnt, wire::Area area, Seconds now) {
    const auto a = static_cast<std::size_t>(area);
    if (learnt.confirmed[a].empty() && learnt.refused[a].empty() && learnt.most_items[a] == 0)
        return std::nullopt;
    auto confirmed = Json::array();
    for (const auto& range : learnt.confirmed[a]) confirmed.push_back(range_text(range));
    auto refused = Json::array();
    for (const auto& range : learnt.refused[a]) {
        auto entry = Json::object();
        entry.set("items", range_text(range.items));
        entry.set("exception", range.exception);
        entry.set("since", time_text(now, range.since));
        entry.set("checked", time_text(now, range.checked));
        refused.push_back(std::move(entry));
    }
    auto object = Json::object();
    object.set("area", wire::name(area));
    object.set("confirmed", std::move(confirmed));
    object.set("refused", std::move(refused));
    if (learnt.most_items[a] > 0) object.set("most_items", learnt.most_items[a]);
    return object;
}

std::int64_t microseconds(Duration time) {
    const Duration kept = std::min<Duration>(time, kLongestLearntTime);
    return std::chrono::floor<std::chrono::microseconds>(kept).count();
}

std::optional<Json> times_json(const model::LearntTimes& times) {
    const auto& measured = times.measured;
    if (measured.exchanges == 0 && measured.late == 0) return std::nullopt;
    auto counts = Json::array();
    for (const auto& [upper, count] : times.counts) {
        auto entry = Json::array();
        entry.push_back(microseconds(upper));
        entry.push_back(count);
        counts.push_back(std::move(entry));
    }
    auto object = Json::object();
    object.set("exchanges", measured.exchanges);
    object.set("longest_us", microseconds(measured.longest));
    object.set("p999_us", microseconds(measured.p999));
    object.set("counts", std::move(counts));
    object.set("attempts", measured.attempts);
    object.set("late", measured.late);
    object.set("lateness_us", microseconds(measured.lateness));
    auto next = Json::array();
    for (const auto time : measured.next_latest) next.push_back(microseconds(time));
    object.set("next_latest_us", std::move(next));
    return object;
}

std::optional<Json> device_json(const model::Device& device, const Learnt& learnt,
                                const model::LearntTimes& known_times, Seconds now) {
    auto areas = Json::array();
    auto times = times_json(known_times);
    bool any = times.has_value();
    for (const auto area : kLearntAreas) {
        if (device.gaps != model::Gaps::learn) break;
        if (auto known = area_json(learnt, area, now)) {
            areas.push_back(*std::move(known));
            any = true;
        }
    }
    if (!any) return std::nullopt;
    auto object = Json::object();
    object.set("device", device.name);
    object.set("address", device.address.value);
    object.set("areas", std::move(areas));
    if (times) object.set("times", *std::move(times));
    return object;
}

model::Device* device_of(model::Project& project, const LearntReader::Known& known) {
    for (auto& line : project.lines)
        if (line.name == known.line)
            for (auto& device : line.devices)
                if (device.name == known.device && device.address.value == known.address) return &device;
    return nullptr;
}

model::Finding finding(const char* code, std::uint32_t file, std::string value) {
    return {.severity = model::Severity::warning,
            .code = code,
            .location = {.file = file},
            .path = {},
            .value = std::move(value),
            .allowed = {},
            .arguments = {}};
}

/// At the line of that name, if it does not accept lengths that are off by one.
std::optional<model::Finding> lengths_off_finding(const model::Project& project, const std::string& name) {
    const auto line = std::ranges::find(project.lines, name, &model::Line::name);
    if (line == project.lines.end() || line->framing != wire::Framing::tcp || line->length_tolerance)
        return std::nullopt;
    auto made = finding("learnt.lengths_off", 0, name);
    made.location = line->location;
    made.path = fmt::format("lines[{}]", line - project.lines.begin());
    made.arguments = {{"line", name}};
    return made;
}

}  // namespace

std::string learnt_text(const model::Project& project, const LearntOfLines& learnt, const TimesOfLines& times,
                        Seconds now, const LengthsOfLines& lengths_off) {
    const model::LearntTimes nothing;
    auto lines = Json::array();
    for (std::size_t l = 0; l < project.lines.size() && l < learnt.size(); ++l) {
        auto devices = Json::array();
        bool any = false;
        for (std::size_t d = 0; d < project.lines[l].devices.size() && d < learnt[l].size(); ++d) {
            const auto& device = project.lines[l].devices[d];
            const bool timed = l < times.size() && d < times[l].size();
            if (auto known = device_json(device, learnt[l][d], timed ? times[l][d] : nothing, now)) {
                devices.push_back(*std::move(known));
                any = true;
            }
        }
        const bool off = l < lengths_off.size() && lengths_off[l];
        if (!any && !off) continue;
        auto line = Json::object();
        line.set("line", project.lines[l].name);
        line.set("devices", std::move(devices));
        if (off) line.set("lengths_off", true);
        lines.push_back(std::move(line));
    }
    auto root = Json::object();
    root.set("takt_learnt", kLearntVersion);
    root.set("lines", std::move(lines));
    return root.dump(1) + '\n';
}

Recalled recall(std::string_view text, Seconds now, std::uint32_t file, model::Project& project) {
    Recalled recalled;
    const auto json = Json::parse(text, kMaxLearntBytes);
    LearntReader reader(now);
    if (!json || !reader.read(*json)) {
        recalled.findings.push_back(finding("learnt.damaged", file, json ? reader.fault() : "JSON"));
        return recalled;
    }
    recalled.whole = true;
    for (auto& known : reader.take()) {
        if (auto* device = device_of(project, known)) {
            if (device->gaps == model::Gaps::learn) device->learnt = std::move(known.learnt);
            device->times = std::move(known.times);
        } else if (recalled.findings.size() < kMostFindings) {
            auto stale = finding("learnt.stale", file, known.device);
            stale.arguments = {
                {"line", known.line}, {"device", known.device}, {"address", std::to_string(known.address)}};
            recalled.findings.push_back(std::move(stale));
        }
    }
    for (const auto& name : reader.lines_with_lengths_off()) {
        if (recalled.findings.size() >= kMostFindings) break;
        if (auto found = lengths_off_finding(project, name)) recalled.findings.push_back(*std::move(found));
    }
    return recalled;
}

}  // namespace takt::file
