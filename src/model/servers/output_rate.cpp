// How many samples an output can have, how long its journal takes them while the broker is away, and whether
// the broker acknowledges them fast enough.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include "servers/interpretation.hpp"
#include "servers/output_parts.hpp"
#include "takt/model/output_remedies.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;
using Seconds = std::chrono::duration<double>;

constexpr Duration kAsFastAsPossible = 100ms;
constexpr Duration kNotByPeriod = 1s;
constexpr Duration kShortOutage = 24h;
constexpr double kLargestInFlight = 256;  // of the key

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

struct SampleRates {
    double by_period = 0;
    double on_change = 0;
    [[nodiscard]] double sum() const { return by_period + on_change; }
};

SampleRates rates_of(const Project& project, const Output& output, const SelectedValue& value) {
    const auto& policy = output.selections[value.selection].policy;
    const double changes = policy.on_change ? changes_per_second(project, value.subject) : 0;
    return {per_second(policy.period), std::max(changes, per_second(policy.heartbeat))};
}

// Bytes of the journal, measured with 1 to 85 values in periods of 10 ms to 1 s: the sum is up to 8 % too
// large.
constexpr double kBytesOfRecord = 67;
constexpr double kBytesOfSeries = 11;    // in each record with samples of it
constexpr double kBytesOfSample = 11;    // without its value
constexpr double kRecordsOnChange = 20;  // at most, in a second: Sampler::kCollect

double bytes_of_value(const Project& project, const OutputSubject& subject) {
    constexpr double kLongestNumber = 8;
    const auto* const polled = std::get_if<PolledIndex>(&subject);
    if (polled == nullptr) return kLongestNumber;
    const auto& variable = project.lines[polled->line].devices[polled->device].variables[polled->variable];
    if (variable.scaled()) return kLongestNumber;
    return variable.type == DataType::boolean ? 1 : 2.0 * variable.registers;
}

/// Values of a device are read together. Locals are as those of a device.
std::pair<std::size_t, std::size_t> device_of(const OutputSubject& subject) {
    const auto* const polled = std::get_if<PolledIndex>(&subject);
    return polled != nullptr ? std::pair(polled->line, polled->device) : std::pair(SIZE_MAX, SIZE_MAX);
}

}  // namespace

double most_samples_per_second(const Project& project, const Output& output) {
    double rate = 0;
    for (const auto& value : output.values) rate += rates_of(project, output, value).sum();
    return rate;
}

double most_journal_bytes_per_second(const Project& project, const Output& output) {
    double bytes = 0;
    std::set<Duration> periods;
    std::map<std::pair<std::size_t, std::size_t>, double> records_on_change;  // by device
    for (const auto& value : output.values) {
        const auto rates = rates_of(project, output, value);
        bytes += rates.sum() * (kBytesOfSample + bytes_of_value(project, value.subject));
        bytes += (rates.by_period + std::min(rates.on_change, kRecordsOnChange)) * kBytesOfSeries;
        periods.insert(output.selections[value.selection].policy.period);
        auto& records = records_on_change[device_of(value.subject)];
        records = std::max(records, rates.on_change);
    }
    double records = 0;
    for (const auto& [device, rate] : records_on_change) records += rate;
    records = std::min(records, kRecordsOnChange);
    for (const auto period : periods) records += per_second(period);
    return bytes + records * kBytesOfRecord;
}

double most_messages_per_second(const Project& project, const Output& output) {
    std::map<std::string_view, double> rates;  // by topic
    for (const auto& value : output.values) {
        const auto& selection = output.selections[value.selection];
        if (output.mqtt.backlog == Backlog::array && !selection.retain) continue;
        auto& rate = rates[value.topic];
        rate = std::max(rate, rates_of(project, output, value).sum());
    }
    double sum = 0;
    for (const auto& [topic, rate] : rates) sum += rate;
    return sum;
}

void check_quota(const Interpretation& state, Reader& reader, const Output& output) {
    const double rate = most_samples_per_second(state.project, output);
    const double bytes = most_journal_bytes_per_second(state.project, output);
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

void check_window(const Interpretation& state, Reader& reader, const Output& output) {
    const auto& mqtt = output.mqtt;
    if (mqtt.backlog == Backlog::array && std::ranges::all_of(output.selections, &OutputSelection::retain))
        reader.report(reader.given("retain") ? Rule::field_without_effect : Rule::field_no_effect_default,
                      "backlog", {}, {{"key", "backlog"}, {"condition", "retain: true"}});
    if (mqtt.round_trip == Duration::zero()) return;
    // The Receive Maximum of mosquitto, unless the user knows what the broker takes.
    constexpr std::uint16_t kUsualWindow = 20;
    const auto window = reader.given("in_flight") ? mqtt.in_flight : std::min(mqtt.in_flight, kUsualWindow);
    const double rate = most_messages_per_second(state.project, output);
    const double limit = window / Seconds(mqtt.round_trip).count();
    if (rate <= limit) return;
    const double needed = std::ceil(rate * Seconds(mqtt.round_trip).count());
    constexpr double kWithTenths = 10;
    const auto tenths = static_cast<std::uint64_t>(10 * limit);
    const auto rounded_up = [](double number) {
        return std::to_string(static_cast<std::uint64_t>(std::ceil(number)));
    };
    reader.report(Rule::output_falls_behind, "round_trip", {},
                  {{"output", output.name},
                   {"rate", rounded_up(rate)},
                   {"limit", std::to_string(tenths / 10) +
                                 (limit < kWithTenths ? "." + std::to_string(tenths % 10) : "")},
                   {"window", std::to_string(window)},
                   {"round_trip", to_text(mqtt.round_trip)},
                   {"needed", rounded_up(needed)},
                   {"remedies", output_remedies(output, needed)}});
}

std::string output_remedies(const Output& output, std::optional<double> needed) {
    std::string words;
    const auto add = [&](bool helps, std::string_view word) {
        if (helps) words.append(words.empty() ? "" : ",").append(word);
    };
    const auto any = [&](auto has) { return std::ranges::any_of(output.selections, has); };
    const bool joins = output.mqtt.backlog == Backlog::array;
    add(!joins, "array");
    add(joins && any([](const auto& its) { return its.retain; }), "retain");
    add(any([](const auto& its) { return its.message == MessageScope::variable; }), "device");
    const bool wider = needed ? *needed <= kLargestInFlight : output.mqtt.in_flight < kLargestInFlight;
    add(wider, needed ? "window" : "in_flight");
    add(!wider, "fewer");
    return words;
}

}  // namespace takt::model
