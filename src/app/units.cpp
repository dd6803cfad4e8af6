#include "takt/app/units.hpp"

#include <fmt/format.h>

namespace takt::app {

std::string milliseconds_text(Duration duration) {
    const double ms = static_cast<double>(duration.count()) / 1e6;
    return fmt::format("{:.{}f} ms", ms, ms < 10 ? 2 : ms < 100 ? 1 : 0);
}

std::int64_t whole_microseconds(Duration duration) {
    return std::chrono::ceil<std::chrono::microseconds>(duration).count();
}

std::string seconds_text(Duration duration) {
    return fmt::format("{:.1f} s", static_cast<double>(duration.count()) / 1e9);
}

std::string function_text(wire::Function function) {
    return fmt::format("0x{:02X}", static_cast<int>(function));
}

std::string request_text(const plan::Request& request) {
    std::string functions;
    if (request.read) functions = function_text(*request.read);
    if (request.write) functions += (functions.empty() ? "" : "+") + function_text(*request.write);
    const int last = request.start + request.quantity - 1;
    return request.quantity == 1 ? fmt::format("{} {}", functions, request.start)
                                 : fmt::format("{} {}..{}", functions, request.start, last);
}

}  // namespace takt::app
