#include "takt/capture/frame_finder.hpp"

#include <algorithm>

#include "exchanges/pdu_shape.hpp"
#include "serial/serial_frame.hpp"
#include "takt/wire/expected_length.hpp"

namespace takt::capture {
namespace {

constexpr std::size_t kLeastRtu = 4;
constexpr std::size_t kLengthDefined = 12;  // bytes after which a frame has defined its length

// The list of a device identification ends where its last object does.
bool has_late_length(Bytes frame) {
    return wire::Function{frame[1]} == wire::Function::encapsulated_interface &&
           frame[2] == wire::kReadDeviceId;
}

}  // namespace

void FrameFinder::push(Instant t, Bytes bytes) {
    if (bytes.empty()) return;
    const auto count = static_cast<Duration::rep>(bytes.size());
    if (size_ > 0 && t - count * config_.character - last_ > config_.pause) search(true);
    Duration::rep behind = count;
    for (const auto byte : bytes) {
        if (size_ == kMost) search(false);
        if (size_ == kMost) report_damaged(wire::kMaxRtuFrame);
        append(t - --behind * config_.character, byte);
    }
    search(false);
}

// A chunk that came later than its characters were sent must not overtake the one before it.
void FrameFinder::append(Instant t, std::uint8_t byte) {
    last_ = std::max(last_, t);
    bytes_[size_] = byte;
    times_[size_++] = last_;
}

void FrameFinder::on_tick(Instant t) {
    if (size_ > 0 && t - last_ > config_.pause) search(true);
}

Instant FrameFinder::next_wakeup() const {
    return size_ == 0 ? kNever : after(last_, config_.pause + Duration(1));
}

void FrameFinder::end() {
    search(true);
}

void FrameFinder::search(bool closed) {
    while (size_ > 0) {
        const auto match = config_.framing == wire::Framing::ascii ? find_ascii() : find_rtu(closed);
        if (match.length == 0) break;
        if (match.start > 0) report_damaged(match.start);
        if (match.good)
            report_frame(0, match.length);
        else
            report_damaged(match.length);
    }
    if (closed && size_ > 0) report_damaged(size_);
}

// A frame that ends before tried_ was no frame when its last byte came.
FrameFinder::Match FrameFinder::find_rtu(bool closed) {
    if (const auto length = rtu_frame_at(0, closed); length > 0) return {0, length, true};
    if (!closed && may_grow()) return {};
    for (std::size_t start = 1; start < size_; ++start)
        if (const auto length = rtu_frame_at(start, closed); length > 0) return {start, length, true};
    tried_ = size_;
    return {};
}

bool FrameFinder::has_shape(Bytes frame) const {
    const auto pdu = frame.subspan(1, frame.size() - 3);
    if (config_.known_only && frame[0] > kLastUnit) return false;
    return capture::could_be_request(pdu) || capture::could_be_response(pdu);
}

// The length of the good frame that begins there; 0: none.
std::size_t FrameFinder::rtu_frame_at(std::size_t start, bool closed) const {
    const auto rest = bytes().subspan(start);
    if (rest.size() < kLeastRtu) return 0;
    for (const auto length : {wire::expected_request_length(rest), wire::expected_response_length(rest)}) {
        if (length < kLeastRtu || length > rest.size() || start + length <= tried_) continue;
        if (wire::crc16(rest.first(length)) == 0 && has_shape(rest.first(length))) return length;
    }
    const bool ends_at_pause = closed && !config_.known_only && start == 0;
    return ends_at_pause && rest.size() <= wire::kMaxRtuFrame && wire::crc16(rest) == 0 ? rest.size() : 0;
}

// Further bytes may make a frame of all bytes.
bool FrameFinder::may_grow() const {
    const auto all = bytes();
    if (all[0] > kLastUnit || all.size() >= wire::kMaxRtuFrame) return false;
    if (all.size() < kLeastRtu) return true;
    const auto request = wire::expected_request_length(all);
    const auto response = wire::expected_response_length(all);
    if (std::max(request, response) > all.size()) return true;
    const bool known = wire::is_known(wire::Function{all[1]});
    return known && (all.size() < kLengthDefined || has_late_length(all));
}

FrameFinder::Match FrameFinder::find_ascii() const {
    const auto all = bytes();
    const auto begin = std::ranges::find(all, std::uint8_t{':'});
    const auto start = static_cast<std::size_t>(begin - all.begin());
    if (start > 0) return {0, start, false};
    const auto next =
        std::find_if(begin + 1, all.end(), [](auto byte) { return byte == ':' || byte == '\n'; });
    if (next == all.end()) return {};
    const auto length = static_cast<std::size_t>(next - begin);
    if (*next == ':') return {0, length, false};
    const auto frame = all.first(length + 1);
    return {0, frame.size(), capture::decode_ascii(frame).size() >= 2};
}

Instant FrameFinder::begin_of(std::size_t index) const {
    return times_[index] - config_.character;
}

void FrameFinder::report_frame(std::size_t start, std::size_t length) {
    const auto raw = bytes().subspan(start, length);
    const auto decoded =
        config_.framing == wire::Framing::ascii ? capture::decode_ascii(raw) : capture::decode_rtu(raw);
    sink_.on_frame({.begin = begin_of(start),
                    .end = times_[start + length - 1],
                    .unit = decoded[0],
                    .pdu = decoded.span().subspan(1),
                    .raw = raw});
    drop(start + length);
}

// The length of a frame at the begin whose function is not of the specification; 0: none.
std::size_t FrameFinder::unknown_frame_in(std::size_t count) const {
    const bool wanted = config_.framing == wire::Framing::rtu && !config_.known_only;
    if (!wanted || count < kLeastRtu || bytes_[0] > kLastUnit) return 0;
    if (wire::is_known(wire::Function{wire::requested_function(bytes_[1])})) return 0;
    for (auto length = kLeastRtu; length <= std::min(count, wire::kMaxRtuFrame); ++length)
        if (wire::crc16(bytes().first(length)) == 0) return length;
    return 0;
}

// A response may follow its request in less than the pause: frames of unknown functions have no other end.
void FrameFinder::report_damaged(std::size_t count) {
    while (const auto length = unknown_frame_in(count)) {
        report_frame(0, length);
        count -= length;
    }
    if (count == 0) return;
    sink_.on_damaged({.begin = begin_of(0), .end = times_[count - 1], .bytes = bytes().first(count)});
    drop(count);
}

void FrameFinder::drop(std::size_t count) {
    std::copy(bytes_.begin() + static_cast<std::ptrdiff_t>(count),
              bytes_.begin() + static_cast<std::ptrdiff_t>(size_), bytes_.begin());
    std::copy(times_.begin() + static_cast<std::ptrdiff_t>(count),
              times_.begin() + static_cast<std::ptrdiff_t>(size_), times_.begin());
    size_ -= count;
    tried_ = 0;
}

}  // namespace takt::capture
