// A decoded request without a copy: views of the bytes that were received.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/assert.hpp"
#include "takt/base/engine.hpp"
#include "takt/wire/function.hpp"

namespace takt::wire {

/// Items of one area that a request reads or writes. Behind item 65535 they continue at 0, because a device
/// may do the same.
struct ItemAccess {
    Area area = Area::holding_register;
    bool write = false;
    std::uint16_t start = 0;
    std::uint16_t count = 1;  ///< at least 1
};

/// One part of a request for file records (0x14, 0x15).
struct FilePart {
    std::uint16_t file = 0;
    std::uint16_t record = 0;  ///< the first one
    std::uint16_t length = 0;  ///< 1..124 records of one register
    Bytes values;              ///< of a write, two bytes a register
};

/// The parts of a well-formed request for file records, in their order.
class FileParts {
public:
    FileParts(Bytes parts, bool write) : left_(parts), write_(write) {}

    [[nodiscard]] bool empty() const { return left_.empty(); }
    /// The next part; not empty().
    [[nodiscard]] FilePart take();

private:
    Bytes left_;
    bool write_;
};

/// A request as a server, its access rules and a gateway need it, decoded once from bytes of which nothing is
/// assumed. It holds no bytes of its own: it is valid as long as the buffer that it points into.
///
/// A malformed request has a view too, because access rules decide about it before it is answered with an
/// exception: its accesses are those that its bytes show.
class RequestView {
public:
    /// No request.
    constexpr RequestView() = default;
    /// Decodes a request. @param pdu  at most kMaxPdu bytes; none: no request
    explicit RequestView(Bytes pdu);

    [[nodiscard]] constexpr bool empty() const { return pdu_.empty(); }
    /// All bytes, the function code first.
    [[nodiscard]] constexpr Bytes pdu() const { return pdu_; }
    /// Any byte, see is_known(). There is a request.
    [[nodiscard]] constexpr Function function() const { return Function{pdu_[0]}; }

    /// The function is known; length, byte counts, quantities and fixed values are those of the
    /// specification. Addresses are not judged. decode_request() has a result for the same requests.
    [[nodiscard]] constexpr bool well_formed() const { return well_formed_; }
    /// Diagnostics (0x08) and the encapsulated interface (0x2B) depend on their sub-function. A request too
    /// short to have one changes nothing; an unknown function counts as a write.
    [[nodiscard]] Effect effect() const { return wire::effect(function(), sub_function_); }

    /// 0x01..0x06, 0x0F, 0x10, 0x16, 0x18: one; 0x17: the read, then the write; else none. A malformed
    /// request has those whose address and quantity are present, with the quantity that it gives, but at
    /// least 1.
    [[nodiscard]] constexpr std::span<const ItemAccess> accesses() const {
        return std::span(accesses_).first(access_count_);
    }
    /// Of a well-formed write of items, as on the wire: bits from the lowest of the first byte on, registers
    /// high byte first; the value of a single coil (0x05) as two bytes; both masks of 0x16, AND first.
    [[nodiscard]] constexpr Bytes values() const {
        return well_formed_ && values_at_ > 0 ? pdu_.subspan(values_at_) : Bytes{};
    }

    /// Of 0x08; of 0x2B the MEI type. Nothing where the request is too short.
    [[nodiscard]] constexpr std::optional<std::uint16_t> sub_function() const { return sub_function_; }
    /// The bytes behind function and sub-function of 0x08 and 0x2B; of any other one those behind the
    /// function.
    [[nodiscard]] constexpr Bytes data() const { return pdu_.subspan(data_at_); }
    /// Of a well-formed 0x14 or 0x15.
    [[nodiscard]] FileParts file_parts() const {
        return {pdu_.subspan(kFilePartsAt), function() == Function::write_file_record};
    }

    /// The same request after its bytes were copied to another buffer.
    [[nodiscard]] constexpr RequestView moved_to(Bytes pdu) const {
        TAKT_ASSERT(pdu.size() == pdu_.size());
        RequestView moved = *this;
        moved.pdu_ = pdu;
        return moved;
    }

private:
    static constexpr std::size_t kFilePartsAt = 2;  // behind function and byte count

    [[nodiscard]] std::uint16_t word(std::size_t at) const;
    void add_access(std::size_t at, Area area, bool write, bool counted = true);
    void decode_sub_function(std::size_t size);
    bool decode_single_write(const FunctionProperties& row);
    bool decode_values(const FunctionProperties& row);
    bool decode_write(const FunctionProperties& row);
    bool decode_read_write(const FunctionProperties& row);
    [[nodiscard]] bool check_diagnostics() const;
    [[nodiscard]] bool check_encapsulated() const;
    [[nodiscard]] bool check_files() const;
    [[nodiscard]] bool counted(std::size_t at, std::size_t bytes) const;
    bool decode();

    Bytes pdu_;
    std::array<ItemAccess, 2> accesses_{};
    std::uint8_t access_count_ = 0;
    std::uint8_t values_at_ = 0;  // 0: no values
    std::uint8_t data_at_ = 0;
    bool well_formed_ = false;
    std::optional<std::uint16_t> sub_function_;
};

}  // namespace takt::wire
