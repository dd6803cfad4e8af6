// RTU (MODBUS over Serial Line V1.02, section 2.5.1): address, PDU, CRC, low byte first; a silence of t3.5
// separates frames. The CRC is updated with every byte. Over a frame with its CRC it is 0, so one comparison
// finds the positions where a frame can end; the expected length decides which of them is the end.
//
// Over a byte stream a client sends no silence. When the bytes turn out to begin with something else than a
// request, every later byte is tried as the beginning (resynchronisation), so that a stray byte does not cost
// the next request. It starts only then: the data of a good request may look like a request. While the bytes
// begin with no known function, or with counts that contradict each other, a whole request at their end is
// taken as well: such a beginning may wait for bytes that never come.
//
// A master searches likewise, but for one frame only: the response that it expects (expect_response).
#include <algorithm>
#include <utility>

#include "checksum.hpp"
#include "takt/base/assert.hpp"
#include "takt/wire/expected_length.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/framer.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::wire {
namespace {

constexpr std::size_t kLeastFrame = 4;
constexpr std::size_t kShortestUnknown = 8;  // bytes of an unknown function before others are looked for
constexpr std::uint8_t kFileReference = 6;   // reference type of each file sub-request
constexpr std::size_t kLengthDefined = 4;    // bytes after which most functions have defined their length
constexpr std::uint8_t kLastUnit = 247;      // of a device (MODBUS over Serial Line V1.02, section 2.2)

}  // namespace

FramerStep Framer::push_rtu(Instant t, Bytes bytes) {
    // The bytes of one push() may have arrived back to back (a UART's buffer) or all at once (a
    // pseudo-terminal). Inside a frame the shorter of the two possible pauses counts, between frames the
    // longer one. So no frame is lost in either case.
    const Duration longest_pause = t - last_;
    const Duration shortest_pause =
        longest_pause - static_cast<Duration::rep>(bytes.size()) * config_.character;
    const bool strict = config_.strict_pause > Duration::zero();
    if (inside()) {
        if (shortest_pause >= config_.silence) return end_rtu();
        if (strict && shortest_pause > config_.strict_pause)
            return drop(FrameFault::pause, 0, State::skipping);
        if (too_slow(t)) return drop(FrameFault::too_slow, 0, State::skipping);
    }
    const bool silent = (strict ? shortest_pause : longest_pause) >= config_.silence;
    if (state_ == State::complete) {
        const bool follows = silent || stream_ || more_;
        if (!more_) awaited_.reset();
        if (!follows) {
            const auto step = drop(FrameFault::surplus, bytes.size(), State::skipping);
            dropped_ = bytes;
            return step;
        }
        begin();
    }
    if (state_ == State::skipping) {
        if (!silent) return {bytes.size()};
        begin();
    }
    if (raw_.empty()) begun_ = t;
    if (state_ != State::resynchronising) state_ = State::receiving;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (raw_.size() == kMaxRtuFrame && !may_resynchronise() && !expected_)
            return drop(FrameFault::too_long, bytes.size(), State::skipping);
        if (raw_.size() == kMaxRtuFrame) {
            raw_.assign(raw_.span().subspan(1));
            shifted_ = true;
            const State before = std::exchange(state_, State::resynchronising);
            if (before == State::receiving && !expected_) return {i, false, FrameFault::too_long};
        }
        raw_.push_back(bytes[i]);
        crc_ = crc16_next(crc_, bytes[i]);
        if (state_ != State::resynchronising && crc_ == 0 && raw_.size() >= kLeastFrame &&
            rtu_length_reached())
            return complete_frame(i + 1);
        if (expected_) {
            if (state_ == State::receiving && rtu_beginning_impossible()) state_ = State::resynchronising;
            if (state_ == State::resynchronising && find_response()) return complete_frame(i + 1);
            if (!expected_came_damaged()) continue;
            FramerStep step = drop(FrameFault::checksum, i + 1, State::idle);
            step.whole = step.came = true;
            return step;
        }
        if (state_ == State::resynchronising) {
            if (find_request()) return complete_frame(i + 1);
            continue;
        }
        if (!may_resynchronise()) continue;
        const bool passed = rtu_length_passed();
        if ((passed || rtu_beginning_doubtful()) && find_request()) return complete_frame(i + 1);
        if (!passed) continue;
        state_ = State::resynchronising;
        return {i + 1, false, FrameFault::checksum};
    }
    return {bytes.size()};
}

bool Framer::may_resynchronise() const {
    return stream_ && config_.side == Side::slave;
}

// Whether the bytes cannot be a request with a defined length any more: it is reached and the CRC is wrong.
bool Framer::rtu_length_passed() const {
    if (raw_.size() < kLeastFrame) return false;
    const std::size_t request = expected_request_length(raw_.span());
    return request != 0 && raw_.size() >= std::max(request, expected_response_length(raw_.span()));
}

// Whether the bytes begin like no request: an unknown function, or counts that contradict each other.
bool Framer::rtu_beginning_doubtful() const {
    const Bytes raw = raw_.span();
    if (raw.size() < kLeastFrame) return false;
    const auto number_at = [raw](std::size_t i) { return unsigned{raw[i]} << 8 | raw[i + 1]; };
    const auto contradicts = [&](std::size_t quantity_at, bool bits) {
        if (raw.size() <= quantity_at + 2) return false;
        const unsigned quantity = number_at(quantity_at);
        return quantity == 0 || raw[quantity_at + 2] != (bits ? (quantity + 7) / 8 : 2 * quantity);
    };
    const auto& row = properties(Function{raw[1]});
    switch (row.request) {
        case RequestForm::values: return contradicts(row.request_bytes - 2U, row.counts_bits());
        case RequestForm::exchange:
            return contradicts(row.request_bytes - 2U, false) ||
                   (raw.size() > 5 && (number_at(4) == 0 || number_at(4) > row.most_items));
        case RequestForm::records: return raw[3] != kFileReference;
        case RequestForm::masks: return true;  // without room for another request in its data
        default: return raw.size() >= kShortestUnknown && expected_request_length(raw) == 0;
    }
}

// Looks for a request that ends with the last byte, and drops all before it.
bool Framer::find_request() {
    for (std::size_t start = 1; start + kLeastFrame <= raw_.size(); ++start) {
        const Bytes tail = raw_.span().subspan(start);
        if (expected_request_length(tail) != tail.size() || crc16(tail) != 0) continue;
        raw_.assign(tail);
        return true;
    }
    return false;
}

// Whether the bytes begin like the expected response, or its exception.
bool Framer::is_expected(Bytes beginning) const {
    return beginning.size() >= 2 && beginning[0] == expected_->unit.value &&
           requested_function(beginning[1]) == expected_->function;
}

// The length of the expected response that begins so; 0: none does, or there are too few bytes.
std::size_t Framer::expected_length(Bytes beginning) const {
    if (!is_expected(beginning)) return 0;
    const std::size_t length = expected_response_length(beginning);
    const bool fixed = expected_->length > 0 && !is_exception(beginning[1]);
    return fixed && length != expected_->length ? 0 : length;
}

// More bytes may show that they are the expected response.
bool Framer::may_begin_expected(Bytes beginning) const {
    if (beginning.size() < 2) return beginning[0] == expected_->unit.value;
    return is_expected(beginning) &&
           (expected_response_length(beginning) == 0 || expected_length(beginning) > beginning.size());
}

// No frame of any device begins so, or its length is reached and the CRC is wrong.
bool Framer::rtu_beginning_impossible() const {
    const Bytes raw = raw_.span();
    if (raw[0] != expected_->unit.value && (raw[0] == 0 || raw[0] > kLastUnit)) return true;
    if (raw.size() < kLengthDefined) return false;
    if (const std::size_t length = expected_response_length(raw); length != 0) return raw.size() >= length;
    const bool list = Function{raw[1]} == Function::encapsulated_interface && raw[2] == kReadDeviceId;
    const bool undefined = is_expected(raw) && expected_->length == 0;
    return !list && !undefined;
}

// The expected response is complete, and its CRC is wrong. If it came with noise before it, a response may
// have begun inside these bytes: then only a silence shows that they are all.
bool Framer::expected_came_damaged() const {
    if (state_ != State::resynchronising) return false;
    const Bytes raw = raw_.span();
    const std::size_t length = expected_length(raw) == raw.size() ? raw.size() : expected_->length;
    if (length < kLeastFrame || raw.size() < length) return false;
    const Bytes response = raw.last(length);
    if (expected_length(response) != length) return false;
    for (std::size_t start = 1; start < length; ++start)
        if (may_begin_expected(response.subspan(start))) return false;
    return true;
}

// Looks for the expected response, and drops all around it.
bool Framer::find_response() {
    for (std::size_t start = shifted_ ? 0 : 1; start + kLeastFrame <= raw_.size(); ++start) {
        const Bytes rest = raw_.span().subspan(start);
        const std::size_t length = expected_length(rest);
        if (length < kLeastFrame || length > rest.size() || crc16(rest.first(length)) != 0) continue;
        raw_.assign(rest.first(length));
        return true;
    }
    return false;
}

FramerStep Framer::find_expected() {
    const bool found = config_.framing == Framing::rtu && inside() && expected_ && find_response();
    return found ? complete_frame(0) : FramerStep{};
}

FramerStep Framer::end_rtu() {
    if (state_ == State::resynchronising && !expected_) return drop(FrameFault::none, 0, State::idle);
    if (crc_ != 0 && may_resynchronise() && find_request()) return complete_frame(0);
    if ((crc_ != 0 || shifted_) && expected_ && find_response()) return complete_frame(0);
    if (raw_.size() < kLeastFrame) return drop(FrameFault::too_short, 0, State::idle);
    if (crc_ == 0 && !shifted_) return complete_frame(0);
    const std::size_t length = raw_.size();
    bool came = false;
    bool whole = length == expected_response_length(raw_.span()) ||
                 (config_.side == Side::slave && length == expected_request_length(raw_.span()));
    if (expected_) {
        const std::size_t wanted = expected_->length;
        // Of damaged bytes the unit or the function is still right. Others are noise, and the response may
        // come.
        const bool like =
            length >= 2 && (raw_[0] == expected_->unit.value || (raw_[1] & 0x7F) == expected_->function);
        whole = wanted > 0 && ((length == wanted && !shifted_ && like) ||
                               (length > wanted && expected_length(raw_.span().last(wanted)) == wanted));
        const Bytes last = raw_.span().last(std::min(length, wanted));
        came = whole && last[0] == expected_->unit.value && (last[1] & 0x7F) == expected_->function;
    }
    const bool cut_short = expected_ && expected_length(raw_.span()) > length;
    FramerStep step = drop(cut_short ? FrameFault::too_short : FrameFault::checksum, 0, State::idle);
    step.whole = whole;
    step.came = came;
    return step;
}

bool Framer::rtu_length_reached() const {
    const std::size_t as_response = expected_response_length(raw_.span());
    if (raw_.size() == as_response) return true;
    if (config_.side == Side::master) return false;
    // While the response of another unit is due, its first bytes may look like a complete request. Only the
    // length as a response counts then.
    const bool response_only = awaited_ == rtu_exchange() && as_response != 0;
    return !response_only && raw_.size() == expected_request_length(raw_.span());
}

Framer::Exchange Framer::rtu_exchange() const {
    return {raw_[0], requested_function(raw_[1])};
}

void Framer::expect_more() {
    TAKT_ASSERT(state_ == State::complete);
    more_ = true;
    if (config_.framing != Framing::rtu) return;
    const Exchange returned = rtu_exchange();
    const bool response = awaited_ == returned && raw_.size() == expected_response_length(raw_.span());
    const bool request = !response && raw_.size() == expected_request_length(raw_.span());
    awaited_ = request ? std::optional(returned) : std::nullopt;
}

}  // namespace takt::wire
