// The form of every request (MODBUS Application Protocol V1.1b3, section 6), read where it lies. The
// functions of pdu.hpp decode the same requests into structures of their own.
#include "takt/wire/request_view.hpp"

#include <algorithm>

#include "item_limits.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {
namespace {

constexpr std::uint16_t kCoilOn = 0xFF00;
constexpr std::size_t kAddress = 1;   // where the first address is
constexpr std::size_t kQuantity = 3;  // and the first quantity, or the value of a single item

constexpr std::size_t kReadLength = 5;  // function, address, quantity
constexpr std::size_t kSingleLength = 5;
constexpr std::size_t kMaskLength = 7;
constexpr std::size_t kFifoLength = 3;

constexpr std::uint16_t kReturnQueryData = 0;

std::uint16_t word_at(Bytes bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

bool between_1_and(std::size_t most, std::size_t quantity) {
    return quantity >= 1 && quantity <= most;
}

}  // namespace

FilePart FileParts::take() {
    FilePart part{word_at(left_, 1), word_at(left_, 3), word_at(left_, 5), {}};
    const std::size_t bytes = write_ ? std::size_t{2} * part.length : 0;
    part.values = left_.subspan(kFileRange, bytes);
    left_ = left_.subspan(kFileRange + bytes);
    return part;
}

RequestView::RequestView(Bytes pdu) : pdu_(pdu) {
    TAKT_ASSERT(pdu.size() <= kMaxPdu);
    if (pdu.empty()) return;
    data_at_ = 1;
    well_formed_ = decode();
}

bool RequestView::decode() {
    const std::size_t size = pdu_.size();
    switch (function()) {
        case Function::read_coils: return decode_read(Area::coil, kMaxReadBits);
        case Function::read_discrete_inputs: return decode_read(Area::discrete_input, kMaxReadBits);
        case Function::read_holding_registers: return decode_read(Area::holding_register, kMaxReadRegisters);
        case Function::read_input_registers: return decode_read(Area::input_register, kMaxReadRegisters);
        case Function::write_single_coil:
            return decode_single_write(Area::coil, kSingleLength) &&
                   (word(kQuantity) == kCoilOn || word(kQuantity) == 0);
        case Function::write_single_register:
            return decode_single_write(Area::holding_register, kSingleLength);
        case Function::mask_write_register: return decode_single_write(Area::holding_register, kMaskLength);
        case Function::write_multiple_coils: return decode_write(Area::coil, kMaxWriteBits);
        case Function::write_multiple_registers:
            return decode_write(Area::holding_register, kMaxWriteRegisters);
        case Function::read_write_multiple_registers: return decode_read_write();
        case Function::read_exception_status:
        case Function::get_comm_event_counter:
        case Function::get_comm_event_log:
        case Function::report_server_id: return size == 1;
        case Function::diagnostics: decode_sub_function(2); return check_diagnostics();
        case Function::encapsulated_interface: decode_sub_function(1); return check_encapsulated();
        case Function::read_file_record:
        case Function::write_file_record: return check_files();
        case Function::read_fifo_queue:
            add_access(kAddress, Area::holding_register, false, false);
            return size == kFifoLength;
    }
    return false;
}

std::uint16_t RequestView::word(std::size_t at) const {
    return word_at(pdu_, at);
}

// The items whose address is at `at`, with their quantity behind it; none if the request is too short.
void RequestView::add_access(std::size_t at, Area area, bool write, bool counted) {
    if (pdu_.size() < at + (counted ? 4 : 2)) return;
    const std::uint16_t count = counted ? std::max<std::uint16_t>(word(at + 2), 1) : 1;
    accesses_[access_count_++] = {area, write, word(at), count};
}

bool RequestView::decode_read(Area area, std::size_t most) {
    add_access(kAddress, area, false);
    return pdu_.size() == kReadLength && between_1_and(most, word(kQuantity));
}

bool RequestView::decode_single_write(Area area, std::size_t length) {
    add_access(kAddress, area, true, false);
    values_at_ = kQuantity;
    return pdu_.size() == length;
}

bool RequestView::decode_write(Area area, std::size_t most) {
    constexpr std::size_t kByteCount = 5;
    add_access(kAddress, area, true);
    if (pdu_.size() <= kByteCount) return false;
    values_at_ = kByteCount + 1;
    const std::size_t quantity = word(kQuantity);
    return between_1_and(most, quantity) &&
           counted(kByteCount, is_bit_area(area) ? (quantity + 7) / 8 : 2 * quantity);
}

bool RequestView::decode_read_write() {
    constexpr std::size_t kWriteAddress = 5;
    constexpr std::size_t kByteCount = 9;
    add_access(kAddress, Area::holding_register, false);
    add_access(kWriteAddress, Area::holding_register, true);
    if (pdu_.size() <= kByteCount) return false;
    values_at_ = kByteCount + 1;
    const std::size_t written = word(kWriteAddress + 2);
    return between_1_and(kMaxReadRegisters, word(kQuantity)) &&
           between_1_and(kMaxReadWriteRegisters, written) && counted(kByteCount, 2 * written);
}

// Whether the byte at `at` equals `bytes` and the number of bytes behind it.
bool RequestView::counted(std::size_t at, std::size_t bytes) const {
    return pdu_[at] == bytes && pdu_.size() == at + 1 + bytes;
}

void RequestView::decode_sub_function(std::size_t size) {
    if (pdu_.size() < 1 + size) return;
    sub_function_ = size == 2 ? word(1) : pdu_[1];
    data_at_ = static_cast<std::uint8_t>(1 + size);
}

bool RequestView::check_diagnostics() const {
    if (!sub_function_ || (*sub_function_ > 18 && *sub_function_ != 20)) return false;
    return *sub_function_ == kReturnQueryData ? data().size() % 2 == 0 : data().size() == 2;
}

bool RequestView::check_encapsulated() const {
    if (!sub_function_ || *sub_function_ != kReadDeviceId) return sub_function_.has_value();
    return data().size() == 2 && between_1_and(4, data()[0]);  // code and object
}

bool RequestView::check_files() const {
    const bool write = function() == Function::write_file_record;
    if (pdu_.size() < kFilePartsAt || !counted(kFilePartsAt - 1, pdu_.size() - kFilePartsAt)) return false;
    Bytes parts = pdu_.subspan(kFilePartsAt);
    if (parts.empty()) return false;
    std::size_t answered = 0;
    while (!parts.empty()) {
        if (parts.size() < kFileRange || parts[0] != kFileReferenceType) return false;
        const std::size_t length = word_at(parts, 5);
        const std::size_t size = kFileRange + (write ? 2 * length : 0);
        if (!between_1_and(kMaxFileRegisters, length) || parts.size() < size) return false;
        answered += file_response_bytes(length);
        parts = parts.subspan(size);
    }
    return write || answered <= kMaxFileBytes;
}

}  // namespace takt::wire
