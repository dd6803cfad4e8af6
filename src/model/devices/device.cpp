#include <algorithm>
#include <utility>

#include "devices/addressing.hpp"
#include "reading/field_ranges.hpp"
#include "servers/interpretation.hpp"
#include "takt/model/item_ranges.hpp"

namespace takt::model {
namespace {

bool is_zero(const Node* node) {
    if (node == nullptr || node->kind != Node::Kind::scalar || node->quoted) return false;
    const auto number = parse_integer(node->text);
    return number && number->magnitude == 0;
}

bool only_writes(const Node& variable) {
    const Node* const read = variable.find("read");
    const Node* const write = variable.find("write");
    const bool reads = read == nullptr ? write == nullptr : read->text != "none";
    return !reads && write != nullptr && write->text != "none";
}

/// On lines without transaction ids unit 0 is the broadcast address: it is written to and never answers
/// (docs/specification.md, section 8). A device that is read cannot have it.
bool is_broadcast(const Interpretation& state, const Reader& reader) {
    if (state.context.framing == wire::Framing::tcp || !is_zero(reader.node().find("address"))) return false;
    const Node* const variables = reader.node().find("variables");
    return variables != nullptr && variables->kind == Node::Kind::list && !variables->items.empty() &&
           std::ranges::all_of(variables->items, only_writes);
}

std::optional<std::int64_t> address_of(const Interpretation& state, Reader& reader) {
    if (is_broadcast(state, reader)) return 0;
    const auto address = reader.integer("address");
    const bool stream = !state.context.is_serial() && state.context.framing != wire::Framing::tcp;
    if (address != 0 || !stream) return address;
    reader.report(Rule::field_out_of_range, "address", "1..255");
    return std::nullopt;
}

void read_address(Interpretation& state, Reader& reader, Device& device) {
    const auto address = address_of(state, reader);
    if (!address) return;
    device.address = UnitId{static_cast<std::uint8_t>(*address)};
    const auto [first, is_new] = state.addresses.try_emplace(device.address.value, reader, "address");
    if (!is_new)
        reader.report(Rule::address_duplicate, "address", {}, {{"first", state.describe(first->second)}});
}

/// The pause after a request without an answer, so that the controller asks a silent device once each period.
/// The tenth of the period leaves the line to the others where the time-out is as long as the period.
Backoff once_each_period(const Project& project, const Device& device) {
    constexpr Duration kLeast = std::chrono::milliseconds(1);
    const Duration rest = device.poll_period - device.response_timeout - project.timeout_margin;
    const Duration pause = std::max({rest, device.poll_period / 10, kLeast});
    return {.first = pause, .limit = pause};
}

/// A time, or a group of what was measured.
void read_round_trip(Interpretation& state, Reader& reader, Device& device) {
    if (!reader.is_mapping("round_trip")) {
        device.round_trip = reader.duration("round_trip").value_or(device.round_trip);
        return;
    }
    Reader parts(state.findings, *reader.value("round_trip"), reader.path_of("round_trip"),
                 Object::round_trip, state.context);
    const auto longest = parts.duration("longest");
    const auto exchanges = parts.integer("exchanges");
    const auto usual = parts.duration("usual");
    const auto in_flight = parts.integer("in_flight");
    if (longest && usual && *usual > *longest)
        parts.report(Rule::round_trip_usual, "usual", "<= " + to_text(*longest),
                     {{"longest", to_text(*longest)}});
    if (!longest || !exchanges) return;
    device.measured_round_trip =
        MeasuredRoundTrip{.longest = *longest,
                          .usual = std::min(usual.value_or(*longest), *longest),
                          .exchanges = static_cast<std::uint64_t>(*exchanges),
                          .in_flight = static_cast<std::uint16_t>(in_flight.value_or(1))};
    device.round_trip = device.measured_round_trip->usual;
}

void read_times(Interpretation& state, Reader& reader, Device& device) {
    const DeviceDefaults defaults = device_defaults(state.context.profile);
    device.poll_period = reader.duration("poll_period").value_or(defaults.poll_period);
    device.response_timeout = reader.duration("response_timeout").value_or(defaults.response_timeout);
    device.response_timeout_set = reader.given("response_timeout");
    device.turnaround = reader.duration("turnaround");
    if (device.response_timeout_set && device.turnaround && device.response_timeout < *device.turnaround)
        reader.report(Rule::device_timeout_short, "response_timeout", {},
                      {{"turnaround", to_text(*device.turnaround)}});
    device.learn_turnaround = reader.word_instead("turnaround");
    if (device.learn_turnaround && state.context.profile == Profile::owen_kc1) {
        reader.report_without_effect("turnaround", "profile: owen-kc1");
        device.learn_turnaround = false;
    }
    read_round_trip(state, reader, device);
    device.attempts = static_cast<std::uint16_t>(reader.integer("attempts").value_or(device.attempts));
    device.backoff = read_backoff(state, reader, state.project.backoff);
    if (!device.backoff && !state.backoff_given && state.context.profile == Profile::owen_kc1)
        device.backoff = once_each_period(state.project, device);
    state.deadline = reader.duration("deadline");
    if (state.context.transport == Transport::serial && reader.given("round_trip"))
        reader.report_without_effect("round_trip", "transport: serial");
}

/// Several requests in flight need frames with a transaction id.
void read_in_flight(const Interpretation& state, Reader& reader, Device& device) {
    const auto in_flight = reader.integer("in_flight");
    if (state.context.framing == wire::Framing::tcp) {
        device.in_flight = static_cast<std::uint16_t>(in_flight.value_or(device.in_flight));
    } else if (in_flight > 1) {
        const bool serial = state.context.transport == Transport::serial;
        const auto framing = kFramings[static_cast<std::size_t>(state.context.framing)];
        reader.report_without_effect("in_flight",
                                     serial ? "transport: serial" : "framing: " + std::string(framing));
    }
}

/// Behind a gateway a response waits for those to the requests before it: no turnaround is measured.
void check_learnt_turnaround(Reader& reader, Device& device) {
    if (!device.learn_turnaround || device.in_flight <= 1) return;
    reader.report_without_effect("turnaround", "in_flight: " + std::to_string(device.in_flight));
    device.learn_turnaround = false;
}

/// A written strategy implies group_requests, unless the project sets that too.
/// @returns whether the value was valid; else dependent keys are not checked
bool read_strategy(Reader& reader, Profile profile, Device& device) {
    const auto grouping = reader.boolean("group_requests");
    const auto strategy = reader.choice<Strategy>("strategy");
    const bool wants_groups = strategy && *strategy != Strategy::single;
    const DeviceDefaults defaults = device_defaults(profile);
    device.group_requests = grouping.value_or(strategy ? wants_groups : defaults.group_requests);
    device.strategy = device.group_requests ? strategy.value_or(defaults.strategy) : Strategy::single;
    if (wants_groups && !device.group_requests) reader.report(Rule::strategy_grouping_off, "strategy");
    return grouping.has_value() == reader.given("group_requests") &&
           strategy.has_value() == reader.given("strategy");
}

/// Readable ranges imply gaps: always for their areas. An area without ranges implies nothing.
void read_gaps(Interpretation& state, Reader& reader, Device& device) {
    const auto gaps = reader.choice<Gaps>("gaps");
    device.readable = read_ranges(state, reader, "readable");
    device.no_read = read_ranges(state, reader, "no_read");
    device.gaps = gaps.value_or(Gaps::never);
    if (reader.given("gaps") || !reader.given("readable")) return;
    device.gaps = Gaps::always;
    for (std::size_t area = 0; area < device.readable.size(); ++area)
        if (device.readable[area].empty()) device.no_read[area] = {{.first = 0, .last = 65535}};
}

void read_writing(Reader& reader, Device& device) {
    if (const auto word = reader.word("write_single")) {
        const auto index = std::ranges::find(kWriteSingle, *word) - kWriteSingle.begin();
        device.write_single = static_cast<WriteSingle>(index + 1);  // as_declared has no word
    }
    device.fc22 = reader.boolean("fc22").value_or(false);
    device.fc23 = reader.boolean("fc23").value_or(false);
    device.read_modify_write = reader.boolean("read_modify_write").value_or(false);
}

void read_grouping(Interpretation& state, Reader& reader, Device& device) {
    const bool understood = read_strategy(reader, state.context.profile, device);
    if (const auto registers = reader.integer("registers_per_request"))
        device.registers_per_request = static_cast<std::uint16_t>(*registers);
    device.registers_per_request_set = reader.given("registers_per_request");
    read_gaps(state, reader, device);
    read_writing(reader, device);
    const std::string strategy = "strategy: " + std::string(name(device.strategy));
    // The window of a device shows the limit also where its requests are not grouped.
    if (understood && device.registers_per_request_set && device.strategy == Strategy::single &&
        !reader.given("group_requests"))
        reader.report_without_effect("registers_per_request", strategy);
    if (!understood || device.strategy == Strategy::optimal) return;
    if (reader.given("gaps") && device.gaps != Gaps::never) reader.report_without_effect("gaps", strategy);
    for (const std::string_view key : {"readable", "no_read", "write_single"})
        if (reader.given(key)) reader.report_without_effect(key, strategy);
    if (device.fc23) reader.report_without_effect("fc23", strategy);
}

std::string text_of(const ItemRange& range) {
    const auto first = std::to_string(range.first);
    return range.first == range.last ? first : first + ".." + std::to_string(range.last);
}

/// Variables outside the ranges that the device has. `offers` with the names of areas names all of them.
void check_offers(Interpretation& state, Reader& reader, const Device& device) {
    constexpr std::uint32_t kLast = 65535;
    const AreaRanges offers = read_ranges(state, reader, "offers");
    for (const Variable& variable : device.variables) {
        const auto area = static_cast<std::size_t>(variable.area);
        const std::uint32_t last =
            std::min(variable.start() + std::max<std::uint32_t>(variable.items(), 1) - 1, kLast);
        const ItemRange items{variable.start(), static_cast<std::uint16_t>(last)};
        if (holds(offers[area], items)) continue;
        const auto* const areas = reader.is_mapping("offers") ? reader.value("offers") : nullptr;
        if (areas != nullptr && areas->find(kAreas[area]) == nullptr)
            state.findings.add(Rule::variable_area_not_offered, variable.location,
                               reader.path_of("variables"), text_of(items), {},
                               {{"area", std::string(kAreas[area])}, {"variable", variable.name}});
        if (offers[area].empty()) continue;
        std::string allowed;
        for (const ItemRange& range : offers[area]) allowed += (allowed.empty() ? "" : ", ") + text_of(range);
        state.findings.add(Rule::variable_not_offered, variable.location, reader.path_of("variables"),
                           text_of(items), std::move(allowed),
                           {{"area", std::string(kAreas[area])}, {"variable", variable.name}});
    }
}

/// A request that only writes with 0x10 carries less than one that reads. Both are cut to what their frame
/// carries.
void check_written_registers(const Interpretation& state, Reader& reader, const Device& device) {
    const auto limit = most_written_registers(state.context);
    const bool read_cut = device.registers_per_request > registers_per_request(state.context).greatest;
    if (!device.registers_per_request_set || device.strategy == Strategy::single || read_cut ||
        device.registers_per_request <= limit)
        return;
    std::int64_t registers = 0;
    for (const auto& variable : device.variables)
        if (variable.used && !variable.read && (variable.write_on_change || variable.write_trigger) &&
            variable.write == wire::Function::write_multiple_registers)
            registers += variable.registers;
    if (registers > limit)
        reader.report(Rule::device_registers_cut, "registers_per_request",
                      reader.allowed_text("registers_per_request"),
                      {{"limit", std::to_string(registers_per_request(state.context).greatest)},
                       {"written", std::to_string(limit)}});
}

void interpret_polled_variables(Interpretation& state, Reader& reader, Device& device) {
    const Node* const list = reader.list("variables");
    if (list == nullptr) return;
    device.variables.reserve(list->items.size());
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("variables") + "[" + std::to_string(i) + "]";
        device.variables.push_back(
            is_mapping(state, item, path) ? interpret_variable(state, device, item, path) : Variable{});
    }
    report_like_references(state);
}

}  // namespace

void check_notation(Reader& reader) {
    if (!reader.choice<std::size_t>("notation")) return;
    const Node* const variables = reader.value("variables");
    if (variables == nullptr || variables->location.file == reader.node().location.file)
        reader.report_without_effect("notation", "variables: [...]");
}

/// Templates are applied where the project is read (module file). What is left of them is not understood.
void check_template(Reader& reader) {
    reader.text("device_template");
    if (reader.mapping("parameters") != nullptr && !reader.given("device_template"))
        reader.report_without_effect("parameters", "device_template: –");
}

Device interpret_device(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::device, state.context);
    Device device;
    device.location = node.location;
    device.name = reader.text("name").value_or("");
    device.comment = reader.text("comment").value_or("");
    read_address(state, reader, device);
    read_times(state, reader, device);
    read_in_flight(state, reader, device);
    check_learnt_turnaround(reader, device);
    read_grouping(state, reader, device);
    if (device.address == kBroadcast && state.context.framing != wire::Framing::tcp)
        for (auto* const setting : {&device.read_modify_write, &device.fc23})
            if (std::exchange(*setting, false))
                reader.report_without_effect(setting == &device.fc23 ? "fc23" : "read_modify_write",
                                             "address: 0");
    check_notation(reader);
    check_template(reader);
    device.order = read_byte_order(reader, device.order, {});
    device.poll_enable = read_local(state, reader, "poll_enable");
    device.status = read_local(state, reader, "status");
    interpret_polled_variables(state, reader, device);
    check_written_registers(state, reader, device);
    check_offers(state, reader, device);
    return device;
}

}  // namespace takt::model
