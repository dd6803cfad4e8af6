// The first byte of a PDU is its function; a response with the highest bit set is an exception with one more
// byte (MODBUS Application Protocol V1.1b3, sections 4.1 and 7). The functions are decoded in families, each
// in a file of its own. Bits are packed eight to a byte, the first one in the lowest bit (section 6.1).
#include "takt/wire/pdu.hpp"

#include <algorithm>

#include "codec.hpp"
#include "takt/base/assert.hpp"
#include "takt/wire/frame.hpp"

namespace takt::wire {
namespace {

enum class Family : std::uint8_t { none, data, status, file, encapsulated };

Family family_of(Function function) {
    switch (properties(function).request) {
        case RequestForm::range:
        case RequestForm::single:
        case RequestForm::masks:
        case RequestForm::values:
        case RequestForm::exchange: return Family::data;
        case RequestForm::empty:
        case RequestForm::sub_function: return Family::status;
        case RequestForm::records:
        case RequestForm::queue: return Family::file;
        case RequestForm::encapsulated: return Family::encapsulated;
        case RequestForm::unknown: break;
    }
    return Family::none;
}

Result<void> check_size(Bytes pdu) {
    if (pdu.empty()) return fail(Code::too_short, 0, 1);
    if (pdu.size() > kMaxPdu) return fail(Code::too_long, static_cast<std::int64_t>(pdu.size()), kMaxPdu);
    return {};
}

Result<Response> decode_exception(Bytes pdu) {
    codec::Reader in(pdu);
    const std::uint8_t code = in.u8();
    TAKT_CHECK(in.finish());
    return ExceptionResponse{static_cast<Function>(requested_function(pdu[0])),
                             static_cast<ExceptionCode>(code)};
}

}  // namespace

Bits::Bits(std::size_t count) : size_(count) {
    TAKT_ASSERT(count <= kCapacity);
}

bool Bits::operator[](std::size_t index) const {
    TAKT_ASSERT(index < size_);
    return (bytes_[index / 8] >> (index % 8) & 1) != 0;
}

void Bits::set(std::size_t index, bool on) {
    TAKT_ASSERT(index < size_);
    const unsigned mask = 1U << (index % 8);
    const unsigned byte = bytes_[index / 8];
    bytes_[index / 8] = static_cast<std::uint8_t>(on ? byte | mask : byte & ~mask);
}

void Bits::push_back(bool on) {
    TAKT_ASSERT(size_ < kCapacity);
    ++size_;
    set(size_ - 1, on);
}

Bits Bits::from_bytes(Bytes bytes, std::size_t count) {
    Bits bits(count);
    TAKT_ASSERT(bytes.size() >= bits.byte_count());
    std::copy_n(bytes.begin(), bits.byte_count(), bits.bytes_.begin());
    for (std::size_t surplus = count; surplus % 8 != 0; ++surplus)
        bits.bytes_[surplus / 8] &= static_cast<std::uint8_t>(~(1U << (surplus % 8)));
    return bits;
}

bool operator==(const Bits& a, const Bits& b) {
    return a.size_ == b.size_ && std::ranges::equal(a.bytes(), b.bytes());
}

Function function_of(const Request& request) {
    return std::visit([](const auto& message) { return message.function; }, request);
}

Result<Pdu> encode(const Request& request) {
    return std::visit([](const auto& message) { return codec::encode(message); }, request);
}

Result<Request> decode_request(Bytes pdu) {
    TAKT_CHECK(check_size(pdu));
    const auto function = static_cast<Function>(pdu[0]);
    switch (family_of(function)) {
        case Family::data: return codec::decode_data_request(function, codec::Reader(pdu));
        case Family::status: return codec::decode_status_request(function, codec::Reader(pdu));
        case Family::file: return codec::decode_file_request(function, codec::Reader(pdu));
        case Family::encapsulated: return codec::decode_encapsulated_request(codec::Reader(pdu));
        case Family::none: break;
    }
    return fail(Code::unsupported, pdu[0]);
}

Result<Response> decode_response(Bytes pdu) {
    TAKT_CHECK(check_size(pdu));
    if (is_exception(pdu[0])) return decode_exception(pdu);
    const auto function = static_cast<Function>(pdu[0]);
    switch (family_of(function)) {
        case Family::data: return codec::decode_data_response(function, codec::Reader(pdu));
        case Family::status: return codec::decode_status_response(function, codec::Reader(pdu));
        case Family::file: return codec::decode_file_response(function, codec::Reader(pdu));
        case Family::encapsulated: return codec::decode_encapsulated_response(codec::Reader(pdu));
        case Family::none: break;
    }
    return fail(Code::unsupported, pdu[0]);
}

}  // namespace takt::wire
