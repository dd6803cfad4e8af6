#include "takt/wire/function.hpp"

namespace takt::wire {
namespace {

// In the order of kFunctions. A table of its own: programs that print no names do not contain it.
constexpr std::array<std::string_view, kFunctions.size()> kFunctionNames{
    "function",
    "read coils",
    "read discrete inputs",
    "read holding registers",
    "read input registers",
    "write single coil",
    "write single register",
    "read exception status",
    "diagnostics",
    "get comm event counter",
    "get comm event log",
    "write multiple coils",
    "write multiple registers",
    "report server id",
    "read file record",
    "write file record",
    "mask write register",
    "read/write multiple registers",
    "read fifo queue",
    "encapsulated interface transport",
};

// Sub-functions of 0x08 that change nothing: loopback, diagnostic register, counters. All others may change
// the device, also those that the specification reserves.
constexpr bool only_diagnoses(unsigned sub_function) {
    return sub_function == 0 || sub_function == 2 || (sub_function >= 11 && sub_function <= 18);
}

}  // namespace

Effect effect(Function function, std::optional<std::uint16_t> sub_function) {
    if (sub_function && function == Function::diagnostics)
        return only_diagnoses(*sub_function) ? Effect::diagnostic : Effect::write;
    if (sub_function && function == Function::encapsulated_interface)
        return *sub_function == kReadDeviceId ? Effect::read : Effect::write;
    return properties(function).effect;
}

std::string_view name(Function function) {
    return kFunctionNames[row_of(function)];
}

std::string_view name(ExceptionCode code) {
    switch (code) {
        case ExceptionCode::illegal_function: return "illegal function";
        case ExceptionCode::illegal_data_address: return "illegal data address";
        case ExceptionCode::illegal_data_value: return "illegal data value";
        case ExceptionCode::server_device_failure: return "server device failure";
        case ExceptionCode::acknowledge: return "acknowledge";
        case ExceptionCode::server_device_busy: return "server device busy";
        case ExceptionCode::memory_parity_error: return "memory parity error";
        case ExceptionCode::gateway_path_unavailable: return "gateway path unavailable";
        case ExceptionCode::gateway_target_failed_to_respond:
            return "gateway target device failed to respond";
    }
    return "exception";
}

std::string_view name(Area area) {
    switch (area) {
        case Area::coil: return "coil";
        case Area::discrete_input: return "discrete_input";
        case Area::input_register: return "input_register";
        case Area::holding_register: return "holding_register";
    }
    return "area";
}

}  // namespace takt::wire
