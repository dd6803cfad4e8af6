#include "takt/report/drawing/formatting.hpp"

#include <fmt/format.h>

#include <cmath>

namespace takt::report {
namespace {

std::string item_span_text(std::uint16_t start, std::uint16_t quantity) {
    return quantity == 1 ? fmt::format("{}", start) : fmt::format("{}..{}", start, start + quantity - 1);
}

}  // namespace

double milliseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
}

double microseconds(Duration duration) {
    return static_cast<double>(duration.count()) / 1e3;
}

std::string percent_text(double share) {
    return fmt::format("{:.1f} %", share * 100);
}

std::string turn_text(const Texts& texts, Duration period, Duration phase) {
    const auto text = texts.duration(period);
    return phase == Duration::zero() ? text : text + " +" + texts.exact(phase);
}

std::int64_t whole_microseconds(Duration duration) {
    return std::chrono::ceil<std::chrono::microseconds>(duration).count();
}

std::string availability_text(std::optional<double> share) {
    constexpr double kRounding = 1e-6;  // a share of 0.57 is 56.999999999999993 %
    return share ? fmt::format("{:.2f} %", std::floor(*share * 10'000 + kRounding) / 100) : "–";
}

void set_availability(file::Json& object, const poll::Availability& availability) {
    const auto share = availability.share();
    object.set("availability_percent", share ? file::Json(*share * 100) : file::Json());
    object.set("downtime_ms", milliseconds(availability.downtime));
}

std::string_view area_word(wire::Area area) {
    switch (area) {
        case wire::Area::coil: return "coils";
        case wire::Area::discrete_input: return "discrete";
        case wire::Area::input_register: return "input";
        case wire::Area::holding_register: break;
    }
    return "holding";
}

std::string item_text(wire::Area area, std::uint32_t address) {
    return fmt::format("{} {}", area_word(area), address);
}

std::string function_text(wire::Function function) {
    return fmt::format("0x{:02X}", static_cast<int>(function));
}

std::string range_text(const model::ItemRange& range) {
    return range.first == range.last ? std::to_string(range.first)
                                     : fmt::format("{}..{}", range.first, range.last);
}

file::Json function_json(const std::optional<wire::Function>& function) {
    return function ? file::Json(static_cast<int>(*function)) : file::Json();
}

std::string csv_cell(std::string_view text, char separator) {
    if (text.find_first_of("\"\r\n") == std::string_view::npos && !text.contains(separator))
        return std::string(text);
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + '"';
}

// Function 0x17 is listed once, with the items it reads and those it writes; a read-modify-write as the two
// functions it sends.
std::string request_text(const plan::Request& request) {
    std::string functions;
    if (request.read) functions = function_text(*request.read);
    if (request.write && request.write_quantity == 0) {
        if (request.read_modify_write && !request.read) functions = "0x03";
        functions += (functions.empty() ? "" : "+") + function_text(*request.write);
    }
    std::string range = functions + " " + item_span_text(request.start, request.quantity);
    if (request.write_quantity == 0) return range;
    return range + " < " + item_span_text(request.write_start, request.write_quantity);
}

}  // namespace takt::report
