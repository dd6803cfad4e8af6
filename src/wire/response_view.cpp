// Whether a response answers the request that was sent, decided on the bytes of both (MODBUS Application
// Protocol V1.1b3, section 6): nothing is copied.
#include <algorithm>

#include "codec.hpp"
#include "item_limits.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::wire {
namespace {

Result<void> check_confirmation(bool same) {
    if (same) return {};
    return fail(Code::unexpected_reply);
}

/// The byte behind the function counts `count` bytes, and exactly they follow.
Result<void> check_counted(Bytes pdu, std::size_t count) {
    if (pdu.size() < 2) return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()), 2);
    TAKT_CHECK(codec::check_count(pdu[1], count));
    return codec::check_count(pdu.size(), 2 + count);
}

// Sub-function, then data as the request has it, or none.
Result<void> check_diagnostics_echo(Bytes request, Bytes pdu) {
    constexpr std::size_t kData = 3;
    if (pdu.size() < kData) return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()), kData);
    TAKT_CHECK(check_confirmation(word_at(pdu, 1) == word_at(request, 1)));
    if (pdu.size() == kData) return {};
    return codec::check_count(pdu.size(), request.size());
}

// Byte count, status, two counters, at most 64 events.
Result<void> check_event_log(Bytes pdu) {
    constexpr std::size_t kHeader = 6;
    if (pdu.size() < 2 + kHeader)
        return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()), 2 + kHeader);
    TAKT_CHECK(
        codec::check_range(pdu[1], kHeader, kHeader + decltype(GetCommEventLogResponse::events)::capacity()));
    return codec::check_count(pdu.size(), 2U + pdu[1]);
}

// For each range of the request (reference type, file, record, length: 7 bytes) a length, the reference type
// and the registers.
Result<void> check_file_records(Bytes request, Bytes pdu) {
    std::size_t next = 2;
    for (std::size_t range = 2; range < request.size(); range += kFileRange) {
        const std::size_t bytes = std::size_t{2} * word_at(request, range + kFileRange - 2);
        if (pdu.size() < next + 2 + bytes)
            return fail(Code::malformed, static_cast<std::int64_t>(pdu.size()),
                        static_cast<std::int64_t>(next + 2 + bytes));
        TAKT_CHECK(codec::check_count(pdu[next], 1 + bytes));
        TAKT_CHECK(codec::check_count(pdu[next + 1], kFileReferenceType));
        next += 2 + bytes;
    }
    return check_counted(pdu, next - 2);
}

// Two bytes count what follows, two more the registers of the queue, at most 31.
Result<void> check_fifo(Bytes pdu) {
    constexpr std::size_t kHeader = 5;
    if (pdu.size() < kHeader) return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()), kHeader);
    const std::size_t count = word_at(pdu, 3);
    TAKT_CHECK(codec::check_range(count, 0, kMaxFifoRegisters));
    TAKT_CHECK(codec::check_count(word_at(pdu, 1), 2 + 2 * count));
    return codec::check_count(pdu.size(), kHeader + 2 * count);
}

// MEI type, code, conformity, more follows, next object, number of objects; then of each its id, its length
// and its text.
Result<void> check_device_id(Bytes request, Bytes pdu) {
    constexpr std::size_t kHeader = DeviceIdView::kObjectsAt;
    TAKT_CHECK(check_confirmation(pdu.size() > 1 && pdu[1] == kReadDeviceId));
    if (pdu.size() < kHeader) return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()), kHeader);
    TAKT_CHECK(check_confirmation(pdu[2] == request[2]));
    if (pdu[4] != 0 && pdu[4] != kMoreFollows) return fail(Code::malformed, pdu[4]);
    std::size_t next = kHeader;
    for (unsigned object = 0; object < pdu[kHeader - 1]; ++object) {
        if (pdu.size() < next + 2)
            return fail(Code::too_short, static_cast<std::int64_t>(pdu.size()),
                        static_cast<std::int64_t>(next + 2));
        next += 2U + pdu[next + 1];
    }
    return codec::check_count(pdu.size(), next);
}

Result<void> check_encapsulated(Bytes request, Bytes pdu) {
    if (request[1] == kReadDeviceId) return check_device_id(request, pdu);
    return check_confirmation(pdu.size() > 1 && pdu[1] == request[1]);
}

}  // namespace

Result<ResponseView> decode_response(const RequestShape& shape, Bytes request, Bytes pdu) {
    using Content = ResponseView::Content;
    if (pdu.empty()) return fail(Code::too_short, 0, 1);
    if (pdu.size() > kMaxPdu) return fail(Code::too_long, static_cast<std::int64_t>(pdu.size()), kMaxPdu);
    if (pdu.size() == 2 && pdu[0] == exception_function(shape.function))
        return ResponseView(pdu, Content::exception);
    if (pdu[0] != shape.function) return fail(Code::unexpected_reply, pdu[0], shape.function);
    if (!shape.decoded) return ResponseView(pdu);
    if (shape.repeated) {
        TAKT_CHECK(check_confirmation(std::ranges::equal(pdu, request)));
        return ResponseView(pdu);
    }
    const auto& row = properties(Function{shape.function});
    switch (row.response) {
        case ResponseForm::items:
            TAKT_CHECK(
                check_counted(pdu, row.counts_bits() ? (shape.quantity + 7U) / 8 : 2U * shape.quantity));
            return ResponseView(pdu, row.counts_bits() ? Content::bits : Content::registers,
                                row.response_bytes, shape.quantity);
        case ResponseForm::head:
            TAKT_CHECK(check_confirmation(std::ranges::equal(pdu, request.first(shape.response_length))));
            break;
        case ResponseForm::status: TAKT_CHECK(codec::check_count(pdu.size(), shape.response_length)); break;
        case ResponseForm::event_log: TAKT_CHECK(check_event_log(pdu)); break;
        case ResponseForm::server_id: TAKT_CHECK(check_counted(pdu, pdu.size() - 2)); break;
        case ResponseForm::records: TAKT_CHECK(check_file_records(request, pdu)); break;
        case ResponseForm::queue:
            TAKT_CHECK(check_fifo(pdu));
            return ResponseView(pdu, Content::registers, row.response_bytes, word_at(pdu, 3));
        case ResponseForm::sub_function: TAKT_CHECK(check_diagnostics_echo(request, pdu)); break;
        case ResponseForm::encapsulated:
            TAKT_CHECK(check_encapsulated(request, pdu));
            return ResponseView(pdu, pdu[1] == kReadDeviceId ? Content::device_id : Content::other);
        case ResponseForm::repeated:  // checked above
        case ResponseForm::unknown: break;
    }
    return ResponseView(pdu);
}

// The bytes are decoded first, so that what is wrong with them by themselves is what is reported.
Result<Response> decode_response(const Request& request, Bytes pdu) {
    TAKT_TRY(Response response, [&]() -> Result<Response> {
        const auto asked = static_cast<std::uint8_t>(function_of(request));
        if (!pdu.empty() && requested_function(pdu[0]) != asked)
            return fail(Code::unexpected_reply, pdu[0], asked);
        return decode_response(pdu);
    }());
    if (std::holds_alternative<ExceptionResponse>(response)) return response;
    TAKT_TRY(const PreparedRequest prepared, prepare(request));
    TAKT_TRY(const ResponseView view, decode_response(prepared.shape(), prepared.pdu(), pdu));
    if (auto* bits = std::get_if<ReadBitsResponse>(&response))
        bits->values = Bits::from_bytes(bits->values.bytes(), view.bits().size());
    return response;
}

}  // namespace takt::wire
