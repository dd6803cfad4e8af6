#include <utility>

#include "interpretation.hpp"

namespace takt::model {
namespace {

void read_address(Interpretation& state, Reader& reader, Device& device) {
    const auto address = reader.integer("address");
    if (!address) return;
    device.address = UnitId{static_cast<std::uint8_t>(*address)};
    const auto [first, is_new] =
        state.addresses.try_emplace(device.address.value, reader.value("address")->place);
    if (!is_new)
        reader.report(Rule::address_duplicate, "address", {}, {{"first", state.describe(first->second)}});
}

void read_times(const Interpretation& state, Reader& reader, Device& device) {
    device.poll_period = reader.duration("poll_period").value_or(device.poll_period);
    device.response_timeout = reader.duration("response_timeout").value_or(device.response_timeout);
    device.turnaround = reader.duration("turnaround");
    device.round_trip = reader.duration("round_trip").value_or(device.round_trip);
    device.attempts = static_cast<std::uint16_t>(reader.integer("attempts").value_or(device.attempts));
    if (state.context.transport == Transport::serial && reader.given("round_trip"))
        reader.report_without_effect("round_trip", "transport: serial");
}

/// A strategy that groups switches grouping on by itself; written beside `group_requests: false` it loses.
/// @returns whether what stands there was understood; else nothing can be said about what goes with it
bool read_strategy(Reader& reader, Device& device) {
    const auto grouping = reader.boolean("group_requests");
    const auto strategy = reader.choice<Strategy>("strategy");
    const bool wants_groups = strategy && *strategy != Strategy::single;
    device.group_requests = grouping.value_or(wants_groups);
    if (!device.group_requests)
        device.strategy = Strategy::single;
    else
        device.strategy = strategy.value_or(Strategy::classic);
    if (wants_groups && !device.group_requests) reader.report(Rule::strategy_grouping_off, "strategy");
    if (device.strategy == Strategy::optimal) reader.report(Rule::strategy_not_available, "strategy");
    return grouping.has_value() == reader.given("group_requests") &&
           strategy.has_value() == reader.given("strategy");
}

void read_grouping(Reader& reader, Device& device) {
    const bool understood = read_strategy(reader, device);
    if (const auto registers = reader.integer("registers_per_request"))
        device.registers_per_request = static_cast<std::uint16_t>(*registers);
    device.registers_per_request_set = reader.given("registers_per_request");
    device.gaps = reader.choice<Gaps>("gaps").value_or(device.gaps);
    const std::string strategy = "strategy: " + std::string(name(device.strategy));
    if (understood && device.registers_per_request_set && device.strategy == Strategy::single)
        reader.report_without_effect("registers_per_request",
                                     device.group_requests ? strategy : "group_requests: false");
    if (understood && device.gaps != Gaps::never && device.strategy != Strategy::optimal)
        reader.report_without_effect("gaps", strategy);
}

void interpret_variables(Interpretation& state, Reader& reader, Device& device) {
    const Node* const list = reader.list("variables");
    if (list == nullptr) return;
    device.variables.reserve(list->items.size());
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = reader.path_of("variables") + "[" + std::to_string(i) + "]";
        device.variables.push_back(
            is_mapping(state, item, path) ? interpret_variable(state, device, item, path) : Variable{});
    }
}

}  // namespace

Device interpret_device(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::device, state.context);
    Device device;
    device.place = node.place;
    device.name = reader.text("name").value_or("");
    device.comment = reader.text("comment").value_or("");
    read_address(state, reader, device);
    read_times(state, reader, device);
    read_grouping(reader, device);
    device.order.high_byte_first = reader.boolean("high_byte_first").value_or(device.order.high_byte_first);
    device.order.high_register_first =
        reader.boolean("high_register_first").value_or(device.order.high_register_first);
    device.poll_enable = read_local(state, reader, "poll_enable");
    device.status = read_local(state, reader, "status");
    interpret_variables(state, reader, device);
    return device;
}

}  // namespace takt::model
