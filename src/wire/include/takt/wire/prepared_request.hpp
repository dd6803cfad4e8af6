// A request ready to be sent: its bytes, and their decoded properties.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/result.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/request_view.hpp"
#include "takt/wire/response_view.hpp"

namespace takt::wire {

/// The properties of a request by which a master recognises its response.
struct RequestShape {
    std::uint8_t function = 0;  ///< as on the wire, any byte
    /// The request can be decoded. Of any other request only the function is known.
    bool decoded = false;
    bool repeated = false;  ///< the normal response is the request itself: 0x05, 0x06, 0x15, 0x16, most 0x08
    bool fixed_length = false;  ///< every normal response has response_length bytes
    Effect effect = Effect::write;
    /// 0x01..0x06, 0x0F, 0x10, 0x16: the items read or written; 0x17: the items read.
    DataAddress start;
    std::uint16_t quantity = 0;
    /// Of a normal response PDU: the greatest number of bytes.
    std::uint16_t response_length = kMaxPdu;

    friend constexpr bool operator==(const RequestShape&, const RequestShape&) = default;
};

/// The shape of a request; nothing is decoded from its bytes.
[[nodiscard]] RequestShape shape_of(const ReadRequest& request);
[[nodiscard]] RequestShape shape_of(const RequestView& request);

/// A read ready to be sent, in 18 bytes: for owners that keep many and send them again and again.
class PreparedRead {
public:
    [[nodiscard]] Bytes pdu() const { return pdu_; }
    [[nodiscard]] const RequestShape& shape() const { return shape_; }
    [[nodiscard]] Function function() const { return Function{shape_.function}; }
    [[nodiscard]] DataAddress start() const { return shape_.start; }
    [[nodiscard]] std::uint16_t quantity() const { return shape_.quantity; }

private:
    friend Result<PreparedRead> prepare(const ReadRequest& request);
    PreparedRead() = default;

    std::array<std::uint8_t, 5> pdu_{};
    RequestShape shape_;
};

/// The bytes of a request with their shape. It is made once and passed on as a whole, so that no receiver
/// decodes the bytes again.
class PreparedRequest {
public:
    /// Empty: nothing that can be sent.
    PreparedRequest() = default;
    /// A request that someone else encoded; its bytes are copied.
    explicit PreparedRequest(const RequestView& request);
    /// Decodes such a request. Nothing is assumed of the bytes, at most kMaxPdu.
    explicit PreparedRequest(Bytes pdu);
    PreparedRequest(const Pdu& pdu) : PreparedRequest(pdu.span()) {}
    PreparedRequest(const PreparedRead& read) : shape_(read.shape()) { pdu_.assign(read.pdu()); }

    [[nodiscard]] Bytes pdu() const { return pdu_.span(); }
    [[nodiscard]] const RequestShape& shape() const { return shape_; }
    [[nodiscard]] std::uint8_t function() const { return shape_.function; }
    [[nodiscard]] bool only_reads() const { return shape_.effect == Effect::read; }
    [[nodiscard]] bool empty() const { return pdu_.empty(); }
    [[nodiscard]] std::size_t size() const { return pdu_.size(); }

    friend bool operator==(const PreparedRequest& a, const PreparedRequest& b) { return a.pdu_ == b.pdu_; }

private:
    friend Result<PreparedRequest> prepare(const Request& request);
    friend Result<PreparedRequest> prepare_write(Function, DataAddress, const Bits&, const Registers&);
    friend Result<PreparedRequest> prepare(const MaskWriteRegisterRequest& request);
    PreparedRequest(const Pdu& pdu, const RequestShape& shape) : pdu_(pdu), shape_(shape) {}

    Pdu pdu_;
    RequestShape shape_;
};

/// The request that writes those items with 0x05, 0x06, 0x0F or 0x10.
/// @param bits       of a function that counts bits, else empty
/// @param registers  of any other function
/// @returns unsupported for another function, no items, and several ones of 0x05 or 0x06
[[nodiscard]] Result<Request> write_request(Function function, DataAddress start, const Bits& bits,
                                            const Registers& registers);

/// Encodes a request. A program that calls the first one holds the codecs of all requests.
/// @returns what encode() returns
[[nodiscard]] Result<PreparedRequest> prepare(const Request& request);
/// write_request(), encoded.
[[nodiscard]] Result<PreparedRequest> prepare_write(Function function, DataAddress start, const Bits& bits,
                                                    const Registers& registers);
[[nodiscard]] Result<PreparedRead> prepare(const ReadRequest& request);
[[nodiscard]] Result<PreparedRequest> prepare(const MaskWriteRegisterRequest& request);

/// Recognises a response as a master does: whether `pdu` answers the request with that shape and those bytes.
/// Of a request that could not be decoded, every response with its function does.
/// @returns a view into `pdu`, an exception of the request's function among others; unexpected_reply for
///          another function, or a confirmation that differs; malformed for a length that does not fit
[[nodiscard]] Result<ResponseView> decode_response(const RequestShape& shape, Bytes request, Bytes pdu);

}  // namespace takt::wire
