#include "json/learnt_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "takt/base/iso_time.hpp"

namespace takt::file {

using model::ItemRange;
using model::Learnt;

namespace {

constexpr std::int64_t kMostCount = std::int64_t{1} << 53;  // exact in every reader of JSON
constexpr std::int64_t kMostMicroseconds = std::chrono::microseconds(kLongestLearntTime).count();

}  // namespace

const Json::Array* LearntReader::list(const Json& json, const std::string& path, const char* key) {
    const Json* found = json.find(key);
    const auto* items = found ? std::get_if<Json::Array>(&found->value()) : nullptr;
    if (!items) bad(path + "." + key);
    return items;
}

const std::string* LearntReader::text(const Json& json, const std::string& path, const char* key) {
    const Json* found = json.find(key);
    const auto* words = found ? std::get_if<std::string>(&found->value()) : nullptr;
    if (!words) bad(path + "." + key);
    return words;
}

std::optional<std::int64_t> LearntReader::number(const Json* json, const std::string& path,
                                                 std::int64_t least, std::int64_t most) {
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

std::optional<ItemRange> LearntReader::range(const Json* json, const std::string& path) {
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

bool LearntReader::read(const Json& root) {
    if (!number(root.find("takt_learnt"), "takt_learnt", kOldestLearntVersion, kLearntVersion)) return false;
    const auto* lines = list(root, "", "lines");
    if (!lines) return false;
    for (std::size_t l = 0; l < lines->size(); ++l) {
        const std::string path = fmt::format("lines[{}]", l);
        const auto* name = text((*lines)[l], path, "line");
        const auto* devices = name ? list((*lines)[l], path, "devices") : nullptr;
        if (!devices || !read_lengths_off((*lines)[l], *name, path)) return false;
        for (std::size_t d = 0; d < devices->size(); ++d)
            if (!read_device((*devices)[d], *name, fmt::format("{}.devices[{}]", path, d))) return false;
    }
    return true;
}

bool LearntReader::read_lengths_off(const Json& json, const std::string& line, const std::string& path) {
    const Json* found = json.find("lengths_off");
    if (!found) return true;
    const auto* off = std::get_if<bool>(&found->value());
    if (!off) return bad(path + ".lengths_off");
    if (*off) lengths_off_.push_back(line);
    return true;
}

bool LearntReader::read_device(const Json& json, const std::string& line, const std::string& path) {
    const auto* name = text(json, path, "device");
    const auto address = name ? number(json.find("address"), path + ".address", 0, 255) : std::nullopt;
    const auto* areas = address ? list(json, path, "areas") : nullptr;
    if (!areas) return false;
    Known known{line, *name, static_cast<std::uint8_t>(*address), {}, {}};
    for (std::size_t a = 0; a < areas->size(); ++a)
        if (!read_area((*areas)[a], fmt::format("{}.areas[{}]", path, a), known.learnt)) return false;
    if (const Json* times = json.find("times"); times && !read_times(*times, path + ".times", known.times))
        return false;
    known_.push_back(std::move(known));
    return true;
}

bool LearntReader::read_number(const Json& json, const std::string& path, const char* key,
                               std::uint64_t& count) {
    const auto read = number(json.find(key), path + "." + key, 0, kMostCount);
    if (read) count = static_cast<std::uint64_t>(*read);
    return read.has_value();
}

bool LearntReader::read_duration(const Json& json, const std::string& path, const char* key, Duration& time) {
    const auto read = number(json.find(key), path + "." + key, 0, kMostMicroseconds);
    if (read) time = std::chrono::microseconds(*read);
    return read.has_value();
}

bool LearntReader::read_times(const Json& json, const std::string& path, model::LearntTimes& times) {
    auto& measured = times.measured;
    if (!read_number(json, path, "exchanges", measured.exchanges) ||
        !read_duration(json, path, "longest_us", measured.longest) ||
        !read_duration(json, path, "p999_us", measured.p999) || !read_counts(json, path, times) ||
        !read_number(json, path, "attempts", measured.attempts) ||
        !read_number(json, path, "late", measured.late) ||
        !read_duration(json, path, "lateness_us", measured.lateness) ||
        !read_next_latest(json, path, measured))
        return false;
    return measured.p999 <= measured.longest || bad(path + ".p999_us");
}

// An older file has none.
bool LearntReader::read_next_latest(const Json& json, const std::string& path,
                                    model::MeasuredTimes& measured) {
    auto& next = measured.next_latest;
    if (!json.find("next_latest_us")) {
        for (std::size_t i = 0; i < next.size(); ++i)
            next[i] = measured.late > i + 1 ? measured.lateness : Duration::zero();
        return true;
    }
    const auto* times = list(json, path, "next_latest_us");
    if (!times) return false;
    if (times->size() != next.size()) return bad(path + ".next_latest_us");
    Duration longest = measured.lateness;
    for (std::size_t i = 0; i < next.size(); ++i) {
        const std::string location = fmt::format("{}.next_latest_us[{}]", path, i);
        const auto time = number(&(*times)[i], location, 0, kMostMicroseconds);
        if (!time) return false;
        next[i] = std::chrono::microseconds(*time);
        if (next[i] > std::exchange(longest, next[i])) return bad(location);
    }
    return true;
}

// The counts are complete: their sum is the number of exchanges.
bool LearntReader::read_counts(const Json& json, const std::string& path, model::LearntTimes& times) {
    const auto* counts = list(json, path, "counts");
    if (!counts) return false;
    if (counts->size() > model::LearntTimes::kMostCounts) return bad(path + ".counts");
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < counts->size(); ++i) {
        const std::string location = fmt::format("{}.counts[{}]", path, i);
        const auto* pair = std::get_if<Json::Array>(&(*counts)[i].value());
        if (!pair || pair->size() != 2) return bad(location);
        const auto upper = number(&(*pair)[0], location, 0, kMostMicroseconds);
        const auto count = upper ? number(&(*pair)[1], location, 1, kMostCount) : std::nullopt;
        if (!count) return false;
        const Duration time = std::chrono::microseconds(*upper);
        if (!times.counts.empty() && times.counts.back().upper >= time) return bad(location);
        times.counts.push_back({time, static_cast<std::uint64_t>(*count)});
        sum += static_cast<std::uint64_t>(*count);
    }
    return sum == times.measured.exchanges || bad(path + ".exchanges");
}

bool LearntReader::read_area(const Json& json, const std::string& path, Learnt& learnt) {
    const auto* name = text(json, path, "area");
    if (!name) return false;
    const auto area =
        std::ranges::find_if(kLearntAreas, [name](wire::Area known) { return wire::name(known) == *name; });
    if (area == kLearntAreas.end()) return bad(path + ".area");
    const auto a = static_cast<std::size_t>(*area);
    const auto* confirmed = list(json, path, "confirmed");
    const auto* refused = confirmed ? list(json, path, "refused") : nullptr;
    if (!refused) return false;
    if (confirmed->size() > Learnt::kMostRanges) return bad(path + ".confirmed");
    if (refused->size() > Learnt::kMostRanges) return bad(path + ".refused");
    learnt.confirmed[a].clear();
    learnt.refused[a].clear();
    for (std::size_t i = 0; i < confirmed->size(); ++i) {
        const std::string location = fmt::format("{}.confirmed[{}]", path, i);
        const auto items = range(&(*confirmed)[i], location);
        if (!items) return false;
        if (!learnt.confirmed[a].empty() && learnt.confirmed[a].back().last + 1 >= items->first)
            return bad(location);
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

bool LearntReader::read_refused(const Json& json, const std::string& path,
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

// A time in the future is cut to now: the clock may have been set back.
bool LearntReader::read_time(const Json& json, const std::string& path, const char* key, Duration& age) {
    const auto* words = text(json, path, key);
    const auto ns = words ? read_utc_time(*words) : std::nullopt;
    if (!ns) return bad(path + "." + key);
    constexpr auto kOldest = std::chrono::hours(24 * 366);
    const auto time =
        std::chrono::floor<std::chrono::seconds>(std::chrono::sys_time<Duration>(Duration(*ns)));
    age = std::clamp<std::chrono::seconds>(now_ - time, std::chrono::seconds(0), kOldest);
    return true;
}

}  // namespace takt::file
