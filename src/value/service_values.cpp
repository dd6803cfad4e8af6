#include "takt/value/service_values.hpp"

#include <cmath>

namespace takt::value {
namespace {

using model::ServiceRate;
using model::ServiceScope;
using model::ServiceValue;

Value counter(std::uint64_t count) {
    return count & 0xFFFF'FFFFU;
}

/// The float nearest to a number with these decimals: a reader sees 13.594, not 13.593751.
Value rounded(double number, double decimals) {
    return double{static_cast<float>(std::round(number * decimals) / decimals)};
}

Value milliseconds(Duration time) {
    return rounded(static_cast<double>(time.count()) / 1e6, 1000);
}

Value percent(double part) {
    return rounded(100 * part, 100);
}

Value pulse(Duration period, Duration uptime) {
    return uptime >= period && uptime % period < period / 2;
}

Value program_value(const model::ServiceField& field, const ServiceFacts& facts) {
    switch (field.value) {
        case ServiceValue::time: return counter(facts.utc_seconds());
        case ServiceValue::uptime:
            return counter(static_cast<std::uint64_t>(facts.uptime() / std::chrono::seconds(1)));
        case ServiceValue::first_cycle:
            return facts.uptime() < kLongestFirstCycle && !facts.first_cycle_is_over();
        default: return pulse(field.period, facts.uptime());
    }
}

Value line_value(ServiceValue value, const LineFacts& line) {
    switch (value) {
        case ServiceValue::line_up: return line.up;
        case ServiceValue::line_load: return percent(line.load);
        case ServiceValue::line_cycle: return milliseconds(line.cycle);
        case ServiceValue::line_requests: return counter(line.requests);
        default: return counter(line.errors);
    }
}

Value device_value(ServiceValue value, const DeviceFacts& device) {
    switch (value) {
        case ServiceValue::device_state: return std::uint64_t{device.state};
        case ServiceValue::device_answering: return device.answering;
        case ServiceValue::device_response_time: return milliseconds(device.response_time);
        case ServiceValue::device_requests: return counter(device.requests);
        case ServiceValue::device_errors: return counter(device.errors);
        case ServiceValue::device_timeouts: return counter(device.timeouts);
        case ServiceValue::device_checksum_errors: return counter(device.checksum_errors);
        case ServiceValue::device_exceptions: return counter(device.exceptions);
        default: return counter(device.outages);
    }
}

}  // namespace

Value service_value(const model::ServiceVariable& variable, const ServiceFacts& facts) {
    const auto& field = *variable.field;
    switch (field.scope) {
        case ServiceScope::line: return line_value(field.value, facts.line(variable.line));
        case ServiceScope::device:
            return device_value(field.value, facts.device(variable.line, variable.device));
        case ServiceScope::program: break;
    }
    return program_value(field, facts);
}

// A device beyond the limits of a profile is not in the project; its variables get no value.
ServiceValues::ServiceValues(const model::Project& project, const ProjectSlots& slots) {
    std::optional<model::ServiceNames> names;
    for (model::LocalIndex i = 0; i < project.locals.size(); ++i) {
        const auto& local = project.locals[i];
        if (!local.service) continue;
        if (!names) names.emplace(project);
        if (const auto found = names->find(local.name)) used_.push_back({slots.local(i), *found});
    }
    computed_.reserve(used_.size());
}

// Time and uptime are due with the second, the values of lines and devices in turn: thousands of them must
// not become events at one moment.
bool ServiceValues::is_due(std::size_t index, std::int64_t step) const {
    constexpr std::int64_t kSteps = std::chrono::seconds(1) / kEvery;
    const auto& field = *used_[index].variable.field;
    if (!step_ || field.rate == ServiceRate::fast) return true;
    const auto turn = field.scope == ServiceScope::program ? 0 : static_cast<std::int64_t>(index) % kSteps;
    return (step + kSteps - turn) / kSteps != (*step_ + kSteps - turn) / kSteps;
}

std::span<const ServiceValues::Computed> ServiceValues::update(const ServiceFacts& facts) {
    const std::int64_t step = facts.uptime() / kEvery;
    computed_.clear();
    for (std::size_t i = 0; i < used_.size(); ++i)
        if (is_due(i, step)) computed_.push_back({used_[i].slot, service_value(used_[i].variable, facts)});
    step_ = step;
    return computed_;
}

}  // namespace takt::value
