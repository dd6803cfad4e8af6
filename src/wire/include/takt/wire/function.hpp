// Function and exception codes (MODBUS Application Protocol V1.1b3, sections 6 and 7).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace takt::wire {

/// Function codes as on the wire. A value read from the wire may be any byte: see is_known().
enum class Function : std::uint8_t {
    read_coils = 0x01,
    read_discrete_inputs = 0x02,
    read_holding_registers = 0x03,
    read_input_registers = 0x04,
    write_single_coil = 0x05,
    write_single_register = 0x06,
    read_exception_status = 0x07,
    diagnostics = 0x08,
    get_comm_event_counter = 0x0B,
    get_comm_event_log = 0x0C,
    write_multiple_coils = 0x0F,
    write_multiple_registers = 0x10,
    report_server_id = 0x11,
    read_file_record = 0x14,
    write_file_record = 0x15,
    mask_write_register = 0x16,
    read_write_multiple_registers = 0x17,
    read_fifo_queue = 0x18,
    encapsulated_interface = 0x2B,
};

/// True for the functions above.
bool is_known(Function function);

/// English name as in the specification: "read holding registers"; "function" for an unknown one.
std::string_view name(Function function);

/// The effect of a request with a function on the device.
enum class Effect : std::uint8_t {
    read,        ///< changes nothing: may be sent again, and one response may serve several clients
    diagnostic,  ///< changes nothing, but the response belongs to this request alone: an echo, a counter
    write,       ///< may change something; every unknown function counts as one
};

/// The fixed properties of a function, one row a function.
struct FunctionProperties {
    Effect effect = Effect::write;
    bool counts_bits = false;    ///< the items are bits, not registers
    bool returns_items = false;  ///< the response is a byte count and the items that were read
    bool echoes = false;         ///< the response repeats (the head of) the request
    bool broadcast = false;      ///< makes sense to all devices of a line at once: see may_be_broadcast()
};

constexpr FunctionProperties properties(Function function) {
    switch (function) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
            return {.effect = Effect::read, .counts_bits = true, .returns_items = true};
        case Function::read_holding_registers:
        case Function::read_input_registers: return {.effect = Effect::read, .returns_items = true};
        case Function::read_exception_status:
        case Function::report_server_id:
        case Function::read_file_record:
        case Function::read_fifo_queue: return {.effect = Effect::read};
        case Function::diagnostics:
        case Function::get_comm_event_counter:
        case Function::get_comm_event_log:
        case Function::encapsulated_interface: return {.effect = Effect::diagnostic};  // see effect()
        case Function::write_single_coil:
        case Function::write_multiple_coils: return {.counts_bits = true, .echoes = true, .broadcast = true};
        case Function::write_single_register:
        case Function::write_multiple_registers:
        case Function::write_file_record:
        case Function::mask_write_register: return {.echoes = true, .broadcast = true};
        case Function::read_write_multiple_registers: return {.returns_items = true};
    }
    return {};
}

/// The MEI type of the encapsulated interface (0x2B) that reads the device identification.
inline constexpr std::uint8_t kReadDeviceId = 14;

/// The effect of a request: diagnostics (0x08) and the encapsulated interface (0x2B) depend on their
/// sub-function or MEI type. A request too short to have one changes nothing.
[[nodiscard]] Effect effect(Function function, std::optional<std::uint16_t> sub_function);

/// Whether the items of the function are bits (0x01, 0x02, 0x05, 0x0F) rather than registers.
constexpr bool counts_bits(Function function) {
    return properties(function).counts_bits;
}

/// Set in the first byte of an exception response, beside the function of the request.
inline constexpr std::uint8_t kExceptionBit = 0x80;

/// Whether a response that begins with this byte is an exception.
constexpr bool is_exception(std::uint8_t function) {
    return (function & kExceptionBit) != 0;
}

/// The first byte of the exception response to a request with the function.
constexpr std::uint8_t exception_function(std::uint8_t function) {
    return static_cast<std::uint8_t>(function | kExceptionBit);
}

/// The function of the request, from the first byte of its response.
constexpr std::uint8_t requested_function(std::uint8_t function) {
    return static_cast<std::uint8_t>(function & ~kExceptionBit);
}

/// Exception codes. A value read from the wire may be any byte, also 0, 0x7F and 0xFF.
enum class ExceptionCode : std::uint8_t {
    illegal_function = 0x01,
    illegal_data_address = 0x02,
    illegal_data_value = 0x03,
    server_device_failure = 0x04,
    acknowledge = 0x05,
    server_device_busy = 0x06,
    memory_parity_error = 0x08,
    gateway_path_unavailable = 0x0A,
    gateway_target_failed_to_respond = 0x0B,
};

/// English name: "illegal data address"; "exception" for an unknown one.
std::string_view name(ExceptionCode code);

/// The four areas of a device.
enum class Area : std::uint8_t { coil, discrete_input, input_register, holding_register };

/// "coil", "discrete_input", "input_register", "holding_register".
std::string_view name(Area area);

constexpr bool is_bit_area(Area area) {
    return area == Area::coil || area == Area::discrete_input;
}

/// The function that reads the area: 0x01 to 0x04.
constexpr Function read_function(Area area) {
    switch (area) {
        case Area::coil: return Function::read_coils;
        case Area::discrete_input: return Function::read_discrete_inputs;
        case Area::input_register: return Function::read_input_registers;
        case Area::holding_register: break;
    }
    return Function::read_holding_registers;
}

}  // namespace takt::wire
