// An entry holds one request. Its variables have no records of their own: they are `quantity` adjacent items
// of one type, from register `start` on, and their values are in adjacent places of the value buffer, from
// `data` on. check_neighbours() therefore rejects a request whose variables are not adjacent in both.
#include "takt/table/owen.hpp"

#include <algorithm>
#include <array>
#include <chrono>

#include "takt/base/ascii.hpp"
#include "takt/model/service.hpp"
#include "takt/table/bytes.hpp"
#include "takt/table/format.hpp"
#include "takt/table/restore.hpp"

namespace takt::table {
namespace {

using namespace std::chrono_literals;

constexpr std::array<std::string_view, 14> kCodes{
    "table.type",          "table.mixed_types", "table.function",          "table.gap",
    "table.two_registers", "table.phase",       "table.byte_order",        "table.scale",
    "table.period",        "table.place",       "table.read_modify_write", "table.admission",
    "table.too_large",     "table.not_written"};

constexpr std::int64_t kLongestMs = 65535;
constexpr std::size_t kMost = 0xFFFF;

// The first type of a kind stands for all of them where only the entry is known.
constexpr std::array<std::pair<DataType, std::uint8_t>, 6> kKinds{{
    {DataType::boolean, OwenEntry::kBit},
    {DataType::int16, OwenEntry::kWord},
    {DataType::uint16, OwenEntry::kWord},
    {DataType::int32, OwenEntry::kDoubleWord},
    {DataType::uint32, OwenEntry::kDoubleWord},
    {DataType::float32, OwenEntry::kDoubleWord},
}};

std::optional<std::uint8_t> kind_of(DataType type) {
    const auto* const found = std::ranges::find(kKinds, type, &std::pair<DataType, std::uint8_t>::first);
    return found == kKinds.end() ? std::nullopt : std::optional(found->second);
}

/// Whole milliseconds a 16-bit field can hold.
std::optional<std::uint16_t> milliseconds(Duration time) {
    if (time < 0ms || time > std::chrono::milliseconds(kLongestMs) || time % 1ms != 0ns) return std::nullopt;
    return static_cast<std::uint16_t>(time / 1ms);
}

std::string hex(std::uint8_t function) {
    return {'0', 'x', hex_digit(function >> 4U), hex_digit(function)};
}

class OwenBuilder {
public:
    OwenBuilder(const model::Project& project, const plan::Plan& plan) : project_(project), plan_(plan) {}

    OwenBuilt build() {
        next_place_ =
            1 + static_cast<std::size_t>(std::ranges::count(project_.locals, false, &model::Local::service));
        if (const auto* const service = model::service_of_lines(project_))
            built_.findings.push_back({.code = "table.service",
                                       .location = service->location,
                                       .arguments = {{"name", service->name}}});
        for (std::size_t i = 0; i < plan_.lines.size(); ++i) add_line(i);
        if (next_place_ > kMost || built_.table.entries.size() > kMost)
            built_.findings.push_back({.code = "table.too_large",
                                       .arguments = {{"places", std::to_string(next_place_ - 1)},
                                                     {"entries", std::to_string(built_.table.entries.size())},
                                                     {"limit", std::to_string(kMost)}}});
        built_.table.places = static_cast<std::uint16_t>(next_place_ - 1);
        return std::move(built_);
    }

private:
    using Variables = std::vector<const model::Variable*>;

    void add_line(std::size_t index);
    void add_device(const plan::LinePlan& plan, std::size_t index);
    void add_entry(const model::Device& device, const plan::Request& request);
    void report_unwritten(const plan::LinePlan& plan, std::size_t index);
    void check_variable(const model::Device& device, const model::Variable& variable);
    void check_request(const plan::Request& request, const Variables& members);
    void check_neighbours(const model::Variable& a, const model::Variable& b, std::size_t place_a,
                          std::size_t place_b);
    void refuse(const char* code, const model::Variable& variable,
                std::vector<std::pair<std::string, std::string>> arguments = {});
    std::size_t place_of(const model::Variable& variable);
    static Place local(const std::optional<model::LocalIndex>& index) {
        return index ? static_cast<Place>(*index + 1) : Place{0};
    }

    const model::Project& project_;
    const plan::Plan& plan_;
    OwenBuilt built_;
    std::size_t next_place_ = 1;
    const model::Device* device_ = nullptr;
    std::vector<std::size_t> places_;  // of the variables of device_
};

void OwenBuilder::refuse(const char* code, const model::Variable& variable,
                         std::vector<std::pair<std::string, std::string>> arguments) {
    arguments.emplace_back("name", variable.name);
    built_.findings.push_back({.severity = model::Severity::error,
                               .code = code,
                               .location = variable.location,
                               .path = variable.name,
                               .arguments = std::move(arguments)});
}

std::size_t OwenBuilder::place_of(const model::Variable& variable) {
    auto& place = places_[static_cast<std::size_t>(&variable - device_->variables.data())];
    if (place == 0) place = next_place_++;
    return place;
}

void OwenBuilder::add_line(std::size_t index) {
    const auto& plan = plan_.lines[index];
    const auto& line = project_.lines[plan.line];
    OwenMaster master;
    master.framing = line.framing == wire::Framing::ascii ? 1 : 0;
    master.parity = static_cast<std::uint8_t>(line.format.parity);
    master.data_bits = line.format.data_bits;
    master.stop_bits = line.format.stop_bits;
    master.baud = line.format.baud;
    master.request_gap_us = static_cast<std::uint32_t>(line.request_gap / 1us);
    master.frame_gap_us = static_cast<std::uint32_t>(line.frame_gap / 1us);
    master.first_device = static_cast<std::uint16_t>(built_.table.devices.size());
    master.device_count = static_cast<std::uint16_t>(line.devices.size());
    built_.table.masters.push_back(master);
    std::vector<std::size_t> order(line.devices.size());
    for (std::size_t d = 0; d < order.size(); ++d) order[d] = d;
    std::ranges::stable_sort(order, {}, [&](std::size_t d) { return line.devices[d].address; });
    for (const auto d : order) add_device(plan, d);
}

void OwenBuilder::add_device(const plan::LinePlan& plan, std::size_t index) {
    const auto& device = project_.lines[plan.line].devices[index];
    device_ = &device;
    places_.assign(device.variables.size(), 0);
    OwenDevice record;
    record.unit = device.address.value;
    record.orders = static_cast<std::uint8_t>((device.order.high_byte_first ? 1 : 0) |
                                              (device.order.high_register_first ? 2 : 0));
    record.attempts = device.attempts;
    record.period_ms = milliseconds(device.poll_period).value_or(0);
    record.timeout_ms = milliseconds(device.response_timeout).value_or(0);
    if (!milliseconds(device.poll_period) || record.timeout_ms == 0)
        built_.findings.push_back({.code = "table.period",
                                   .location = device.location,
                                   .path = device.name,
                                   .arguments = {{"name", device.name}}});
    record.status = local(device.status);
    record.poll_enable = local(device.poll_enable);
    record.first_entry = static_cast<std::uint16_t>(built_.table.entries.size());
    for (const auto& request : plan.requests)
        if (request.device == index) add_entry(device, request);
    record.entry_count = static_cast<std::uint16_t>(built_.table.entries.size() - record.first_entry);
    built_.table.devices.push_back(record);
    report_unwritten(plan, index);
}

// Where requests are grouped, a variable that only commands write has no entry that writes it.
void OwenBuilder::report_unwritten(const plan::LinePlan& plan, std::size_t index) {
    std::vector<bool> written(device_->variables.size());
    for (const auto& request : plan.requests)
        if (request.device == index && request.write)
            for (const auto variable : request.variables) written[variable] = true;
    std::size_t count = 0;
    const model::Variable* first = nullptr;
    for (std::size_t i = 0; i < written.size(); ++i) {
        const auto& variable = device_->variables[i];
        if (!variable.used || !variable.write || written[i]) continue;
        if (++count == 1) first = &variable;
    }
    if (first == nullptr) return;
    built_.findings.push_back({.severity = model::Severity::warning,
                               .code = "table.not_written",
                               .location = first->location,
                               .path = first->name,
                               .value = first->name,
                               .arguments = {{"device", device_->name}, {"count", std::to_string(count)}}});
}

void OwenBuilder::check_variable(const model::Device& device, const model::Variable& variable) {
    if (!kind_of(variable.type)) refuse("table.type", variable, {{"type", std::string(name(variable.type))}});
    if (variable.type != DataType::boolean && variable.order != device.order)
        refuse("table.byte_order", variable);
    if (variable.scaled()) refuse("table.scale", variable);
}

void OwenBuilder::check_neighbours(const model::Variable& a, const model::Variable& b, std::size_t place_a,
                                   std::size_t place_b) {
    const auto both = [&] {
        return std::vector<std::pair<std::string, std::string>>{{"previous", a.name}, {"next", b.name}};
    };
    if (kind_of(a.type) && kind_of(b.type) && kind_of(a.type) != kind_of(b.type))
        refuse("table.mixed_types", b, both());
    const bool bits = a.type == DataType::boolean && b.type == DataType::boolean;
    if (bits && a.register_number != b.register_number)
        refuse("table.two_registers", b, both());
    else if (bits ? b.bit.value_or(0) != a.bit.value_or(0) + 1 : b.start() != a.start() + a.items())
        refuse("table.gap", b, both());
    else if (place_b != place_a + 1)
        refuse("table.place", b, both());
}

void OwenBuilder::check_request(const plan::Request& request, const Variables& members) {
    for (const auto function : {request.read, request.write}) {
        const auto code = function ? static_cast<std::uint8_t>(*function) : std::uint8_t{0};
        if (code == 0x16 || code == 0x17) refuse("table.function", *members[0], {{"function", hex(code)}});
    }
    if (request.phase != Duration::zero()) refuse("table.phase", *members[0]);
    // The entry of one bit has its number. Several bits of a register have one only by `optimal`.
    if (request.read_modify_write && members.size() > 1) refuse("table.read_modify_write", *members[0]);
    if (request.admission) refuse("table.admission", *members[0]);
    if (request.period && !milliseconds(*request.period)) refuse("table.period", *members[0]);
    std::size_t place = place_of(*members[0]);
    for (std::size_t i = 1; i < members.size(); ++i) {
        const auto next = place_of(*members[i]);
        check_neighbours(*members[i - 1], *members[i], place, next);
        place = next;
    }
}

void OwenBuilder::add_entry(const model::Device& device, const plan::Request& request) {
    Variables members;
    for (const auto index : request.variables) members.push_back(&device.variables[index]);
    const auto& first = *members.front();
    for (const auto* member : members)
        if (places_[static_cast<std::size_t>(member - device.variables.data())] == 0)
            check_variable(device, *member);
    check_request(request, members);
    OwenEntry entry;
    const auto bit = first.type == DataType::boolean ? first.bit.value_or(0) : 0;
    entry.type_and_bit = static_cast<std::uint8_t>(kind_of(first.type).value_or(0) | bit << 4);
    entry.read = request.read ? static_cast<std::uint8_t>(*request.read) : std::uint8_t{0};
    entry.write = request.write ? static_cast<std::uint8_t>(*request.write) : std::uint8_t{0};
    entry.flags = static_cast<std::uint8_t>((request.period ? OwenEntry::kPolled : 0) |
                                            (request.write_on_change ? OwenEntry::kWrittenOnChange : 0));
    entry.quantity = static_cast<std::uint16_t>(members.size());
    entry.start = first.register_number;
    entry.data = static_cast<Place>(place_of(first));
    entry.read_trigger = local(request.read_trigger);
    entry.write_trigger = local(request.write_trigger);
    entry.status = local(request.status);
    if (request.period && *request.period != device.poll_period)
        entry.period_ms = milliseconds(*request.period).value_or(0);
    built_.table.entries.push_back(entry);
}

template <class Record>
void put_all(Image& image, std::vector<Record> records) {
    Put put(image);
    for (auto& record : records) code(put, record);
}

}  // namespace

OwenBuilt build_owen(const model::Project& project, const plan::Plan& plan) {
    return OwenBuilder(project, plan).build();
}

Image write_owen(const OwenTable& table) {
    Image image(kOwenMagic, kOwenMagic + kMagicSize);
    OwenHeader header;
    header.version = table.version;
    header.header_size = static_cast<std::uint16_t>(kOwenHeaderSize);
    header.places = table.places;
    header.masters = static_cast<std::uint16_t>(table.masters.size());
    header.devices = static_cast<std::uint16_t>(table.devices.size());
    header.entries = static_cast<std::uint16_t>(table.entries.size());
    Put put(image);
    code(put, header);
    put_all(image, table.masters);
    put_all(image, table.devices);
    put_all(image, table.entries);
    seal(image);
    return image;
}

Result<OwenTable> read_owen(Bytes image) {
    TAKT_TRY(const OwenView view, OwenView::open(image));
    TAKT_CHECK(restored(view));  // what cannot run is not shown either
    const OwenHeader& header = view.header();
    OwenTable table{.version = header.version, .places = header.places};
    for (std::size_t i = 0; i < header.masters; ++i) table.masters.push_back(view.master(i));
    for (std::size_t i = 0; i < header.devices; ++i) table.devices.push_back(view.device(i));
    for (std::size_t i = 0; i < header.entries; ++i) table.entries.push_back(view.entry(i));
    return table;
}

std::span<const std::string_view> owen_codes() {
    return kCodes;
}

}  // namespace takt::table
