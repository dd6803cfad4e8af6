// The form of every request (MODBUS Application Protocol V1.1b3, section 6), read where it lies. The
// functions of pdu.hpp decode the same requests into structures of their own.
#include "takt/wire/request_view.hpp"

#include <algorithm>

#include "item_limits.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {
namespace {

constexpr std::size_t kAddress = 1;   // where the first address is
constexpr std::size_t kQuantity = 3;  // and the first quantity, or the value of a single item

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
    const auto& row = properties(function());
    switch (row.request) {
        case RequestForm::unknown: return false;
        case RequestForm::empty: break;
        case RequestForm::range:
            add_access(kAddress, row.area, false);
            return pdu_.size() == row.request_bytes && between_1_and(row.most_items, word(kQuantity));
        case RequestForm::single:
        case RequestForm::masks: return decode_single_write(row);
        case RequestForm::values: return decode_write(row);
        case RequestForm::exchange: return decode_read_write(row);
        case RequestForm::queue: add_access(kAddress, row.area, false, false); break;
        case RequestForm::records: return check_files();
        case RequestForm::sub_function: decode_sub_function(2); return check_diagnostics();
        case RequestForm::encapsulated: decode_sub_function(1); return check_encapsulated();
    }
    return pdu_.size() == row.request_bytes;
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

bool RequestView::decode_single_write(const FunctionProperties& row) {
    add_access(kAddress, row.area, true, false);
    values_at_ = kQuantity;
    if (pdu_.size() != row.request_bytes) return false;
    return !row.counts_bits() || word(kQuantity) == kCoilOn || word(kQuantity) == 0;
}

// The quantity of the values lies before their byte count.
bool RequestView::decode_values(const FunctionProperties& row) {
    if (pdu_.size() < row.request_bytes) return false;
    values_at_ = row.request_bytes;
    const std::size_t quantity = word(row.request_bytes - 3U);
    return between_1_and(row.most_written, quantity) &&
           counted(row.request_bytes - 1U, row.counts_bits() ? (quantity + 7) / 8 : 2 * quantity);
}

bool RequestView::decode_write(const FunctionProperties& row) {
    add_access(kAddress, row.area, true);
    return decode_values(row);
}

bool RequestView::decode_read_write(const FunctionProperties& row) {
    constexpr std::size_t kWriteAddress = 5;
    add_access(kAddress, row.area, false);
    add_access(kWriteAddress, row.area, true);
    return decode_values(row) && between_1_and(row.most_items, word(kQuantity));
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
