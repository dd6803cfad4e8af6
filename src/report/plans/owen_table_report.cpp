// Reports of the table of the OWEN KC1 controller.
#include <fmt/format.h>

#include "plans/table_report_parts.hpp"
#include "takt/model/fields.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/plans/table_report.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;
using file::Json;
using table::OwenEntry;

const char* owen_type_name(const OwenEntry& entry) {
    constexpr const char* kTypes[] = {"bit", "word", "double word"};
    return kTypes[entry.type_and_bit & 3];
}

Json index_json(table::Place place) {
    return place == 0 ? Json() : Json(place);
}

Json owen_entry_json(const OwenEntry& entry, std::uint16_t device_period) {
    auto object = Json::object();
    object.set("type", owen_type_name(entry));
    object.set("bit", (entry.type_and_bit & 15) == OwenEntry::kBit ? Json(entry.type_and_bit >> 4) : Json());
    object.set("type_and_bit", entry.type_and_bit);
    object.set("function", function_code_json(entry.read));
    object.set("write_function", function_code_json(entry.write));
    object.set("flags", entry.flags);
    object.set("quantity", entry.quantity);
    object.set("start", entry.start);
    object.set("data", entry.data);
    object.set("read_trigger", index_json(entry.read_trigger));
    object.set("write_trigger", index_json(entry.write_trigger));
    object.set("status", index_json(entry.status));
    const bool own = entry.period_ms != OwenEntry::kPeriodOfDevice;
    const bool polled = (entry.flags & OwenEntry::kPolled) != 0;
    object.set("own_period", own);
    object.set("period_ms", polled ? Json(own ? entry.period_ms : device_period) : Json());
    return object;
}

Json owen_device_json(const table::OwenTable& table, const table::OwenDevice& device) {
    auto object = Json::object();
    object.set("unit", device.unit);
    object.set("period_ms", device.period_ms);
    object.set("response_timeout_ms", device.timeout_ms);
    object.set("attempts", device.attempts);
    object.set("high_byte_first", (device.orders & 1) != 0);
    object.set("high_register_first", (device.orders & 2) != 0);
    object.set("status", index_json(device.status));
    object.set("poll_enable", index_json(device.poll_enable));
    auto entries = Json::array();
    for (std::size_t e = 0; e < device.entry_count; ++e)
        entries.push_back(owen_entry_json(table.entries[device.first_entry + e], device.period_ms));
    object.set("entries", std::move(entries));
    return object;
}

std::string function_column(const OwenEntry& entry) {
    std::string text = entry.read != 0 ? fmt::format("0x{:02X}", entry.read) : "";
    if (entry.write != 0) text += fmt::format("{}0x{:02X}", text.empty() ? "" : "+", entry.write);
    return text;
}

std::string index_column(table::Place place) {
    return place == 0 ? std::string("–") : std::to_string(place);
}

std::string owen_entries_text(const Texts& texts, const table::OwenTable& table,
                              const table::OwenDevice& device) {
    TextTable rows({Align::right, Align::left, Align::left, Align::right, Align::left, Align::right,
                    Align::left, Align::right, Align::left});
    rows.add({texts("app.table.entry"), texts("app.table.type"), texts("app.request"),
              texts("app.table.flags"), texts("app.period"), texts("app.table.data"),
              texts("app.table.triggers"), texts("app.table.status"), ""});
    for (std::size_t e = 0; e < device.entry_count; ++e) {
        const auto& entry = table.entries[device.first_entry + e];
        const bool own = entry.period_ms != OwenEntry::kPeriodOfDevice;
        const bool bit = (entry.type_and_bit & 15) == OwenEntry::kBit;
        rows.add({std::to_string(device.first_entry + e),
                  bit ? fmt::format("{} {}", owen_type_name(entry), entry.type_and_bit >> 4)
                      : owen_type_name(entry),
                  fmt::format("{} {} × {}", function_column(entry), entry.start, entry.quantity),
                  fmt::format("0x{:02X}", entry.flags),
                  own ? texts.duration(std::chrono::milliseconds(entry.period_ms)) : "–",
                  std::to_string(entry.data),
                  index_column(entry.read_trigger) + " / " + index_column(entry.write_trigger),
                  index_column(entry.status)});
    }
    return rows.render("  ");
}

}  // namespace

std::string table_text(const Texts& texts, const table::OwenTable& table, Bytes image) {
    std::string text = heading(texts, "owen-kc1", table.version, image.size(), table::image_checksum(image));
    for (const auto& master : table.masters) {
        text += fmt::format("{}, {} bit/s\n", master.framing == 0 ? "rtu" : "ascii", master.baud);
        for (std::size_t d = 0; d < master.device_count; ++d) {
            const auto& device = table.devices[master.first_device + d];
            text += device_text(texts, fmt::format("{} {}", texts("app.device"), master.first_device + d),
                                device.unit, std::chrono::milliseconds(device.period_ms),
                                std::chrono::milliseconds(device.timeout_ms), device.attempts);
            text += owen_entries_text(texts, table, device);
        }
    }
    return text;
}

Json table_json(const table::OwenTable& table, Bytes image) {
    auto object = Json::object();
    object.set("format", "owen-kc1");
    object.set("version", table.version);
    object.set("length", static_cast<std::uint64_t>(image.size()));
    object.set("checksum", checksum_text(table::image_checksum(image)));
    object.set("places", table.places);
    auto lines = Json::array();
    for (const auto& master : table.masters) {
        auto line = Json::object();
        line.set("framing", master.framing == 0 ? "rtu" : "ascii");
        line.set("baud", master.baud);
        line.set("parity", model::kParities[master.parity]);
        line.set("data_bits", master.data_bits);
        line.set("stop_bits", master.stop_bits);
        line.set("request_gap_us", master.request_gap_us);
        line.set("frame_gap_us", master.frame_gap_us);
        auto devices = Json::array();
        for (std::size_t d = 0; d < master.device_count; ++d)
            devices.push_back(owen_device_json(table, table.devices[master.first_device + d]));
        line.set("devices", std::move(devices));
        lines.push_back(std::move(line));
    }
    object.set("lines", std::move(lines));
    return object;
}

}  // namespace takt::report
