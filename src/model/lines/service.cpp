// A name has the form system.WORD, system.line.NAME.WORD or system.device.NAME.WORD. WORD has no dot, so the
// last dot ends a NAME that has dots itself.
#include "takt/model/service.hpp"

#include <algorithm>
#include <array>
#include <ranges>

#include "takt/model/nearest.hpp"
#include "takt/model/scalar.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;

// The rate limit of a pulse is a little less than its period, so that one that is late delays no later one.
constexpr auto kFields = [] {
    using enum DataType;
    using enum ServiceRate;
    using enum ServiceScope;
    return std::array{
        ServiceField{ServiceValue::time, program, "time", uint32, "s"},
        ServiceField{ServiceValue::uptime, program, "uptime", uint32, "s"},
        ServiceField{ServiceValue::first_cycle, program, "first_cycle", boolean, "", fast, 10s},
        ServiceField{ServiceValue::pulse_1s, program, "pulse_1s", boolean, "", fast, 900ms, 1s},
        ServiceField{ServiceValue::pulse_1min, program, "pulse_1min", boolean, "", fast, 59900ms, 1min},
        ServiceField{ServiceValue::line_up, line, "up", boolean, "", fast, 1s},
        ServiceField{ServiceValue::line_load, line, "load", float32, "%"},
        ServiceField{ServiceValue::line_cycle, line, "cycle", float32, "ms"},
        ServiceField{ServiceValue::line_requests, line, "requests", uint32, ""},
        ServiceField{ServiceValue::line_errors, line, "errors", uint32, ""},
        ServiceField{ServiceValue::device_state, device, "state", uint16, "", fast},
        ServiceField{ServiceValue::device_answering, device, "answering", boolean, "", fast, 1s},
        ServiceField{ServiceValue::device_response_time, device, "response_time", float32, "ms"},
        ServiceField{ServiceValue::device_requests, device, "requests", uint32, ""},
        ServiceField{ServiceValue::device_errors, device, "errors", uint32, ""},
        ServiceField{ServiceValue::device_timeouts, device, "timeouts", uint32, ""},
        ServiceField{ServiceValue::device_checksum_errors, device, "checksum_errors", uint32, ""},
        ServiceField{ServiceValue::device_exceptions, device, "exceptions", uint32, ""},
        ServiceField{ServiceValue::device_outages, device, "outages", uint32, ""},
    };
}();

constexpr bool fields_in_order() {
    for (std::size_t i = 0; i < kFields.size(); ++i)
        if (static_cast<std::size_t>(kFields[i].value) != i) return false;
    return kFields.back().value == ServiceValue::device_outages;
}
static_assert(fields_in_order(), "kFields has a row for each value, in the order of the enum");

constexpr std::string_view kLinePrefix = "line.";
constexpr std::string_view kDevicePrefix = "device.";
constexpr std::size_t kNamesToList = 12;
constexpr std::size_t kMistypedPrefix = 4;  // two mistakes
constexpr int kBitsOfACounter = 32;
constexpr std::uint64_t kGreatestAddress = 255;

constexpr std::uint64_t address_key(std::size_t of_line, std::uint64_t address) {
    return of_line * (kGreatestAddress + 1) + address;
}

/// A name taken apart.
struct ServiceNameParts {
    ServiceScope scope = ServiceScope::program;
    std::string_view subject;  // of a line or device
    std::string_view word;
};

// A mistyped prefix ends with the first dot too.
ServiceNameParts parts_of(std::string_view name) {
    const auto prefix_end = name.find('.');
    if (prefix_end != std::string_view::npos) name.remove_prefix(prefix_end + 1);
    for (const auto& [prefix, scope] :
         {std::pair(kLinePrefix, ServiceScope::line), std::pair(kDevicePrefix, ServiceScope::device)}) {
        if (!name.starts_with(prefix)) continue;
        const auto rest = name.substr(prefix.size());
        const auto dot = rest.rfind('.');
        if (dot == std::string_view::npos) return {scope, rest, {}};
        return {scope, rest.substr(0, dot), rest.substr(dot + 1)};
    }
    return {ServiceScope::program, {}, name};
}

const ServiceField* field_of(ServiceScope scope, std::string_view word) {
    const auto* const found = std::ranges::find_if(
        kFields, [&](const ServiceField& field) { return field.scope == scope && field.word == word; });
    return found == kFields.end() ? nullptr : &*found;
}

std::string listed(std::span<const std::string> names) {
    std::string all;
    for (const auto& name : names | std::views::take(kNamesToList)) {
        if (!all.empty()) all += ", ";
        all += name;
    }
    if (names.size() > kNamesToList) all += ", …";
    return all;
}

std::vector<std::string_view> service_words(ServiceScope scope) {
    std::vector<std::string_view> words;
    for (const auto& field : kFields)
        if (field.scope == scope) words.push_back(field.word);
    return words;
}

std::string service_name(std::string_view prefix, std::string_view subject, std::string_view word) {
    std::string name(kServicePrefix);
    name.append(prefix).append(subject);
    if (!subject.empty()) name += '.';
    return name.append(word);
}

std::string listed_words(std::string_view prefix, std::string_view subject, ServiceScope scope) {
    std::string all;
    for (const auto word : service_words(scope)) {
        if (!all.empty()) all += ", ";
        all += service_name(prefix, subject, word);
    }
    return all;
}

ServiceHint program_hint(std::string_view word) {
    return {service_name({}, {}, nearest(word, service_words(ServiceScope::program))),
            listed_words({}, {}, ServiceScope::program) + ", system.line.NAME.*, system.device.NAME.*"};
}

}  // namespace

std::span<const ServiceField> service_fields() {
    return kFields;
}

bool resembles_service_name(std::string_view name) {
    const auto dot = name.find('.');
    if (dot == std::string_view::npos) return false;
    const auto word = kServicePrefix.substr(0, kServicePrefix.size() - 1);
    return typing_distance(name.substr(0, dot), word) <= kMistypedPrefix;
}

bool outgrows(const ServiceField& field, DataType type, bool scaled) {
    using enum DataType;
    if (field.type != uint32 || scaled || type == boolean || type == string) return false;
    return type != float64 && type != float32 && 16 * register_count(type) < kBitsOfACounter;
}

const ServiceField* find_service_field(std::string_view name) {
    if (!is_service_name(name)) return nullptr;
    const auto parts = parts_of(name);
    return field_of(parts.scope, parts.word);
}

ServiceNames::ServiceNames(const Project& project) : project_(project) {
    for (std::size_t l = 0; l < project.lines.size(); ++l) {
        lines_.try_emplace(project.lines[l].name, l);
        const auto& devices = project.lines[l].devices;
        for (std::size_t d = 0; d < devices.size(); ++d) {
            devices_[devices[d].name].push_back({l, d});
            addresses_.try_emplace(address_key(l, devices[d].address.value), d);
        }
    }
}

std::optional<ServiceVariable> ServiceNames::find(std::string_view name) const {
    ServiceVariable found{.field = find_service_field(name)};
    if (found.field == nullptr) return std::nullopt;
    const auto parts = parts_of(name);
    if (parts.scope == ServiceScope::line) {
        const auto known = lines_.find(parts.subject);
        if (known == lines_.end()) return std::nullopt;
        found.line = known->second;
    } else if (parts.scope == ServiceScope::device) {
        const auto known = device(parts.subject);
        if (!known) return std::nullopt;
        found.line = known->line;
        found.device = known->device;
    }
    return found;
}

std::optional<ServiceNames::Position> ServiceNames::device(std::string_view name) const {
    const auto known = devices_.find(name);
    if (known != devices_.end() && known->second.size() == 1) return known->second[0];
    return qualified_device(name);
}

/// The devices of that name on one line.
std::span<const ServiceNames::Position> ServiceNames::on_line(std::size_t line, std::string_view name) const {
    const auto known = devices_.find(name);
    if (known == devices_.end()) return {};
    return std::ranges::equal_range(known->second, line, {}, &Position::line);
}

// The names of lines and devices may have slashes too.
std::optional<ServiceNames::Position> ServiceNames::qualified_device(std::string_view name) const {
    for (auto slash = name.find('/'); slash != std::string_view::npos; slash = name.find('/', slash + 1)) {
        const auto known = lines_.find(name.substr(0, slash));
        if (known == lines_.end()) continue;
        const auto rest = name.substr(slash + 1);
        if (const auto named = on_line(known->second, rest); named.size() == 1) return named[0];
        const auto number = parse_integer(rest);
        if (!number || number->negative || number->magnitude > kGreatestAddress) continue;
        const auto found = addresses_.find(address_key(known->second, number->magnitude));
        if (found != addresses_.end()) return Position{known->second, found->second};
    }
    return std::nullopt;
}

std::string ServiceNames::shortest_name(const Position& position) const {
    const auto& of_line = project_.lines[position.line];
    const auto& each = of_line.devices[position.device];
    if (devices_.at(each.name).size() == 1) return each.name;
    const bool unique = on_line(position.line, each.name).size() == 1;
    return of_line.name + "/" + (unique ? each.name : std::to_string(each.address.value));
}

std::vector<std::string> ServiceNames::subjects(ServiceScope scope) const {
    std::vector<std::string> names;
    for (std::size_t l = 0; l < project_.lines.size(); ++l) {
        if (scope == ServiceScope::line && names.size() < kNamesToCompare)
            names.push_back(project_.lines[l].name);
        if (scope != ServiceScope::device) continue;
        for (std::size_t d = 0; d < project_.lines[l].devices.size() && names.size() < kNamesToCompare; ++d)
            names.push_back(shortest_name({l, d}));
    }
    return names;
}

ServiceHint ServiceNames::hint(std::string_view name) const {
    const auto parts = parts_of(name);
    const auto names = subjects(parts.scope);
    if (names.empty()) return program_hint(parts.word);
    const auto prefix = parts.scope == ServiceScope::line ? kLinePrefix : kDevicePrefix;
    const auto word = nearest(parts.word, service_words(parts.scope));
    if (parts.scope == ServiceScope::line ? lines_.contains(parts.subject)
                                          : device(parts.subject).has_value())
        return {service_name(prefix, parts.subject, word), listed_words(prefix, parts.subject, parts.scope)};
    std::vector<std::string> whole;
    for (const auto& subject : names | std::views::take(kNamesToList + 1))
        whole.push_back(service_name(prefix, subject, word));
    const std::vector<std::string_view> views(names.begin(), names.end());
    return {service_name(prefix, nearest(parts.subject, views), word), listed(whole)};
}

std::string ServiceNames::name(const ServiceVariable& variable) const {
    const auto word = variable.field->word;
    switch (variable.field->scope) {
        case ServiceScope::line: return service_name(kLinePrefix, project_.lines[variable.line].name, word);
        case ServiceScope::device:
            return service_name(kDevicePrefix, shortest_name({variable.line, variable.device}), word);
        case ServiceScope::program: break;
    }
    return service_name({}, {}, word);
}

const Local* service_of_lines(const Project& project) {
    const Local* first = nullptr;
    const auto note = [&](const std::optional<LocalIndex>& index) {
        if (index && first == nullptr && project.locals[*index].service) first = &project.locals[*index];
    };
    for (const auto& each : project.lines)
        for (const auto& one : each.devices) {
            note(one.poll_enable);
            for (const auto& variable : one.variables) {
                note(variable.read_trigger);
                note(variable.write_trigger);
            }
        }
    return first;
}

Local service_local(std::string name, const ServiceField& field) {
    Local local{.name = std::move(name), .type = field.type, .service = true};
    if (field.min_interval > Duration::zero())
        local.admission = RateLimit{.min_interval = field.min_interval, .burst = 1};
    return local;
}

}  // namespace takt::model
