#include "takt/wire/function.hpp"

namespace takt::wire {
namespace {

// Empty for a code that is no function of the specification.
std::string_view known_name(Function function) {
    switch (function) {
        case Function::read_coils: return "read coils";
        case Function::read_discrete_inputs: return "read discrete inputs";
        case Function::read_holding_registers: return "read holding registers";
        case Function::read_input_registers: return "read input registers";
        case Function::write_single_coil: return "write single coil";
        case Function::write_single_register: return "write single register";
        case Function::read_exception_status: return "read exception status";
        case Function::diagnostics: return "diagnostics";
        case Function::get_comm_event_counter: return "get comm event counter";
        case Function::get_comm_event_log: return "get comm event log";
        case Function::write_multiple_coils: return "write multiple coils";
        case Function::write_multiple_registers: return "write multiple registers";
        case Function::report_server_id: return "report server id";
        case Function::read_file_record: return "read file record";
        case Function::write_file_record: return "write file record";
        case Function::mask_write_register: return "mask write register";
        case Function::read_write_multiple_registers: return "read/write multiple registers";
        case Function::read_fifo_queue: return "read fifo queue";
        case Function::encapsulated_interface: return "encapsulated interface transport";
    }
    return {};
}

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

bool is_known(Function function) {
    return !known_name(function).empty();
}

std::string_view name(Function function) {
    return is_known(function) ? known_name(function) : "function";
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
