#include "takt/model/firmware.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "reading/reader.hpp"

namespace takt::model {
namespace {

template <class T>
void read(Reader& reader, std::string_view key, T& value) {
    if (const auto number = reader.integer(key)) value = static_cast<std::uint32_t>(*number);
}

Firmware read_firmware(Reader& reader) {
    Firmware made;
    read(reader, "baud", made.format.baud);
    if (const auto parity = reader.choice<wire::Parity>("parity")) made.format.parity = *parity;
    if (const auto bits = reader.integer("stop_bits"))
        made.format.stop_bits = static_cast<std::uint8_t>(*bits);
    read(reader, "core_clock", made.core_clock);
    read(reader, "cycles_per_instruction", made.cycles_per_instruction);
    made.wakeup_time = reader.duration("wakeup_time").value_or(Duration::zero());
    made.uart_clock = made.core_clock;
    read(reader, "uart_clock", made.uart_clock);
    read(reader, "uart_clock_ppm", made.uart_clock_ppm);
    read(reader, "oversampling", made.oversampling);
    read(reader, "divider_steps", made.divider_steps);
    made.timer_clock = std::min(made.timer_clock, made.core_clock);
    read(reader, "timer_clock", made.timer_clock);
    made.timer_clock_ppm = made.uart_clock_ppm;
    read(reader, "timer_clock_ppm", made.timer_clock_ppm);
    read(reader, "timer_bits", made.timer_bits);
    made.request_period = reader.duration("request_period").value_or(Duration::zero());
    read(reader, "registers", made.registers);
    read(reader, "other_exchanges", made.other_exchanges);
    read(reader, "active_ua_per_mhz", made.active_ua_per_mhz);
    read(reader, "sleep_na", made.sleep_na);
    read(reader, "uart_na", made.uart_na);
    read(reader, "transceiver_ua", made.transceiver_ua);
    read(reader, "driver_ua", made.driver_ua);
    read(reader, "battery_mah", made.battery_mah);
    return made;
}

}  // namespace

CheckedFirmware interpret_firmware(const Document& document) {
    CheckedFirmware checked;
    Findings findings;
    if (document.root.kind == Node::Kind::mapping) {
        const Context context;
        Reader reader(findings, document.root, {}, Object::firmware, context);
        checked.firmware = read_firmware(reader);
    } else {
        findings.add(Rule::field_not_a_mapping, document.root.location, {}, document.root.text);
    }
    checked.findings = std::move(findings).take();
    return checked;
}

}  // namespace takt::model
