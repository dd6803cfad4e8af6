// Rates: the back-off of a device, the rate limit of a command.
#include <algorithm>

#include "servers/interpretation.hpp"

namespace takt::model {
namespace {

Backoff read_parts(Reader& reader, const Backoff& base) {
    const auto first = reader.duration("first");
    const auto limit = reader.duration("limit");
    if (first && limit && *limit < *first)
        reader.report(Rule::backoff_limit, "limit", ">= " + to_text(*first), {{"first", to_text(*first)}});
    Backoff backoff{.first = first.value_or(base.first), .limit = limit.value_or(base.limit)};
    if (!first) backoff.first = std::min(backoff.first, backoff.limit);
    backoff.limit = std::max(backoff.limit, backoff.first);
    return backoff;
}

}  // namespace

std::optional<Backoff> read_backoff(Interpretation& state, Reader& reader, const Backoff& base) {
    if (reader.is_mapping("backoff")) {
        Reader parts(state.findings, *reader.value("backoff"), reader.path_of("backoff"), Object::backoff,
                     state.context);
        return read_parts(parts, base);
    }
    const auto first = reader.duration("backoff");
    if (!first) return std::nullopt;
    return Backoff{.first = *first, .limit = std::max(base.limit, *first)};
}

std::optional<RateLimit> read_admission(Reader& reader) {
    const auto interval = reader.duration("min_interval");
    const auto burst = reader.integer("burst");
    if (reader.given("burst") && !reader.given("min_interval") && !reader.misspelt("min_interval"))
        reader.report(Rule::burst_alone, "burst", reader.allowed_text("min_interval"));
    if (!interval) return std::nullopt;
    return RateLimit{.min_interval = *interval, .burst = static_cast<std::uint16_t>(burst.value_or(1))};
}

}  // namespace takt::model
