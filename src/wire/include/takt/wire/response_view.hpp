// A decoded response without a copy: views of the bytes that were received.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/assert.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/wire/function.hpp"

namespace takt::wire {

/// Registers as they lie in a PDU: two bytes each, the high byte first. Points into the PDU.
class RegisterView {
public:
    constexpr RegisterView() = default;
    /// @param bytes  two for each register
    explicit constexpr RegisterView(Bytes bytes) : bytes_(bytes) { TAKT_ASSERT(bytes.size() % 2 == 0); }

    [[nodiscard]] constexpr std::size_t size() const { return bytes_.size() / 2; }
    [[nodiscard]] constexpr bool empty() const { return bytes_.empty(); }
    [[nodiscard]] constexpr std::uint16_t operator[](std::size_t index) const {
        TAKT_ASSERT(index < size());
        return static_cast<std::uint16_t>(bytes_[2 * index] << 8 | bytes_[2 * index + 1]);
    }
    /// first + count <= size()
    [[nodiscard]] constexpr RegisterView subview(std::size_t first, std::size_t count) const {
        TAKT_ASSERT(first + count <= size());
        return RegisterView(bytes_.subspan(2 * first, 2 * count));
    }
    /// @param registers  size() of them
    constexpr void copy_to(std::span<std::uint16_t> registers) const {
        TAKT_ASSERT(registers.size() == size());
        for (std::size_t i = 0; i < registers.size(); ++i) registers[i] = (*this)[i];
    }

private:
    Bytes bytes_;
};

/// Bits as they lie in a PDU: the first in the lowest bit of the first byte. Points into the PDU.
class BitView {
public:
    constexpr BitView() = default;
    /// @param bytes  at least ceil(size / 8)
    constexpr BitView(Bytes bytes, std::size_t size) : bytes_(bytes), size_(size) {
        TAKT_ASSERT(bytes.size() >= (size + 7) / 8);
    }

    [[nodiscard]] constexpr std::size_t size() const { return size_; }
    [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
    [[nodiscard]] constexpr bool operator[](std::size_t index) const {
        TAKT_ASSERT(index < size_);
        return (bytes_[index / 8] >> (index % 8) & 1) != 0;
    }

private:
    Bytes bytes_;
    std::size_t size_ = 0;
};

/// One object of a device identification.
struct DeviceIdText {
    std::uint8_t id = 0;
    Bytes text;  ///< as received
};

/// The objects of a device identification, in their order. Points into the PDU.
class DeviceIdTexts {
public:
    /// @param objects  of each its id, its length and its text
    explicit constexpr DeviceIdTexts(Bytes objects) : left_(objects) {}

    [[nodiscard]] constexpr bool empty() const { return left_.empty(); }
    /// The next object; not empty().
    [[nodiscard]] constexpr DeviceIdText take() {
        constexpr std::size_t kHead = 2;
        const DeviceIdText object{left_[0], left_.subspan(kHead, left_[1])};
        left_ = left_.subspan(kHead + object.text.size());
        return object;
    }

private:
    Bytes left_;
};

/// One page of a device identification (0x2B, MEI type 14). Points into the PDU.
class DeviceIdView {
public:
    static constexpr std::size_t kObjectsAt = 7;  ///< behind the six bytes that describe the page

    /// @param pdu  a response with at least these bytes, whose objects end where it ends
    explicit constexpr DeviceIdView(Bytes pdu) : pdu_(pdu) { TAKT_ASSERT(pdu.size() >= kObjectsAt); }

    [[nodiscard]] constexpr std::uint8_t conformity() const { return pdu_[3]; }
    [[nodiscard]] constexpr bool more_follows() const { return pdu_[4] != 0; }
    /// The first object of the next page, where more follows.
    [[nodiscard]] constexpr std::uint8_t next_object() const { return pdu_[5]; }
    [[nodiscard]] constexpr DeviceIdTexts objects() const { return DeviceIdTexts(pdu_.subspan(kObjectsAt)); }

private:
    Bytes pdu_;
};

struct RequestShape;

/// A response that was checked against its request (decode_response() of prepared_request.hpp). It holds no
/// bytes of its own: it is valid as long as the buffer that it points into.
class ResponseView {
public:
    /// No response.
    constexpr ResponseView() = default;
    /// The response to a request that this program cannot decode: its bytes, without items.
    explicit constexpr ResponseView(Bytes pdu) : pdu_(pdu) {}

    [[nodiscard]] constexpr bool empty() const { return pdu_.empty(); }
    /// All bytes, the function code first.
    [[nodiscard]] constexpr Bytes pdu() const { return pdu_; }

    [[nodiscard]] constexpr bool is_exception() const { return content_ == Content::exception; }
    /// The code of an exception, any byte.
    [[nodiscard]] constexpr std::uint8_t exception() const { return is_exception() ? pdu_[1] : 0; }

    /// 0x03, 0x04, 0x17: as many registers as were asked for; 0x18: the queue. Else none.
    [[nodiscard]] constexpr RegisterView registers() const {
        if (content_ != Content::registers) return {};
        return RegisterView(pdu_.subspan(first_, std::size_t{2} * count_));
    }
    /// 0x01, 0x02: as many bits as were asked for. Else none.
    [[nodiscard]] constexpr BitView bits() const {
        if (content_ != Content::bits) return {};
        return {pdu_.subspan(first_), count_};
    }
    /// 0x2B with MEI type 14. Else nothing.
    [[nodiscard]] constexpr std::optional<DeviceIdView> device_id() const {
        if (content_ != Content::device_id) return {};
        return DeviceIdView(pdu_);
    }

    /// The same response after its bytes were copied to another buffer.
    [[nodiscard]] constexpr ResponseView moved_to(Bytes pdu) const {
        TAKT_ASSERT(pdu.size() == pdu_.size());
        ResponseView moved = *this;
        moved.pdu_ = pdu;
        return moved;
    }

private:
    friend Result<ResponseView> decode_response(const RequestShape& shape, Bytes request, Bytes pdu);

    enum class Content : std::uint8_t { other, exception, bits, registers, device_id };

    constexpr ResponseView(Bytes pdu, Content content, std::size_t first = 0, std::size_t count = 0)
        : pdu_(pdu),
          count_(static_cast<std::uint16_t>(count)),
          first_(static_cast<std::uint8_t>(first)),
          content_(content) {}

    Bytes pdu_;
    std::uint16_t count_ = 0;  // items
    std::uint8_t first_ = 0;   // where they begin in the PDU
    Content content_ = Content::other;
};

}  // namespace takt::wire
