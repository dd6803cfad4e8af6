#include "takt/table/restore.hpp"

namespace takt::table {
namespace {

std::string name_of(const View& view, std::uint32_t text, const char* kind, std::uint32_t index) {
    const auto name = view.text(text);
    return name.empty() ? kind + std::to_string(index) : std::string(name);
}

std::optional<wire::Function> function(std::uint8_t code) {
    return code == 0 ? std::nullopt : std::optional(wire::Function{code});
}

std::optional<model::LocalIndex> local(std::uint32_t item) {
    return item == kNone ? std::nullopt : std::optional<model::LocalIndex>(item);
}

std::optional<model::Constant> default_of(const View& view, const ItemRecord& item) {
    if ((item.flags & ItemRecord::kHasDefault) == 0) return std::nullopt;
    model::Constant constant{.text = std::string(view.text(item.default_text)),
                             .number = item.default_number};
    constant.integer = static_cast<std::int64_t>(item.default_raw);
    if (type_of(item) == DataType::int16) constant.integer = static_cast<std::int16_t>(item.default_raw);
    if (type_of(item) == DataType::int32) constant.integer = static_cast<std::int32_t>(item.default_raw);
    return constant;
}

std::optional<model::RateLimit> admission_of(const ItemRecord& item) {
    if (item.burst == 0) return std::nullopt;
    return model::RateLimit{Duration(item.min_interval), item.burst};
}

model::Local local_of(const View& view, const ItemRecord& item, std::uint32_t index) {
    model::Local local;
    local.name = name_of(view, item.name, "item", index);
    local.type = type_of(item);
    local.retain = (item.flags & ItemRecord::kRetain) != 0;
    local.default_value = default_of(view, item);
    local.admission = admission_of(item);
    return local;
}

model::Variable variable_of(const View& view, const ItemRecord& item, std::uint32_t index) {
    model::Variable variable;
    variable.name = name_of(view, item.name, "item", index);
    variable.type = type_of(item);
    variable.area = wire::Area{item.area};
    const bool coil = wire::is_bit_area(variable.area);
    variable.register_number = coil ? item.start / 16 : item.start;
    if (coil)
        variable.bit = static_cast<std::uint8_t>(item.start % 16);
    else if (item.bit != ItemRecord::kNoBit)
        variable.bit = item.bit;
    variable.registers = item.registers;
    variable.read = function(item.read);
    variable.write = function(item.write);
    variable.write_on_change = (item.flags & ItemRecord::kWrittenOnChange) != 0;
    variable.period = Duration(item.period);
    if (item.greatest_age > 0) variable.max_age = Duration(item.greatest_age);
    variable.read_trigger = local(item.read_trigger);
    variable.write_trigger = local(item.write_trigger);
    variable.status = local(item.status);
    variable.admission = admission_of(item);
    variable.default_value = default_of(view, item);
    variable.hold_last = (item.flags & ItemRecord::kHoldLast) != 0;
    variable.retain = (item.flags & ItemRecord::kRetain) != 0;
    variable.used = (item.flags & ItemRecord::kUsed) != 0;
    variable.order.high_byte_first = (item.flags & ItemRecord::kHighByteFirst) != 0;
    variable.order.high_register_first = (item.flags & ItemRecord::kHighRegisterFirst) != 0;
    variable.scale = item.scale;
    variable.offset = item.offset;
    variable.dead_band = item.dead_band;
    variable.verify = (item.flags & ItemRecord::kVerify) != 0;
    variable.safe_to_repeat = (item.flags & ItemRecord::kSafeToRepeat) != 0;
    variable.unit = view.text(item.unit);
    return variable;
}

model::Device device_of(const View& view, const DeviceRecord& record, std::uint32_t index) {
    model::Device device;
    device.name = name_of(view, record.name, "device", index);
    device.address = UnitId{record.unit};
    device.poll_period = Duration(record.period);
    device.response_timeout = Duration(record.response_timeout);
    device.response_timeout_set = (record.flags & DeviceRecord::kDerivedWait) == 0;
    if (record.turnaround >= 0) device.turnaround = Duration(record.turnaround);
    device.round_trip = Duration(record.round_trip);
    if (record.measured_longest > 0)
        device.measured_round_trip =
            model::MeasuredRoundTrip{.longest = Duration(record.measured_longest),
                                     .usual = device.round_trip,
                                     .exchanges = static_cast<std::uint64_t>(record.measured_exchanges),
                                     .in_flight = record.measured_in_flight};
    device.attempts = record.attempts;
    device.in_flight = record.in_flight;
    device.backoff = model::Backoff{Duration(record.backoff_first), Duration(record.backoff_limit)};
    device.order.high_byte_first = (record.flags & DeviceRecord::kHighByteFirst) != 0;
    device.order.high_register_first = (record.flags & DeviceRecord::kHighRegisterFirst) != 0;
    device.fc22 = (record.flags & DeviceRecord::kMaskWrite) != 0;
    device.fc23 = (record.flags & DeviceRecord::kReadWrite) != 0;
    device.read_modify_write = (record.flags & DeviceRecord::kReadModifyWrite) != 0;
    device.gaps = model::Gaps{record.gaps};
    device.status = local(record.status);
    device.poll_enable = local(record.poll_enable);
    return device;
}

model::Line line_of(const View& view, const LineRecord& record, std::uint32_t index) {
    model::Line line;
    line.name = name_of(view, record.name, "line", index);
    line.transport = model::Transport{record.transport};
    line.port = view.text(record.port);
    line.tcp_port = record.tcp_port;
    line.framing = wire::Framing{record.framing};
    line.format = {record.baud, record.data_bits, wire::Parity{record.parity}, record.stop_bits};
    line.rs485 = model::Rs485{record.rs485};
    line.order = model::PollOrder{record.order};
    line.commands = {Duration(record.command_interval), record.command_burst};
    line.request_gap = Duration(record.request_gap);
    line.frame_gap = Duration(record.frame_gap);
    if (record.frame_silence > 0) line.byte_timeout = Duration(record.frame_silence);
    for (std::uint32_t d = 0; d < record.device_count; ++d)
        line.devices.push_back(
            device_of(view, view.device(record.first_device + d), record.first_device + d));
    return line;
}

/// The first item of each device, and after the last device the number of items. Items of a device are
/// contiguous.
std::vector<std::uint32_t> first_items(const View& view) {
    std::vector<std::uint32_t> first(view.device_count() + std::size_t{1}, view.item_count());
    for (std::uint32_t i = view.item_count(); i-- > 0;)
        if (const auto device = view.item(i).device; device != kNone) first[device] = i;
    for (std::size_t d = view.device_count(); d-- > 0;)
        if (first[d] > first[d + 1]) first[d] = first[d + 1];
    return first;
}

plan::Request request_of(const View& view, const EntryRecord& entry, const LineRecord& line,
                         const std::vector<std::uint32_t>& first) {
    plan::Request request;
    request.device = entry.device - line.first_device;
    for (std::uint32_t m = 0; m < entry.member_count; ++m)
        request.variables.push_back(view.member(entry, m) - first[entry.device]);
    request.read = function(entry.read);
    request.write = function(entry.write);
    request.start = entry.start;
    request.quantity = entry.quantity;
    if ((entry.flags & EntryRecord::kPolled) != 0) request.period = Duration(entry.period);
    request.phase = Duration(entry.phase);
    request.stream = entry.stream;
    if ((entry.flags & EntryRecord::kHasDeadline) != 0) request.deadline = Duration(entry.deadline);
    request.read_trigger = local(entry.read_trigger);
    request.write_trigger = local(entry.write_trigger);
    request.status = local(entry.status);
    request.write_on_change = (entry.flags & EntryRecord::kWrittenOnChange) != 0;
    if ((entry.flags & EntryRecord::kHasAdmission) != 0)
        request.admission = model::RateLimit{Duration(entry.min_interval), entry.burst};
    request.write_start = entry.write_start;
    request.write_quantity = entry.write_quantity;
    request.read_modify_write = (entry.flags & EntryRecord::kReadModifyWrite) != 0;
    request.bus_time = Duration(entry.bus_time);
    request.request_bytes = entry.request_bytes;
    request.response_bytes = entry.response_bytes;
    return request;
}

}  // namespace

model::Project project_of(const View& view) {
    model::Project project;
    for (std::uint32_t l = 0; l < view.line_count(); ++l)
        project.lines.push_back(line_of(view, view.line(l), l));
    if (view.line_count() > 0) {
        project.timeout_margin = Duration(view.line(0).margin);
        project.host.overhead = Duration(view.line(0).host_overhead);
    }
    for (std::uint32_t i = 0; i < view.item_count(); ++i) {
        const auto item = view.item(i);
        if (item.device == kNone) {
            project.locals.push_back(local_of(view, item, i));
            continue;
        }
        const auto device = view.device(item.device);
        const auto own = item.device - view.line(device.line).first_device;
        project.lines[device.line].devices[own].variables.push_back(variable_of(view, item, i));
    }
    return project;
}

plan::Plan plan_of(const View& view) {
    const auto first = first_items(view);
    plan::Plan plan;
    for (std::uint32_t l = 0; l < view.line_count(); ++l) {
        const auto record = view.line(l);
        auto& line = plan.lines.emplace_back();
        line.line = l;
        for (std::uint32_t e = 0; e < record.entry_count; ++e) {
            const auto entry = view.entry(record.first_entry + e);
            line.requests.push_back(request_of(view, entry, record, first));
            if ((entry.flags & EntryRecord::kInLongestRound) != 0) line.longest_round.push_back(e);
        }
        line.request_count = record.request_count;
        line.ungrouped_requests = record.ungrouped_requests;
        line.longest_round = plan::longest_round(line.requests);
        line.cycle = Duration(record.cycle);
        line.utilization = record.utilization;
    }
    return plan;
}

}  // namespace takt::table
