#include "takt/report/plans/table_report.hpp"

#include <fmt/format.h>

#include <optional>

#include "plans/table_report_parts.hpp"
#include "takt/model/fields.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/plans/plan_report.hpp"
#include "takt/table/restore.hpp"

namespace takt::report {
namespace {

using Align = TextTable::Align;
using file::Json;
using table::EntryRecord;
using table::ItemRecord;
using table::View;

std::string item_name(const View& view, std::uint32_t item) {
    const auto name = view.text(view.item(item).name);
    return name.empty() ? fmt::format("item{}", item) : std::string(name);
}

Json item_or_null(const View& view, std::uint32_t item) {
    return item == table::kNone ? Json() : Json(item_name(view, item));
}

Json place_or_null(std::uint32_t place) {
    return place == table::kNone ? Json() : Json(place);
}

Json entry_record_json(const View& view, std::uint32_t index) {
    const auto entry = view.entry(index);
    auto object = Json::object();
    object.set("function", function_code_json(entry.read));
    object.set("write_function", function_code_json(entry.write));
    object.set("flags", entry.flags);
    object.set("start", entry.start);
    object.set("quantity", entry.quantity);
    object.set("write_start", entry.write_start);
    object.set("write_quantity", entry.write_quantity);
    const bool polled = (entry.flags & EntryRecord::kPolled) != 0;
    object.set("period_ms", polled ? Json(milliseconds(Duration(entry.period))) : Json());
    object.set("phase_ms", milliseconds(Duration(entry.phase)));
    object.set("deadline_ms", milliseconds(Duration(entry.deadline)));
    object.set("stream", entry.stream);
    object.set("read_trigger", item_or_null(view, entry.read_trigger));
    object.set("write_trigger", item_or_null(view, entry.write_trigger));
    object.set("write_on_change", (entry.flags & EntryRecord::kWrittenOnChange) != 0);
    object.set("read_modify_write", (entry.flags & EntryRecord::kReadModifyWrite) != 0);
    object.set("status", item_or_null(view, entry.status));
    auto variables = Json::array();
    auto items = Json::array();
    for (std::uint32_t m = 0; m < entry.member_count; ++m) {
        variables.push_back(item_name(view, view.member(entry, m)));
        items.push_back(view.member(entry, m));
    }
    object.set("variables", std::move(variables));
    object.set("items", std::move(items));
    object.set("bus_time_us", microseconds(Duration(entry.bus_time)));
    return object;
}

Json device_record_json(const View& view, std::uint32_t index) {
    const auto device = view.device(index);
    auto object = Json::object();
    object.set("name", std::string(view.text(device.name)));
    object.set("unit", device.unit);
    object.set("period_ms", milliseconds(Duration(device.period)));
    object.set("response_timeout_ms", milliseconds(Duration(device.response_timeout)));
    object.set("wait_ms", milliseconds(Duration(device.wait)));
    object.set("attempts", device.attempts);
    object.set("high_byte_first", (device.flags & table::DeviceRecord::kHighByteFirst) != 0);
    object.set("high_register_first", (device.flags & table::DeviceRecord::kHighRegisterFirst) != 0);
    object.set("status", item_or_null(view, device.status));
    object.set("poll_enable", item_or_null(view, device.poll_enable));
    auto entries = Json::array();
    for (std::uint32_t e = 0; e < device.entry_count; ++e)
        entries.push_back(entry_record_json(view, device.first_entry + e));
    object.set("entries", std::move(entries));
    return object;
}

Json line_record_json(const View& view, std::uint32_t index) {
    const auto line = view.line(index);
    auto object = Json::object();
    object.set("name", std::string(view.text(line.name)));
    object.set("transport", model::name(model::Transport{line.transport}));
    object.set("port", std::string(view.text(line.port)));
    object.set("framing", wire::name(wire::Framing{line.framing}));
    object.set("baud", line.baud);
    object.set("parity", model::kParities[line.parity]);
    object.set("data_bits", line.data_bits);
    object.set("stop_bits", line.stop_bits);
    object.set("order", line.order == 0 ? "deadline" : "address");
    object.set("request_gap_us", microseconds(Duration(line.request_gap)));
    object.set("frame_gap_us", microseconds(Duration(line.frame_gap)));
    object.set("margin_us", microseconds(Duration(line.margin)));
    auto devices = Json::array();
    for (std::uint32_t d = 0; d < line.device_count; ++d)
        devices.push_back(device_record_json(view, line.first_device + d));
    object.set("devices", std::move(devices));
    return object;
}

Json item_json(const View& view, std::uint32_t index) {
    const auto item = view.item(index);
    auto object = Json::object();
    object.set("name", item_name(view, index));
    object.set("device", item.device == table::kNone
                             ? Json()
                             : Json(std::string(view.text(view.device(item.device).name))));
    object.set("type", name(table::type_of(item)));
    if (item.device != table::kNone) {
        object.set("area", wire::name(wire::Area{item.area}));
        object.set("start", item.start);
        object.set("registers", item.registers);
        object.set("bit", item.bit == ItemRecord::kNoBit ? Json() : Json(item.bit));
        object.set("function", function_code_json(item.read));
        object.set("write_function", function_code_json(item.write));
        object.set("high_byte_first", (item.flags & ItemRecord::kHighByteFirst) != 0);
        object.set("high_register_first", (item.flags & ItemRecord::kHighRegisterFirst) != 0);
        object.set("scale", item.scale);
        object.set("offset", item.offset);
    }
    object.set("place", item.place);
    object.set("write_place", place_or_null(item.write_place));
    return object;
}

std::string table_entries_text(const Texts& texts, const View& view, const table::DeviceRecord& device,
                               const plan::LinePlan& plan, std::uint32_t first_of_line) {
    TextTable rows({Align::right, Align::left, Align::left, Align::left});
    rows.add({texts("app.table.entry"), texts("app.request"), texts("app.when"), texts("app.variables")});
    for (std::uint32_t e = 0; e < device.entry_count; ++e) {
        const auto index = device.first_entry + e;
        const auto entry = view.entry(index);
        const bool polled = (entry.flags & EntryRecord::kPolled) != 0;
        const auto local = [&](std::uint32_t item) {
            return item == table::kNone ? std::string() : item_name(view, item);
        };
        std::string names;
        for (std::uint32_t m = 0; m < entry.member_count; ++m) {
            const auto item = view.member(entry, m);
            names += fmt::format("{}{}@{}", m > 0 ? ", " : "", item_name(view, item), view.item(item).place);
        }
        rows.add({std::to_string(index), request_text(plan.requests[index - first_of_line]),
                  causes_text(texts, {.period = polled ? std::optional(Duration(entry.period)) : std::nullopt,
                                      .phase = Duration(entry.phase),
                                      .read_trigger = local(entry.read_trigger),
                                      .on_change = (entry.flags & EntryRecord::kWrittenOnChange) != 0,
                                      .write_trigger = local(entry.write_trigger)}),
                  names});
    }
    return rows.render("  ");
}

/// The message for an error of a reader of tables.
std::string error_code(const Error& error) {
    switch (error.code) {
        case Code::unsupported:
            return error.numbers[0] > error.numbers[1] ? "app.table.newer" : "app.table.older";
        case Code::too_short: return "app.table.truncated";
        case Code::too_long: return "app.table.followed";
        case Code::overflow: return "app.table.overflow";
        case Code::bad_checksum: return "app.table.corrupt";
        default: return error.subject.view() == "magic" ? "app.table.foreign" : "app.table.inconsistent";
    }
}

}  // namespace

Json function_code_json(std::uint8_t function) {
    return function == 0 ? Json() : Json(static_cast<int>(function));
}

std::string checksum_text(std::uint32_t checksum) {
    return fmt::format("{:08X}", checksum);
}

std::string heading(const Texts& texts, const char* format, std::uint16_t version, std::size_t bytes,
                    std::uint32_t checksum) {
    return texts("app.table.heading", {{"format", format},
                                       {"version", std::to_string(version)},
                                       {"bytes", std::to_string(bytes)},
                                       {"checksum", checksum_text(checksum)}}) +
           '\n';
}

std::string device_text(const Texts& texts, const std::string& name, int unit, Duration period,
                        Duration timeout, int attempts) {
    return texts("app.table.device", {{"name", name},
                                      {"unit", std::to_string(unit)},
                                      {"period", texts.duration(period)},
                                      {"timeout", texts.duration(timeout)},
                                      {"attempts", std::to_string(attempts)}}) +
           '\n';
}

std::string table_text(const Texts& texts, const View& view) {
    std::string text =
        heading(texts, "takt", view.header().version, view.header().length, view.header().checksum);
    const auto plan = table::plan_of(view);
    for (std::uint32_t l = 0; l < view.line_count(); ++l) {
        const auto line = view.line(l);
        text += fmt::format("{} ({}{})\n", view.text(line.name), wire::name(wire::Framing{line.framing}),
                            line.baud != 0 ? fmt::format(", {} bit/s", line.baud) : "");
        for (std::uint32_t d = 0; d < line.device_count; ++d) {
            const auto device = view.device(line.first_device + d);
            text += device_text(texts, std::string(view.text(device.name)), device.unit,
                                Duration(device.period), Duration(device.response_timeout), device.attempts);
            text += table_entries_text(texts, view, device, plan.lines[l], line.first_entry);
        }
    }
    return text;
}

Json table_json(const View& view) {
    auto object = Json::object();
    object.set("format", "takt");
    object.set("version", view.header().version);
    object.set("length", view.header().length);
    object.set("checksum", checksum_text(view.header().checksum));
    object.set("value_words", view.header().value_words);
    object.set("write_words", view.header().write_words);
    auto lines = Json::array();
    for (std::uint32_t l = 0; l < view.line_count(); ++l) lines.push_back(line_record_json(view, l));
    object.set("lines", std::move(lines));
    Json::Array items;
    for (std::uint32_t i = 0; i < view.item_count(); ++i) items.push_back(item_json(view, i));
    object.set("items", Json(std::move(items)));
    return object;
}

std::string table_error_text(const Texts& texts, const std::string& path, const Error& error) {
    const Texts::Arguments arguments{{"file", path},
                                     {"version", std::to_string(error.numbers[0])},
                                     {"known", std::to_string(error.numbers[1])},
                                     {"there", std::to_string(error.numbers[0])},
                                     {"needed", std::to_string(error.numbers[1])},
                                     {"what", std::string(error.subject.view())},
                                     {"index", std::to_string(error.numbers[0])}};
    const std::string code = error_code(error);
    auto text = texts(code, arguments) + '\n';
    if (code == "app.table.foreign") return text;
    return text + "    " +
           texts(code == "app.table.newer" ? code + ".advice" : "app.table.make_anew", arguments) + '\n';
}

}  // namespace takt::report
