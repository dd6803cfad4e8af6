// How many samples an output can have, and how long its journal takes them while the broker is away.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "interpretation.hpp"
#include "output_parts.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;

constexpr Duration kAsFastAsPossible = 100ms;
constexpr Duration kNotByPeriod = 1s;
constexpr Duration kShortOutage = 24h;

double per_second(Duration every) {
    return every > Duration::zero() ? 1 / Seconds(every).count() : 0;
}

/// How often a value can change.
double changes_per_second(const Project& project, const OutputSubject& subject) {
    const auto* const polled = std::get_if<PolledIndex>(&subject);
    if (polled == nullptr) return per_second(kNotByPeriod);
    const auto& variable = project.lines[polled->line].devices[polled->device].variables[polled->variable];
    if (!variable.read) return per_second(kNotByPeriod);
    return per_second(variable.period > Duration::zero() ? variable.period : kAsFastAsPossible);
}

/// 3 h, 45 min
std::string rounded(Seconds time) {
    const auto minutes = static_cast<long>(time / 1min);
    return minutes < 120 ? std::to_string(std::max(minutes, 1L)) + " min"
                         : std::to_string(minutes / 60) + " h";
}

}  // namespace

double most_samples_per_second(const Project& project, const Output& output) {
    double rate = 0;
    for (const auto& value : output.values) {
        const auto& policy = output.selections[value.selection].policy;
        const double changes = policy.on_change ? changes_per_second(project, value.subject) : 0;
        rate += per_second(policy.period) + std::max(changes, per_second(policy.heartbeat));
    }
    return rate;
}

void check_quota(const Interpretation& state, Reader& reader, const Output& output) {
    const double rate = most_samples_per_second(state.project, output);
    const double bytes = rate * kJournalBytesOfASample;
    if (bytes * Seconds(kShortOutage).count() <= static_cast<double>(output.journal.quota)) return;
    constexpr double kMebi = 1 << 20;
    const Seconds until_full(static_cast<double>(output.journal.quota) / bytes);
    const auto needed = static_cast<std::uint64_t>(std::ceil(bytes * Seconds(kShortOutage).count() / kMebi));
    reader.report(Rule::output_quota_short, "quota_mb", {},
                  {{"output", output.name},
                   {"time", rounded(until_full)},
                   {"rate", std::to_string(static_cast<std::uint64_t>(std::ceil(rate)))},
                   {"needed", std::to_string(needed)}});
}

}  // namespace takt::model
