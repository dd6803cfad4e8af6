// An entry has no names. Places of the value buffer identify the values: an entry that reads and an entry
// that writes the same place are about one variable.
#include <algorithm>
#include <chrono>
#include <map>
#include <string>

#include "takt/plan/priced.hpp"
#include "takt/table/restore.hpp"

namespace takt::table {
namespace {

using wire::Function;

std::optional<Function> function_of(std::uint8_t code) {
    return code == 0 ? std::nullopt : std::optional(Function{code});
}

std::optional<model::LocalIndex> local_at(Place place) {
    return place == 0 ? std::nullopt : std::optional<model::LocalIndex>(place - 1U);
}

// The functions that an entry of a controller has; others make no request.
bool is_usable(const OwenEntry& entry) {
    const auto known = [](std::uint8_t code, std::initializer_list<std::uint8_t> codes) {
        return code == 0 || std::ranges::find(codes, code) != codes.end();
    };
    return known(entry.read, {1, 2, 3, 4}) && known(entry.write, {5, 6, 15, 16}) &&
           (entry.read != 0 || entry.write != 0);
}

class OwenRestorer {
public:
    explicit OwenRestorer(const OwenTable& table) : table_(table) {}

    Restored restore() {
        add_locals();
        for (const auto& master : table_.masters) add_line(master);
        for (std::size_t i = 0; i < requests_.size(); ++i)
            made_.plan.lines.push_back(plan::priced(made_.project, i, std::move(requests_[i])));
        return std::move(made_);
    }

private:
    // The places before those of all variables.
    void add_locals() {
        std::size_t count = table_.places;
        for (const auto& entry : table_.entries) count = std::min<std::size_t>(count, entry.data - 1U);
        made_.project.locals.resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            auto& local = made_.project.locals[i];
            local.name = "local" + std::to_string(i + 1);
            local.type = DataType::boolean;
        }
        const auto is_number = [&](Place place) {
            if (place > 0 && place <= count) made_.project.locals[place - 1U].type = DataType::int16;
        };
        for (const auto& entry : table_.entries) is_number(entry.status);
        for (const auto& device : table_.devices) is_number(device.status);
    }

    [[nodiscard]] std::optional<model::LocalIndex> local(Place place) const {
        return place <= made_.project.locals.size() ? local_at(place) : std::nullopt;
    }

    void add_line(const OwenMaster& master) {
        auto& line = made_.project.lines.emplace_back();
        line.name = "line" + std::to_string(made_.project.lines.size() - 1);
        line.transport = model::Transport::serial;
        line.framing = master.framing == 1 ? wire::Framing::ascii : wire::Framing::rtu;
        line.format = {master.baud, master.data_bits, wire::Parity{master.parity}, master.stop_bits};
        line.order = model::PollOrder::address;
        line.request_gap = std::chrono::microseconds(master.request_gap_us);
        line.frame_gap = std::chrono::microseconds(master.frame_gap_us);
        requests_.emplace_back();
        for (std::size_t i = 0; i < master.device_count; ++i) add_device(line, master.first_device + i);
    }

    void add_device(model::Line& line, std::size_t number) {
        const auto& record = table_.devices[number];
        auto& device = line.devices.emplace_back();
        device.name = "device" + std::to_string(number);
        device.address = UnitId{record.unit};
        device.poll_period = std::chrono::milliseconds(record.period_ms);
        device.response_timeout = std::chrono::milliseconds(record.timeout_ms);
        device.response_timeout_set = true;
        device.attempts = record.attempts;
        // A silent device is asked once each period, as docs/specification.md, section 13, has it.
        const auto pause = std::max<Duration>(device.poll_period, std::chrono::milliseconds(1));
        device.backoff = model::Backoff{.first = pause, .limit = pause};
        device.order = {(record.orders & 1) != 0, (record.orders & 2) != 0};
        device.read_modify_write = true;
        device.status = local(record.status);
        device.poll_enable = local(record.poll_enable);
        variables_.clear();
        for (std::size_t i = 0; i < record.entry_count; ++i)
            if (const auto& entry = table_.entries[record.first_entry + i]; is_usable(entry))
                add_entry(device, line.devices.size() - 1, entry);
    }

    void add_entry(model::Device& device, std::size_t index, const OwenEntry& entry) {
        plan::Request request;
        request.device = index;
        for (std::uint16_t i = 0; i < entry.quantity; ++i)
            request.variables.push_back(variable_at(device, entry, i));
        const auto& first = device.variables[request.variables.front()];
        request.read = function_of(entry.read);
        request.write = function_of(entry.write);
        request.start = first.start();
        const bool bit_of_register = first.bit && !wire::is_bit_area(first.area);
        request.quantity =
            bit_of_register ? std::uint16_t{1} : static_cast<std::uint16_t>(entry.quantity * first.items());
        request.read_modify_write = request.write && bit_of_register;
        if ((entry.flags & OwenEntry::kPolled) != 0) request.period = period_of(device, entry);
        request.read_trigger = local(entry.read_trigger);
        request.write_trigger = local(entry.write_trigger);
        request.write_on_change = (entry.flags & OwenEntry::kWrittenOnChange) != 0;
        request.status = local(entry.status);
        requests_.back().push_back(std::move(request));
    }

    static Duration period_of(const model::Device& device, const OwenEntry& entry) {
        if (entry.period_ms == OwenEntry::kPeriodOfDevice) return device.poll_period;
        return std::chrono::milliseconds(entry.period_ms);
    }

    // The variable at the place of a member, with what the entry adds to it.
    std::size_t variable_at(model::Device& device, const OwenEntry& entry, std::uint16_t member) {
        const auto place = static_cast<Place>(entry.data + member);
        const auto [at, added] = variables_.try_emplace(place, device.variables.size());
        if (added) device.variables.push_back(variable_of(device, entry, member));
        auto& variable = device.variables[at->second];
        if (entry.read != 0) {
            variable.read = Function{entry.read};
            variable.read_trigger = local(entry.read_trigger);
            variable.period = period_of(device, entry);
        }
        if (entry.write != 0) {
            variable.write = Function{entry.write};
            variable.write_trigger = local(entry.write_trigger);
            variable.write_on_change = (entry.flags & OwenEntry::kWrittenOnChange) != 0;
        }
        return at->second;
    }

    model::Variable variable_of(const model::Device& device, const OwenEntry& entry,
                                std::uint16_t member) const {
        model::Variable variable;
        variable.name = "value" + std::to_string(entry.data + member);
        variable.type = entry.type();
        variable.area = wire::area_of(Function{entry.read != 0 ? entry.read : entry.write});
        variable.registers = variable.type == DataType::int32 ? 2 : 1;
        const bool bit = variable.type == DataType::boolean;
        variable.register_number =
            static_cast<std::uint16_t>(entry.start + (bit ? 0 : member * variable.registers));
        if (bit) variable.bit = static_cast<std::uint8_t>((entry.type_and_bit >> 4) + member);
        variable.period = period_of(device, entry);
        variable.order = device.order;
        variable.status = local(entry.status);
        return variable;
    }

    const OwenTable& table_;
    Restored made_;
    std::vector<std::vector<plan::Request>> requests_;  // of each line
    std::map<Place, std::size_t> variables_;            // of the device at hand
};

}  // namespace

Restored restored(const OwenTable& table) {
    return OwenRestorer(table).restore();
}

}  // namespace takt::table
