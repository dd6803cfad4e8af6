#include "takt/file/learnt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <utility>

#include "takt/file/json.hpp"

namespace takt::file {
namespace {

using model::ItemRange;
using model::Learnt;
using Seconds = std::chrono::sys_seconds;

constexpr std::int64_t kVersion = 1;
constexpr std::size_t kMostFindings = 20;
constexpr std::array kAreas{wire::Area::coil, wire::Area::discrete_input, wire::Area::input_register,
                            wire::Area::holding_register};

// Times
// ------------------------------------------------------------------------------------------------

std::string time_text(Seconds time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                       static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                       clock.hours().count(), clock.minutes().count(), clock.seconds().count());
}

std::optional<Seconds> time_of(std::string_view text) {
    constexpr std::string_view kPattern = "0000-00-00T00:00:00Z";
    std::array<unsigned, 6> numbers{};
    if (text.size() != kPattern.size()) return std::nullopt;
    std::size_t number = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool digit = text[i] >= '0' && text[i] <= '9';
        if (kPattern[i] == '0' ? !digit : text[i] != kPattern[i]) return std::nullopt;
        if (digit)
            numbers[number] = 10 * numbers[number] + static_cast<unsigned>(text[i] - '0');
        else
            ++number;
    }
    const std::chrono::year_month_day date{std::chrono::year(static_cast<int>(numbers[0])),
                                           std::chrono::month(numbers[1]), std::chrono::day(numbers[2])};
    if (!date.ok() || numbers[3] > 23 || numbers[4] > 59 || numbers[5] > 59) return std::nullopt;
    return std::chrono::sys_days(date) + std::chrono::hours(numbers[3]) + std::chrono::minutes(numbers[4]) +
           std::chrono::seconds(numbers[5]);
}

// Writing
// ------------------------------------------------------------------------------------------------

std::string range_text(const ItemRange& range) {
    return fmt::format("{}..{}", range.first, range.last);
}

Seconds moment(Seconds now, Duration age) {
    return now - std::chrono::floor<std::chrono::seconds>(age);
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
        entry.set("since", time_text(moment(now, range.since)));
        entry.set("checked", time_text(moment(now, range.checked)));
        refused.push_back(std::move(entry));
    }
    auto object = Json::object();
    object.set("area", wire::name(area));
    object.set("confirmed", std::move(confirmed));
    object.set("refused", std::move(refused));
    if (learnt.most_items[a] > 0) object.set("most_items", learnt.most_items[a]);
    return object;
}

std::optional<Json> device_json(const model::Device& device, const Learnt& learnt, Seconds now) {
    auto areas = Json::array();
    bool any = false;
    for (const auto area : kAreas)
        if (auto known = area_json(learnt, area, now)) {
            areas.push_back(*std::move(known));
            any = true;
        }
    if (!any) return std::nullopt;
    auto object = Json::object();
    object.set("device", device.name);
    object.set("address", device.address.value);
    object.set("areas", std::move(areas));
    return object;
}

// Reading
// ------------------------------------------------------------------------------------------------

/// Reads the tree; the first thing that is not as it should be ends it, with its place.
class Reader {
public:
    Reader(Seconds now) : now_(now) {}

    struct Known {
        std::string line;
        std::string device;
        std::uint8_t address = 0;
        Learnt learnt;
    };
    [[nodiscard]] bool read(const Json& root);
    [[nodiscard]] std::vector<Known> take() { return std::move(known_); }
    [[nodiscard]] const std::string& fault() const { return fault_; }

private:
    bool read_device(const Json& json, const std::string& line, const std::string& path);
    bool read_area(const Json& json, const std::string& path, Learnt& learnt);
    bool read_refused(const Json& json, const std::string& path, std::vector<model::RefusedItems>& refused);
    bool read_time(const Json& json, const std::string& path, const char* key, Duration& age);
    std::optional<ItemRange> range(const Json* json, const std::string& path);
    const Json::Array* list(const Json& json, const std::string& path, const char* key);
    const std::string* text(const Json& json, const std::string& path, const char* key);
    std::optional<std::int64_t> number(const Json* json, const std::string& path, std::int64_t least,
                                       std::int64_t most);
    bool bad(const std::string& path) {
        fault_ = path;
        return false;
    }

    Seconds now_;
    std::vector<Known> known_;
    std::string fault_;
};

const Json::Array* Reader::list(const Json& json, const std::string& path, const char* key) {
    const Json* found = json.find(key);
    const auto* items = found ? std::get_if<Json::Array>(&found->value()) : nullptr;
    if (!items) bad(path + "." + key);
    return items;
}

const std::string* Reader::text(const Json& json, const std::string& path, const char* key) {
    const Json* found = json.find(key);
    const auto* words = found ? std::get_if<std::string>(&found->value()) : nullptr;
    if (!words) bad(path + "." + key);
    return words;
}

std::optional<std::int64_t> Reader::number(const Json* json, const std::string& path, std::int64_t least,
                                           std::int64_t most) {
    std::optional<std::int64_t> found;
    if (json) {
        if (const auto* whole = std::get_if<std::int64_t>(&json->value())) found = *whole;
        const auto* large = std::get_if<std::uint64_t>(&json->value());
        if (large && *large <= static_cast<std::uint64_t>(most)) found = static_cast<std::int64_t>(*large);
    }
    if (found && (*found < least || *found > most)) found.reset();
    if (!found) bad(path);
    return found;
}

std::optional<ItemRange> Reader::range(const Json* json, const std::string& path) {
    const auto* words = json ? std::get_if<std::string>(&json->value()) : nullptr;
    ItemRange items;
    if (words) {
        const char* const end = words->data() + words->size();
        const auto [dots, first] = std::from_chars(words->data(), end, items.first);
        if (first == std::errc() && end - dots > 2 && dots[0] == '.' && dots[1] == '.') {
            const auto [rest, last] = std::from_chars(dots + 2, end, items.last);
            if (last == std::errc() && rest == end && items.first <= items.last) return items;
        }
    }
    bad(path);
    return std::nullopt;
}

bool Reader::read(const Json& root) {
    if (!number(root.find("takt_learnt"), "takt_learnt", kVersion, kVersion)) return false;
    const auto* lines = list(root, "", "lines");
    if (!lines) return false;
    for (std::size_t l = 0; l < lines->size(); ++l) {
        const std::string path = fmt::format("lines[{}]", l);
        const auto* name = text((*lines)[l], path, "line");
        const auto* devices = name ? list((*lines)[l], path, "devices") : nullptr;
        if (!devices) return false;
        for (std::size_t d = 0; d < devices->size(); ++d)
            if (!read_device((*devices)[d], *name, fmt::format("{}.devices[{}]", path, d))) return false;
    }
    return true;
}

bool Reader::read_device(const Json& json, const std::string& line, const std::string& path) {
    const auto* name = text(json, path, "device");
    const auto address = name ? number(json.find("address"), path + ".address", 0, 255) : std::nullopt;
    const auto* areas = address ? list(json, path, "areas") : nullptr;
    if (!areas) return false;
    Known known{line, *name, static_cast<std::uint8_t>(*address), {}};
    for (std::size_t a = 0; a < areas->size(); ++a)
        if (!read_area((*areas)[a], fmt::format("{}.areas[{}]", path, a), known.learnt)) return false;
    known_.push_back(std::move(known));
    return true;
}

bool Reader::read_area(const Json& json, const std::string& path, Learnt& learnt) {
    const auto* name = text(json, path, "area");
    if (!name) return false;
    const auto area =
        std::ranges::find_if(kAreas, [name](wire::Area known) { return wire::name(known) == *name; });
    if (area == kAreas.end()) return bad(path + ".area");
    const auto a = static_cast<std::size_t>(*area);
    const auto* confirmed = list(json, path, "confirmed");
    const auto* refused = confirmed ? list(json, path, "refused") : nullptr;
    if (!refused) return false;
    if (confirmed->size() > Learnt::kMostRanges) return bad(path + ".confirmed");
    if (refused->size() > Learnt::kMostRanges) return bad(path + ".refused");
    learnt.confirmed[a].clear();
    learnt.refused[a].clear();
    for (std::size_t i = 0; i < confirmed->size(); ++i) {
        const std::string place = fmt::format("{}.confirmed[{}]", path, i);
        const auto items = range(&(*confirmed)[i], place);
        if (!items) return false;
        if (!learnt.confirmed[a].empty() && learnt.confirmed[a].back().last + 1 >= items->first)
            return bad(place);
        learnt.confirmed[a].push_back(*items);
    }
    for (std::size_t i = 0; i < refused->size(); ++i)
        if (!read_refused((*refused)[i], fmt::format("{}.refused[{}]", path, i), learnt.refused[a]))
            return false;
    const Json* most = json.find("most_items");
    if (!most) return true;
    const auto items = number(most, path + ".most_items", 1, 65535);
    if (items) learnt.most_items[a] = static_cast<std::uint16_t>(*items);
    return items.has_value();
}

bool Reader::read_refused(const Json& json, const std::string& path,
                          std::vector<model::RefusedItems>& refused) {
    const auto items = range(json.find("items"), path + ".items");
    const auto code = items ? number(json.find("exception"), path + ".exception", 1, 4) : std::nullopt;
    if (!code) return false;
    if (!refused.empty() && refused.back().items.last >= items->first) return bad(path + ".items");
    model::RefusedItems made{.items = *items, .exception = static_cast<std::uint8_t>(*code)};
    if (!read_time(json, path, "since", made.since) || !read_time(json, path, "checked", made.checked))
        return false;
    made.checked = std::min(made.checked, made.since);
    refused.push_back(made);
    return true;
}

// A clock that was set back makes no time lie in the future.
bool Reader::read_time(const Json& json, const std::string& path, const char* key, Duration& age) {
    const auto* words = text(json, path, key);
    const auto time = words ? time_of(*words) : std::nullopt;
    if (!time) return bad(path + "." + key);
    constexpr auto kOldest = std::chrono::hours(24 * 366);
    age = std::clamp<std::chrono::seconds>(now_ - *time, std::chrono::seconds(0), kOldest);
    return true;
}

model::Device* device_of(model::Project& project, const Reader::Known& known) {
    for (auto& line : project.lines)
        if (line.name == known.line)
            for (auto& device : line.devices)
                if (device.name == known.device && device.address.value == known.address) return &device;
    return nullptr;
}

model::Finding finding(const char* code, std::uint32_t file, std::string value) {
    return {.severity = model::Severity::warning,
            .code = code,
            .place = {.file = file},
            .path = {},
            .value = std::move(value),
            .allowed = {},
            .arguments = {}};
}

}  // namespace

std::string learnt_text(const model::Project& project, const LearntOfLines& learnt, Seconds now) {
    auto lines = Json::array();
    for (std::size_t l = 0; l < project.lines.size() && l < learnt.size(); ++l) {
        auto devices = Json::array();
        bool any = false;
        for (std::size_t d = 0; d < project.lines[l].devices.size() && d < learnt[l].size(); ++d) {
            const auto& device = project.lines[l].devices[d];
            if (device.gaps != model::Gaps::learn) continue;
            if (auto known = device_json(device, learnt[l][d], now)) {
                devices.push_back(*std::move(known));
                any = true;
            }
        }
        if (!any) continue;
        auto line = Json::object();
        line.set("line", project.lines[l].name);
        line.set("devices", std::move(devices));
        lines.push_back(std::move(line));
    }
    auto root = Json::object();
    root.set("takt_learnt", kVersion);
    root.set("lines", std::move(lines));
    return root.dump(1) + '\n';
}

Recalled recall(std::string_view text, Seconds now, std::uint32_t file, model::Project& project) {
    Recalled recalled;
    const auto json = Json::parse(text, kMaxLearntBytes);
    Reader reader(now);
    if (!json || !reader.read(*json)) {
        recalled.findings.push_back(finding("learnt.damaged", file, json ? reader.fault() : "JSON"));
        return recalled;
    }
    recalled.whole = true;
    for (auto& known : reader.take()) {
        if (auto* device = device_of(project, known)) {
            if (device->gaps == model::Gaps::learn) device->learnt = std::move(known.learnt);
        } else if (recalled.findings.size() < kMostFindings) {
            auto stale = finding("learnt.stale", file, known.device);
            stale.arguments = {
                {"line", known.line}, {"device", known.device}, {"address", std::to_string(known.address)}};
            recalled.findings.push_back(std::move(stale));
        }
    }
    return recalled;
}

}  // namespace takt::file
