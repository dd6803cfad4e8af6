// RTU frames have no length field (MODBUS over Serial Line V1.02, section 2.5.1.1). A receiver that knows the
// functions derives the length from the function code and the byte counts (MODBUS Application Protocol
// V1.1b3, section 6), and so needs no silence to find the end of a frame.
#include "expected_length.hpp"

#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

constexpr std::size_t kCrc = 2;
constexpr std::uint8_t kReadDeviceId = 14;

// The byte at `index` is the number of bytes between it and the CRC; it is at least `least`.
std::size_t counted(Bytes frame, std::size_t index, std::size_t least) {
    if (frame.size() <= index || frame[index] < least) return 0;
    return index + 1 + frame[index] + kCrc;
}

std::size_t counted_registers(Bytes frame) {
    const std::size_t length = counted(frame, 2, 2);
    return length % 2 == 1 ? length : 0;  // address, function, count, pairs of bytes, CRC
}

// 0x18: the byte count has two bytes.
std::size_t fifo_response(Bytes frame) {
    if (frame.size() < 4) return 0;
    return 4U + (std::size_t{frame[2]} << 8 | frame[3]) + kCrc;
}

std::size_t device_id_request(Bytes frame) {
    if (frame.size() < 3 || frame[2] != kReadDeviceId) return 0;
    return 5 + kCrc;
}

// 0x2B / 14: a list of objects, each with an id, a length and a text.
std::size_t device_id_response(Bytes frame) {
    constexpr std::size_t kCountAt = 7;
    if (frame.size() <= kCountAt || frame[2] != kReadDeviceId) return 0;
    std::size_t next = kCountAt + 1;
    for (unsigned object = 0; object < frame[kCountAt]; ++object) {
        if (frame.size() < next + 2) return 0;
        next += 2U + frame[next + 1];
    }
    return next + kCrc;
}

std::size_t request_length(Bytes frame) {
    switch (static_cast<Function>(frame[1])) {
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::diagnostics: return 8;
        case Function::read_exception_status:
        case Function::get_comm_event_counter:
        case Function::get_comm_event_log:
        case Function::report_server_id: return 4;
        case Function::write_multiple_coils:
        case Function::write_multiple_registers: return counted(frame, 6, 1);
        case Function::read_file_record:
        case Function::write_file_record: return counted(frame, 2, 1);
        case Function::mask_write_register: return 10;
        case Function::read_write_multiple_registers: return counted(frame, 10, 1);
        case Function::read_fifo_queue: return 6;
        case Function::encapsulated_interface: return device_id_request(frame);
    }
    return 0;
}

std::size_t response_length(Bytes frame) {
    if (is_exception(frame[1])) return 5;
    switch (static_cast<Function>(frame[1])) {
        case Function::read_holding_registers:
        case Function::read_input_registers:
        case Function::read_write_multiple_registers: return counted_registers(frame);
        case Function::read_coils:
        case Function::read_discrete_inputs:
        case Function::get_comm_event_log:
        case Function::read_file_record:
        case Function::write_file_record: return counted(frame, 2, 1);
        case Function::report_server_id: return counted(frame, 2, 0);
        case Function::write_single_coil:
        case Function::write_single_register:
        case Function::write_multiple_coils:
        case Function::write_multiple_registers:
        case Function::diagnostics:
        case Function::get_comm_event_counter: return 8;
        case Function::read_exception_status: return 5;
        case Function::mask_write_register: return 10;
        case Function::read_fifo_queue: return fifo_response(frame);
        case Function::encapsulated_interface: return device_id_response(frame);
    }
    return 0;
}

std::size_t possible(std::size_t length) {
    return length <= kMaxRtuFrame ? length : 0;
}

}  // namespace

// 0x08 has two data bytes, except for a longer loopback (sub-function 0), which only a silence ends.

std::size_t expected_request_length(Bytes frame) {
    return frame.size() < 2 ? 0 : possible(request_length(frame));
}

std::size_t expected_response_length(Bytes frame) {
    return frame.size() < 2 ? 0 : possible(response_length(frame));
}

}  // namespace takt::wire
