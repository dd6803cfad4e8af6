// Function and exception codes (MODBUS Application Protocol V1.1b3, sections 6 and 7).
#pragma once

#include <array>
#include <cstddef>
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

/// The effect of a request with a function on the device.
enum class Effect : std::uint8_t {
    read,        ///< changes nothing: may be sent again, and one response may serve several clients
    diagnostic,  ///< changes nothing, but the response belongs to this request alone: an echo, a counter
    write,       ///< may change something; every unknown function counts as one
};

/// The four areas of a device.
enum class Area : std::uint8_t { coil, discrete_input, input_register, holding_register };

/// "coil", "discrete_input", "input_register", "holding_register".
std::string_view name(Area area);

constexpr bool is_bit_area(Area area) {
    return area == Area::coil || area == Area::discrete_input;
}

/// The content of a request behind its function code.
enum class RequestForm : std::uint8_t {
    unknown,       ///< not a function of the specification
    empty,         ///< nothing
    range,         ///< address, quantity
    single,        ///< address, value
    masks,         ///< address, AND mask, OR mask
    values,        ///< address, quantity, byte count, values
    exchange,      ///< address and quantity of the read; address, quantity, byte count, values of the write
    queue,         ///< address
    records,       ///< byte count, ranges of file records
    sub_function,  ///< sub-function, data
    encapsulated,  ///< MEI type, data
};

/// The content of a normal response behind its function code.
enum class ResponseForm : std::uint8_t {
    unknown,       ///< not a function of the specification
    items,         ///< byte count, the items that were read
    repeated,      ///< the request itself
    head,          ///< address and quantity of the request
    status,        ///< fields of a fixed length
    event_log,     ///< byte count, status, two counters, events
    server_id,     ///< byte count, data
    records,       ///< byte count, file records
    queue,         ///< a count of bytes (two bytes), a count of registers, registers
    sub_function,  ///< sub-function, data
    encapsulated,  ///< MEI type, data
};

/// The fixed properties of a function: one row of the only table of them. All modules derive lengths, limits
/// and permissions from it.
struct FunctionProperties {
    Function function = Function{0};
    Effect effect = Effect::write;  ///< of 0x08 and 0x2B see wire::effect()
    RequestForm request = RequestForm::unknown;
    ResponseForm response = ResponseForm::unknown;
    Area area = Area::holding_register;  ///< of its items; of a function without items holding registers
    /// Bytes of the request PDU. Where counts_request(), the last of them is a byte count: as many bytes
    /// follow. Of 0x08 with two bytes of data.
    std::uint8_t request_bytes = 0;
    /// Bytes of a normal response PDU, without those behind a byte count. Of 0x08 with two bytes of data.
    std::uint8_t response_bytes = 0;
    /// The greatest number of bytes of a normal response PDU.
    std::uint8_t most_response_bytes = 253;
    /// The greatest number of items in one request; of 0x17 the items read; 0 for functions without items.
    std::uint16_t most_items = 0;
    /// The greatest number of items that one request writes.
    std::uint16_t most_written = 0;

    /// The items are bits, not registers.
    constexpr bool counts_bits() const { return most_items > 0 && is_bit_area(area); }
    /// The response is a byte count and the items that were read.
    constexpr bool returns_items() const { return response == ResponseForm::items; }
    /// The response repeats the request, or its head.
    constexpr bool echoes() const {
        return response == ResponseForm::repeated || response == ResponseForm::head;
    }
    /// It reads items and writes nothing: 0x01..0x04.
    constexpr bool only_reads_items() const { return request == RequestForm::range; }
    /// It writes items and reads nothing: 0x05, 0x06, 0x0F, 0x10, 0x16.
    constexpr bool only_writes_items() const { return most_written > 0 && echoes(); }
    /// It writes one item whose value is in the request: 0x05, 0x06.
    constexpr bool writes_single() const { return request == RequestForm::single; }
    /// Whether the last of request_bytes is a byte count.
    constexpr bool counts_request() const {
        return request == RequestForm::values || request == RequestForm::exchange ||
               request == RequestForm::records;
    }
};

/// The functions of the specification in the order of their codes (sections 6.1 to 6.21), behind one row for
/// all other codes.
inline constexpr auto kFunctions = [] {
    using F = Function;
    using E = Effect;
    using Q = RequestForm;
    using R = ResponseForm;
    constexpr auto kCoil = Area::coil;
    constexpr auto kDiscrete = Area::discrete_input;
    constexpr auto kInput = Area::input_register;
    constexpr auto kHolding = Area::holding_register;
    return std::to_array<FunctionProperties>({
        {},
        {F::read_coils, E::read, Q::range, R::items, kCoil, 5, 2, 252, 2000, 0},
        {F::read_discrete_inputs, E::read, Q::range, R::items, kDiscrete, 5, 2, 252, 2000, 0},
        {F::read_holding_registers, E::read, Q::range, R::items, kHolding, 5, 2, 252, 125, 0},
        {F::read_input_registers, E::read, Q::range, R::items, kInput, 5, 2, 252, 125, 0},
        {F::write_single_coil, E::write, Q::single, R::repeated, kCoil, 5, 5, 5, 1, 1},
        {F::write_single_register, E::write, Q::single, R::repeated, kHolding, 5, 5, 5, 1, 1},
        {F::read_exception_status, E::read, Q::empty, R::status, kHolding, 1, 2, 2, 0, 0},
        {F::diagnostics, E::diagnostic, Q::sub_function, R::sub_function, kHolding, 5, 5, 253, 0, 0},
        {F::get_comm_event_counter, E::diagnostic, Q::empty, R::status, kHolding, 1, 5, 5, 0, 0},
        {F::get_comm_event_log, E::diagnostic, Q::empty, R::event_log, kHolding, 1, 2, 72, 0, 0},
        {F::write_multiple_coils, E::write, Q::values, R::head, kCoil, 6, 5, 5, 1968, 1968},
        {F::write_multiple_registers, E::write, Q::values, R::head, kHolding, 6, 5, 5, 123, 123},
        {F::report_server_id, E::read, Q::empty, R::server_id, kHolding, 1, 2, 253, 0, 0},
        {F::read_file_record, E::read, Q::records, R::records, kHolding, 2, 2, 253, 0, 0},
        {F::write_file_record, E::write, Q::records, R::repeated, kHolding, 2, 2, 253, 0, 0},
        {F::mask_write_register, E::write, Q::masks, R::repeated, kHolding, 7, 7, 7, 1, 1},
        {F::read_write_multiple_registers, E::write, Q::exchange, R::items, kHolding, 10, 2, 252, 125, 121},
        {F::read_fifo_queue, E::read, Q::queue, R::queue, kHolding, 3, 5, 67, 0, 0},
        {F::encapsulated_interface, E::diagnostic, Q::encapsulated, R::encapsulated, kHolding, 2, 2, 253, 0,
         0},
    });
}();

/// By code: the row of kFunctions.
inline constexpr auto kFunctionRows = [] {
    std::array<std::uint8_t, 0x2C> rows{};
    for (std::size_t row = 1; row < kFunctions.size(); ++row)
        rows[static_cast<std::uint8_t>(kFunctions[row].function)] = static_cast<std::uint8_t>(row);
    return rows;
}();

/// The row of kFunctions of any function.
constexpr std::size_t row_of(Function function) {
    const auto code = static_cast<std::uint8_t>(function);
    return code < kFunctionRows.size() ? kFunctionRows[code] : 0;
}

constexpr const FunctionProperties& properties(Function function) {
    return kFunctions[row_of(function)];
}

/// True for the functions of the specification.
constexpr bool is_known(Function function) {
    return row_of(function) != 0;
}

/// English name as in the specification: "read holding registers"; "function" for an unknown one.
std::string_view name(Function function);

// Quantities that the specification allows (section 6).
inline constexpr std::size_t kMaxReadBits = properties(Function::read_coils).most_items;
inline constexpr std::size_t kMaxReadRegisters = properties(Function::read_holding_registers).most_items;
inline constexpr std::size_t kMaxWriteBits = properties(Function::write_multiple_coils).most_items;
inline constexpr std::size_t kMaxWriteRegisters = properties(Function::write_multiple_registers).most_items;
inline constexpr std::size_t kMaxReadWriteRegisters =  ///< written by 0x17
    properties(Function::read_write_multiple_registers).most_written;

/// The area of the items of a function; of a function without items holding registers.
constexpr Area area_of(Function function) {
    return properties(function).area;
}

/// The function that reads the area: 0x01 to 0x04.
constexpr Function read_function(Area area) {
    for (const auto& row : kFunctions)
        if (row.only_reads_items() && row.area == area) return row.function;
    return Function::read_holding_registers;
}

/// The function that writes one item (0x05, 0x06) or several (0x0F, 0x10).
/// @param bits  coils, else holding registers
constexpr Function write_function(bool bits, bool single) {
    if (bits) return single ? Function::write_single_coil : Function::write_multiple_coils;
    return single ? Function::write_single_register : Function::write_multiple_registers;
}

/// The MEI type of the encapsulated interface (0x2B) that reads the device identification.
inline constexpr std::uint8_t kReadDeviceId = 14;
/// "More follows" in a response to it.
inline constexpr std::uint8_t kMoreFollows = 0xFF;

/// The value of a coil that is switched on by 0x05.
inline constexpr std::uint16_t kCoilOn = 0xFF00;

/// The sub-function of 0x08 that returns its data, of any length.
inline constexpr std::uint16_t kReturnQueryData = 0;

/// The effect of a request: diagnostics (0x08) and the encapsulated interface (0x2B) depend on their
/// sub-function or MEI type. A request too short to have one changes nothing.
[[nodiscard]] Effect effect(Function function, std::optional<std::uint16_t> sub_function);

/// Whether the items of the function are bits (0x01, 0x02, 0x05, 0x0F) rather than registers.
constexpr bool counts_bits(Function function) {
    return properties(function).counts_bits();
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

}  // namespace takt::wire
