// RTU frames have no length field (MODBUS over Serial Line V1.02, section 2.5.1.1). A receiver that knows the
// functions derives the length from the function code and the byte counts (MODBUS Application Protocol
// V1.1b3, section 6), and so needs no silence to find the end of a frame.
#include "takt/wire/expected_length.hpp"

#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

constexpr std::size_t kCrc = 2;
constexpr std::size_t kAddressAndCrc = 1 + kCrc;  // address and CRC

// The byte at `index` is the number of bytes between it and the CRC; it is at least `least`.
std::size_t counted_length(Bytes frame, std::size_t index, std::size_t least) {
    if (frame.size() <= index || frame[index] < least) return 0;
    return index + 1 + frame[index] + kCrc;
}

std::size_t counted_registers(Bytes frame) {
    const std::size_t length = counted_length(frame, 2, 2);
    return length % 2 == 1 ? length : 0;  // address, function, count, pairs of bytes, CRC
}

// 0x18: the byte count has two bytes.
std::size_t fifo_response(Bytes frame) {
    if (frame.size() < 4) return 0;
    return 4U + word_at(frame, 2) + kCrc;
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

// Behind the address, the bytes of a PDU have their index + 1.
std::size_t request_length(Bytes frame) {
    const auto& row = properties(Function{frame[1]});
    if (row.request == RequestForm::unknown) return 0;
    if (row.request == RequestForm::encapsulated) return device_id_request(frame);
    return row.counts_request() ? counted_length(frame, row.request_bytes, 1)
                                : row.request_bytes + kAddressAndCrc;
}

std::size_t response_length(Bytes frame) {
    if (is_exception(frame[1])) return 2 + kAddressAndCrc;
    const auto& row = properties(Function{frame[1]});
    switch (row.response) {
        case ResponseForm::items:
            return row.counts_bits() ? counted_length(frame, row.response_bytes, 1)
                                     : counted_registers(frame);
        case ResponseForm::repeated: return request_length(frame);
        case ResponseForm::head:
        case ResponseForm::status:
        case ResponseForm::sub_function: return row.response_bytes + kAddressAndCrc;
        case ResponseForm::event_log:
        case ResponseForm::records: return counted_length(frame, row.response_bytes, 1);
        case ResponseForm::server_id: return counted_length(frame, row.response_bytes, 0);
        case ResponseForm::queue: return fifo_response(frame);
        case ResponseForm::encapsulated: return device_id_response(frame);
        case ResponseForm::unknown: break;
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
