// Encodes responses: what a slave that is written for a test answers. Takt's own slave answers with bytes.
#pragma once

#include <span>
#include <variant>

#include "takt/wire/frame.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {

/// Appends the fields of a response behind its function code. Lengths are counted, not checked.
struct ResponseEncoder {
    Pdu& pdu;

    void u8(std::size_t value) const { pdu.push_back(static_cast<std::uint8_t>(value)); }
    void u16(std::size_t value) const {
        u8(value >> 8);
        u8(value);
    }
    void registers(std::span<const std::uint16_t> values) const {
        for (const std::uint16_t value : values) u16(value);
    }

    void operator()(const ExceptionResponse& r) const { u8(static_cast<std::uint8_t>(r.code)); }
    void operator()(const ReadBitsResponse& r) const {
        u8(r.values.byte_count());
        pdu.append(r.values.bytes());
    }
    void operator()(const ReadRegistersResponse& r) const {
        u8(2 * r.values.size());
        registers(r.values.span());
    }
    void operator()(const WriteMultipleResponse& r) const {
        u16(r.start.value);
        u16(r.quantity);
    }
    void operator()(const ReadExceptionStatusResponse& r) const { u8(r.status); }
    void operator()(const DiagnosticsResponse& r) const {
        u16(r.sub_function);
        pdu.append(r.data.span());
    }
    void operator()(const GetCommEventCounterResponse& r) const {
        u16(r.status);
        u16(r.event_count);
    }
    void operator()(const GetCommEventLogResponse& r) const {
        u8(6 + r.events.size());
        u16(r.status);
        u16(r.event_count);
        u16(r.message_count);
        pdu.append(r.events.span());
    }
    void operator()(const ReportServerIdResponse& r) const {
        u8(r.data.size());
        pdu.append(r.data.span());
    }
    void operator()(const ReadFileRecordResponse& r) const {
        u8(2 * (r.lengths.size() + r.values.size()));
        std::size_t first = 0;
        for (const std::uint16_t length : r.lengths) {
            u8(1U + 2U * length);
            u8(6);  // reference type
            registers(r.values.span().subspan(first, length));
            first += length;
        }
    }
    void operator()(const ReadFifoQueueResponse& r) const {
        u16(2 + 2 * r.values.size());
        u16(r.values.size());
        registers(r.values.span());
    }
    void operator()(const ReadDeviceIdResponse& r) const {
        for (const std::uint8_t byte : {std::uint8_t{14}, r.code, r.conformity}) u8(byte);
        u8(r.more_follows ? 0xFF : 0);
        u8(r.next_object);
        u8(r.objects.size());
        std::size_t first = 0;
        for (const DeviceIdObject& object : r.objects) {
            u8(object.id);
            u8(object.length);
            pdu.append(r.text.span().subspan(first, object.length));
            first += object.length;
        }
    }
    /// A response that repeats its request.
    template <class Repeated>
    void operator()(const Repeated& r) const {
        const auto request = encode(Request(r));
        if (request) pdu.append(request->span().subspan(1));
    }
};

/// Of an exception without 0x80.
inline Function function_of(const Response& response) {
    return std::visit([](const auto& message) { return message.function; }, response);
}

inline Result<Pdu> encode(const Response& response) {
    const auto function = static_cast<std::uint8_t>(function_of(response));
    const bool refused = std::holds_alternative<ExceptionResponse>(response);
    Pdu pdu{refused ? exception_function(function) : function};
    std::visit(ResponseEncoder{pdu}, response);
    return pdu;
}

}  // namespace takt::wire
