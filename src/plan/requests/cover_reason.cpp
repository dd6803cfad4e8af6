#include "requests/cover_reason.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <utility>

namespace takt::plan {
namespace {

using model::Variable;

// Three significant digits, or more to keep two costs apart.
std::string figure(double value, int more) {
    const int before = value >= 1 ? static_cast<int>(std::log10(value)) + 1 : 0;
    if (value < 1) return fmt::format("{:.{}g}", value, 3 + more);
    std::string text = fmt::format("{:.{}f}", value, std::max(0, 3 - before) + more);
    if (text.find('.') == std::string::npos) return text;
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
}

}  // namespace

CoverReasons::CoverReasons(const model::Line& line, const model::Device& device, const FunctionReads& reads)
    : device_(device),
      reads_(reads),
      units_per_ms_(static_cast<double>(BusTimeModel(line).of(std::chrono::milliseconds(1))) *
                    static_cast<double>(in_flight(line, device))) {}

const Variable& CoverReasons::variable(std::size_t item) const {
    return device_.variables[reads_.items[item].variable];
}

std::size_t CoverReasons::last_of(const Covered& here) const {
    return *std::max_element(here.members.begin(), here.members.end(), [this](std::size_t a, std::size_t b) {
        return reads_.spans[a].end < reads_.spans[b].end;
    });
}

std::size_t CoverReasons::first_beyond(const Covered& here, const Covered& next) const {
    const auto at = std::find_if(next.members.begin(), next.members.end(), [&](std::size_t member) {
        return reads_.spans[member].end > here.items.end;
    });
    return at == next.members.end() ? next.members.front() : *at;
}

std::pair<std::string, std::string> CoverReasons::milliseconds(ExactTime a, ExactTime b) const {
    constexpr int kMostDigits = 12;
    std::pair<std::string, std::string> texts;
    for (int more = 0; more < kMostDigits; ++more) {
        texts = {figure(static_cast<double>(a) / units_per_ms_, more),
                 figure(static_cast<double>(b) / units_per_ms_, more)};
        if (texts.first != texts.second) break;
    }
    return texts;
}

std::optional<std::string> CoverReasons::forbidden_by(const Span& gap) const {
    const auto run = std::partition_point(reads_.readable.begin(), reads_.readable.end(),
                                          [&](const Span& r) { return r.end < gap.start; });
    const std::uint32_t item = run == reads_.readable.end() ? gap.start : run->end;
    if (item >= gap.end) return std::nullopt;
    if (device_.gaps == model::Gaps::never) return "gaps: never";
    const auto area = static_cast<std::size_t>(area_of(reads_.function));
    for (const auto& [first, last] : device_.no_read[area])
        if (first <= item && item <= last) return fmt::format("no_read: {}..{}", first, last);
    if (device_.gaps != model::Gaps::learn) return "readable";
    for (const auto& refused : device_.learnt.refused[area])
        if (refused.items.first <= item && item <= refused.items.last)
            return fmt::format("gaps: learn, exception {}: {}..{}", refused.exception, refused.items.first,
                               refused.items.last);
    return "readable";
}

// A gap that costs more than a request ends the request even if the limit does too: a greater limit would not
// help.
Reason CoverReasons::apart(const Covered& here, const Covered& next) const {
    const Variable& previous = variable(last_of(here));
    const std::size_t first = first_beyond(here, next);
    const Variable& following = variable(first);
    const Span gap{std::min(here.items.end, next.items.start), next.items.start};
    Reason reason{{}, {{"previous", previous.name}, {"next", following.name}}};
    const auto add = [&](const char* name, std::string value) {
        reason.arguments.emplace_back(name, std::move(value));
    };
    if (gap.size() > 0) {
        if (auto setting = forbidden_by(gap)) {
            reason.code = "plan.gap_forbidden";
            add("size", std::to_string(gap.size()));
            add("setting", *std::move(setting));
            return reason;
        }
        const std::uint32_t asked = here.items.size() + next.items.size();
        const ExactTime joined = reads_.cost(asked);
        const ExactTime gap_cost = reads_.cost(asked + gap.size()) - joined;
        const ExactTime request_cost =
            reads_.cost(here.items.size()) + reads_.cost(next.items.size()) - joined;
        if (gap_cost > request_cost) {
            reason.code = "plan.gap_costs";
            add("size", std::to_string(gap.size()));
            auto [gap_ms, request_ms] = milliseconds(gap_cost, request_cost);
            add("gap_ms", std::move(gap_ms));
            add("request_ms", std::move(request_ms));
            return reason;
        }
    }
    const std::uint32_t limit = reads_.rules().limit;
    const std::uint32_t with_next = std::max(here.items.end, reads_.spans[first].end) - here.items.start;
    if (with_next > limit) return reads_.limit.reason(with_next, following);
    reason.code = "plan.cheapest_cut";
    add("size", std::to_string(std::max(here.items.end, next.items.end) - here.items.start));
    add("limit", std::to_string(limit));
    return reason;
}

Reason CoverReasons::other_period(const Covered& here, std::size_t next) const {
    const auto text = [](Duration period) {
        return fmt::format("{}", std::chrono::duration<double, std::milli>(period).count());
    };
    const std::size_t previous = last_of(here);
    return {"plan.other_period",
            {{"previous", variable(previous).name},
             {"next", variable(next).name},
             {"previous_ms", text(reads_.items[previous].period)},
             {"next_ms", text(reads_.items[next].period)}}};
}

Reason CoverReasons::last(const Covered& here) const {
    return {"plan.last", {{"variable", variable(last_of(here)).name}}};
}

std::optional<Reason> CoverReasons::bridged(const Covered& here) const {
    std::uint32_t reach = here.items.start;
    std::uint32_t size = 0;
    std::size_t gaps = 0;
    ExactTime alone = 0;
    std::uint32_t piece = here.items.start;
    for (const std::size_t member : here.members) {
        const Span& span = reads_.spans[member];
        if (span.start > reach) {
            ++gaps;
            size += span.start - reach;
            alone += reads_.cost(reach - piece);
            piece = span.start;
        }
        reach = std::max(reach, span.end);
    }
    if (gaps == 0) return std::nullopt;
    alone += reads_.cost(reach - piece);
    const ExactTime without = reads_.cost(here.items.size() - size);
    auto [gap_ms, request_ms] = milliseconds(reads_.cost(here.items.size()) - without, alone - without);
    return Reason{"plan.bridged",
                  {{"gaps", std::to_string(gaps)},
                   {"size", std::to_string(size)},
                   {"gap_ms", std::move(gap_ms)},
                   {"request_ms", std::move(request_ms)}}};
}

}  // namespace takt::plan
