// Collects records in lists, and writes the lists one after the other behind the header.
#include "takt/table/build.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>

#include "takt/model/service.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/request_job.hpp"
#include "takt/table/bytes.hpp"
#include "takt/table/format.hpp"
#include "takt/table/view.hpp"

namespace takt::table {
namespace {

/// The text section: each text once, as its length in 16 bits and its bytes.
class Texts {
public:
    std::uint32_t add(const std::string& text) {
        if (text.empty()) return kNone;
        const auto [known, is_new] = known_.try_emplace(text, static_cast<std::uint32_t>(bytes_.size()));
        if (is_new) {
            const auto length = static_cast<std::uint16_t>(std::min<std::size_t>(text.size(), 0xFFFF));
            Put{bytes_}(length);
            bytes_.insert(bytes_.end(), text.begin(), text.begin() + length);
        }
        return known->second;
    }
    [[nodiscard]] const Image& bytes() const { return bytes_; }

private:
    Image bytes_;
    std::unordered_map<std::string, std::uint32_t> known_;
};

// The plan does not multiply a turnaround that was learnt, so it counts as measured with as many in flight.
void add_measured(DeviceRecord& record, const model::Device& device) {
    const auto learnt = device.measured_turnaround();
    if (!device.measured_round_trip && !learnt) return;
    const auto measured = device.measured_round_trip.value_or(
        model::MeasuredRoundTrip{.longest = learnt.value_or(Duration::zero()),
                                 .usual = {},
                                 .exchanges = device.times.measured.exchanges,
                                 .in_flight = 1});
    record.measured_longest = measured.longest.count();
    record.measured_exchanges = static_cast<std::int64_t>(
        std::min<std::uint64_t>(measured.exchanges, std::numeric_limits<std::int64_t>::max()));
    record.measured_in_flight = measured.in_flight;
}

template <class T>
std::uint32_t local_or_none(const std::optional<T>& local) {
    return local ? static_cast<std::uint32_t>(*local) : kNone;
}

std::uint8_t function_or_0(const std::optional<wire::Function>& function) {
    return function ? static_cast<std::uint8_t>(*function) : std::uint8_t{0};
}

template <class Flag>
void set_flag(Flag& flags, Flag flag, bool on) {
    if (on) flags = static_cast<Flag>(flags | flag);
}

std::uint64_t raw_number(DataType type, double number) {
    if (type == DataType::float32) return std::bit_cast<std::uint32_t>(static_cast<float>(number));
    if (type == DataType::float64) return std::bit_cast<std::uint64_t>(number);
    const double whole = std::clamp(std::round(number), -9.2e18, 9.2e18);
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(whole));
}

std::uint64_t default_raw(DataType type, double scale, double offset, const model::Constant& constant) {
    const bool scaled = scale != 1 || offset != 0;
    const bool floating = type == DataType::float32 || type == DataType::float64;
    if (type == DataType::string) return 0;
    const std::uint64_t raw =
        scaled || floating ? raw_number(type, scaled ? (constant.number - offset) / scale : constant.number)
                           : static_cast<std::uint64_t>(constant.integer);
    const int bits = 16 * register_count(type);
    return bits == 64 ? raw : raw & ((std::uint64_t{1} << bits) - 1);
}

class Builder {
public:
    Builder(const model::Project& project, const plan::Plan& plan, const BuildOptions& options)
        : project_(project), plan_(plan), options_(options) {}

    Result<Image> build() {
        // They follow the other locals, whose numbers stay.
        if (const auto* const service = model::service_of_lines(project_))
            return fail(Code::unsupported, service->name);
        for (const auto& local : project_.locals)
            if (!local.service) add_local(local);
        for (std::size_t i = 0; i < plan_.lines.size(); ++i) TAKT_CHECK(add_line(i));
        return lay_out();
    }

private:
    void add_local(const model::Local& local);
    Result<void> add_line(std::size_t index);
    void add_device(const model::Device& device, std::size_t line, const plan::LinePlan& plan);
    void add_variable(const model::Variable& variable, const std::optional<Duration>& proved_age);
    Result<void> add_entry(const plan::Request& request, const LineRecord& line);
    void set_default(ItemRecord& item, const std::optional<model::Constant>& constant);
    void place(ItemRecord& item);
    std::uint32_t name(const std::string& text) { return options_.names ? texts_.add(text) : kNone; }
    Result<Image> lay_out();

    const model::Project& project_;
    const plan::Plan& plan_;
    const BuildOptions& options_;
    Header header_;
    Texts texts_;
    std::vector<LineRecord> lines_;
    std::vector<DeviceRecord> devices_;
    std::vector<EntryRecord> entries_;
    std::vector<std::uint32_t> members_;
    std::vector<ItemRecord> items_;
    std::vector<std::uint32_t> first_item_;  // of each device
};

void Builder::place(ItemRecord& item) {
    item.place = header_.value_words;
    header_.value_words += words_of(item);
    if (item.write == 0) return;
    item.write_place = header_.write_words;
    header_.write_words += words_of(item);
}

void Builder::set_default(ItemRecord& item, const std::optional<model::Constant>& constant) {
    if (!constant) return;
    set_flag(item.flags, ItemRecord::kHasDefault, true);
    item.default_number = constant->number;
    item.default_raw = default_raw(type_of(item), item.scale, item.offset, *constant);
    item.default_text = texts_.add(constant->text);
}

void set_admission(ItemRecord& item, const std::optional<model::RateLimit>& admission) {
    if (!admission) return;
    item.min_interval = admission->min_interval.count();
    item.burst = admission->burst;
}

void Builder::add_local(const model::Local& local) {
    ItemRecord item;
    item.type = static_cast<std::uint8_t>(local.type);
    item.area = static_cast<std::uint8_t>(wire::Area::holding_register);
    item.registers = static_cast<std::uint16_t>(register_count(local.type, 125));
    item.flags = ItemRecord::kUsed | ItemRecord::kHighByteFirst;
    set_flag(item.flags, ItemRecord::kRetain, local.retain);
    set_admission(item, local.admission);
    set_default(item, local.default_value);
    item.name = name(local.name);
    place(item);
    items_.push_back(item);
}

void Builder::add_variable(const model::Variable& variable, const std::optional<Duration>& proved_age) {
    ItemRecord item;
    item.device = static_cast<std::uint32_t>(devices_.size());
    item.type = static_cast<std::uint8_t>(variable.type);
    item.area = static_cast<std::uint8_t>(variable.area);
    item.bit = variable.bit.value_or(ItemRecord::kNoBit);
    item.read = function_or_0(variable.read);
    item.write = function_or_0(variable.write);
    item.start = variable.start();
    item.registers = static_cast<std::uint16_t>(register_count(variable.type, variable.registers));
    set_flag(item.flags, ItemRecord::kHighByteFirst, variable.order.high_byte_first);
    set_flag(item.flags, ItemRecord::kHighRegisterFirst, variable.order.high_register_first);
    set_flag(item.flags, ItemRecord::kUsed, variable.used);
    set_flag(item.flags, ItemRecord::kHoldLast, variable.hold_last);
    set_flag(item.flags, ItemRecord::kRetain, variable.retain);
    set_flag(item.flags, ItemRecord::kSafeToRepeat, variable.safe_to_repeat);
    set_flag(item.flags, ItemRecord::kWrittenOnChange, variable.write_on_change);
    set_flag(item.flags, ItemRecord::kVerify, variable.verify);
    item.period = variable.period.count();
    item.greatest_age = (proved_age ? proved_age : variable.max_age).value_or(Duration::zero()).count();
    set_admission(item, variable.admission);
    item.read_trigger = local_or_none(variable.read_trigger);
    item.write_trigger = local_or_none(variable.write_trigger);
    item.status = local_or_none(variable.status);
    item.scale = variable.scale;
    item.offset = variable.offset;
    item.dead_band = variable.dead_band;
    set_default(item, variable.default_value);
    item.name = name(variable.name);
    item.unit = name(variable.unit);
    place(item);
    items_.push_back(item);
}

void Builder::add_device(const model::Device& device, std::size_t line, const plan::LinePlan& plan) {
    DeviceRecord record;
    const auto own = devices_.size() - lines_[line].first_device;
    const auto is_own = [&](const plan::Request& request) { return request.device == own; };
    const auto first = std::find_if(plan.requests.begin(), plan.requests.end(), is_own);
    record.line = static_cast<std::uint32_t>(line);
    record.unit = device.address.value;
    set_flag(record.flags, DeviceRecord::kHighByteFirst, device.order.high_byte_first);
    set_flag(record.flags, DeviceRecord::kHighRegisterFirst, device.order.high_register_first);
    set_flag(record.flags, DeviceRecord::kMaskWrite, device.fc22);
    set_flag(record.flags, DeviceRecord::kReadWrite, device.fc23);
    set_flag(record.flags, DeviceRecord::kReadModifyWrite, device.read_modify_write);
    set_flag(record.flags, DeviceRecord::kDerivedWait,
             project_.derive_timeouts && !device.response_timeout_set);
    record.gaps = static_cast<std::uint8_t>(device.gaps);
    record.attempts = device.attempts;
    record.in_flight = device.in_flight;
    record.period = device.poll_period.count();
    record.response_timeout = device.response_timeout.count();
    record.wait = plan::answer_wait(project_, project_.lines[plan.line], device).count();
    if (device.turnaround) record.turnaround = device.turnaround->count();
    record.round_trip = device.round_trip.count();
    add_measured(record, device);
    const auto& backoff = plan::backoff_of(project_, device);
    record.backoff_first = backoff.first.count();
    record.backoff_limit = backoff.limit.count();
    record.status = local_or_none(device.status);
    record.poll_enable = local_or_none(device.poll_enable);
    record.first_entry = lines_[line].first_entry + static_cast<std::uint32_t>(first - plan.requests.begin());
    record.entry_count = static_cast<std::uint32_t>(std::count_if(first, plan.requests.end(), is_own));
    record.name = name(device.name);
    first_item_.push_back(static_cast<std::uint32_t>(items_.size()));
    for (std::size_t v = 0; v < device.variables.size(); ++v)
        add_variable(device.variables[v], plan.ages.empty() ? std::nullopt : plan.ages[own][v]);
    devices_.push_back(record);
}

Result<void> Builder::add_line(std::size_t index) {
    const auto& plan = plan_.lines[index];
    const auto& line = project_.lines[plan.line];
    const auto& bus = options_.lines.at(index);
    LineRecord record;
    record.transport = static_cast<std::uint8_t>(line.transport);
    record.framing = static_cast<std::uint8_t>(bus.framing);
    record.order = static_cast<std::uint8_t>(line.order);
    record.rs485 = static_cast<std::uint8_t>(line.rs485);
    record.parity = static_cast<std::uint8_t>(bus.format.parity);
    record.data_bits = bus.format.data_bits;
    record.stop_bits = bus.format.stop_bits;
    record.echo = static_cast<std::uint8_t>(bus.echo);
    record.baud = bus.format.baud;
    record.tcp_port = line.tcp_port;
    record.in_flight = static_cast<std::uint16_t>(bus.in_flight);
    record.command_burst = line.commands.burst;
    record.command_interval = line.commands.min_interval.count();
    record.frame_gap = bus.frame_gap.count();
    record.request_gap = bus.request_gap.count();
    record.margin = bus.margin.count();
    record.host_overhead = project_.host.overhead.count();
    record.broadcast_turnaround = bus.broadcast_turnaround.count();
    record.frame_silence = bus.frame_silence.count();
    record.first_device = static_cast<std::uint32_t>(devices_.size());
    record.device_count = static_cast<std::uint32_t>(line.devices.size());
    record.first_entry = static_cast<std::uint32_t>(entries_.size());
    record.entry_count = static_cast<std::uint32_t>(plan.requests.size());
    record.name = name(line.name);
    record.port = name(line.port);
    record.request_count = static_cast<std::uint32_t>(plan.request_count);
    record.ungrouped_requests = static_cast<std::uint32_t>(plan.ungrouped_requests);
    record.cycle = plan.cycle.count();
    record.utilization = plan.utilization;
    lines_.push_back(record);
    for (const auto& device : line.devices) add_device(device, index, plan);
    for (const auto& request : plan.requests) TAKT_CHECK(add_entry(request, record));
    for (const auto request : plan.longest_round) {
        auto& flags = entries_[record.first_entry + request].flags;
        set_flag(flags, EntryRecord::kInLongestRound, true);
    }
    return {};
}

Result<void> Builder::add_entry(const plan::Request& request, const LineRecord& line) {
    const auto device = line.first_device + static_cast<std::uint32_t>(request.device);
    const auto& model = project_.lines[devices_[device].line].devices[request.device];
    const auto index = static_cast<std::uint32_t>(entries_.size());
    if (index - devices_[device].first_entry >= devices_[device].entry_count)
        return fail(Code::unsupported, model.name);
    EntryRecord entry;
    entry.device = device;
    entry.read = function_or_0(request.read);
    entry.write = function_or_0(request.write);
    set_flag(entry.flags, EntryRecord::kPolled, request.period.has_value());
    set_flag(entry.flags, EntryRecord::kWrittenOnChange, request.write_on_change);
    set_flag(entry.flags, EntryRecord::kReadModifyWrite, request.read_modify_write);
    set_flag(entry.flags, EntryRecord::kHasDeadline, request.deadline.has_value());
    set_flag(entry.flags, EntryRecord::kHasAdmission, request.admission.has_value());
    entry.start = request.start;
    entry.quantity = request.quantity;
    entry.write_start = request.write_start;
    entry.write_quantity = request.write_quantity;
    entry.period = request.period.value_or(Duration::zero()).count();
    entry.phase = request.phase.count();
    entry.deadline = plan::polling_deadline(request).count();
    entry.stream = static_cast<std::uint32_t>(request.stream);
    entry.read_trigger = local_or_none(request.read_trigger);
    entry.write_trigger = local_or_none(request.write_trigger);
    entry.status = local_or_none(request.status);
    const auto admission = request.admission.value_or(model::RateLimit{});
    entry.min_interval = admission.min_interval.count();
    entry.burst = admission.burst;
    entry.first_member = static_cast<std::uint32_t>(members_.size());
    entry.member_count = static_cast<std::uint32_t>(request.variables.size());
    entry.request_bytes = static_cast<std::uint16_t>(request.request_bytes);
    entry.response_bytes = static_cast<std::uint16_t>(request.response_bytes);
    entry.bus_time = request.bus_time.count();
    for (const auto variable : request.variables)
        members_.push_back(first_item_[device] + static_cast<std::uint32_t>(variable));
    entries_.push_back(entry);
    return {};
}

template <class Record>
Section append(Image& image, std::vector<Record>& records) {
    const Section section{static_cast<std::uint32_t>(image.size()),
                          static_cast<std::uint32_t>(records.size())};
    Put put(image);
    for (auto& record : records) code(put, record);
    return section;
}

Result<Image> Builder::lay_out() {
    const std::size_t length = kHeaderSize + lines_.size() * record_size<LineRecord>() +
                               devices_.size() * record_size<DeviceRecord>() +
                               entries_.size() * record_size<EntryRecord>() + members_.size() * 4 +
                               items_.size() * record_size<ItemRecord>() + texts_.bytes().size();
    if (length > kMaxImage)
        return fail(Code::too_long, static_cast<std::int64_t>(length), static_cast<std::int64_t>(kMaxImage));
    Image image(kHeaderSize);
    image.reserve(length);
    header_.header_size = static_cast<std::uint16_t>(kHeaderSize);
    header_.lines = append(image, lines_);
    header_.devices = append(image, devices_);
    header_.entries = append(image, entries_);
    header_.members = append(image, members_);
    header_.items = append(image, items_);
    header_.texts = {static_cast<std::uint32_t>(image.size()),
                     static_cast<std::uint32_t>(texts_.bytes().size())};
    image.insert(image.end(), texts_.bytes().begin(), texts_.bytes().end());
    Image head(kMagic, kMagic + kMagicSize);
    Put put(head);
    code(put, header_);
    std::copy(head.begin(), head.end(), image.begin());
    seal(image);
    return image;
}

}  // namespace

Result<Image> build(const model::Project& project, const plan::Plan& plan, const BuildOptions& options) {
    TAKT_TRY(Image image, Builder(project, plan, options).build());
    if (const auto view = View::open(image); !view) return std::unexpected(view.error());
    return image;
}

}  // namespace takt::table
