#include "takt/wire/framer.hpp"

#include <algorithm>

#include "checksum.hpp"
#include "takt/base/assert.hpp"
#include "takt/wire/expected_length.hpp"

namespace takt::wire {
namespace {

// The MBAP header (MODBUS Messaging on TCP/IP V1.0b, section 3.1.3): transaction, protocol (0) and length,
// two bytes each. The length counts the unit and the PDU, which follow.
constexpr std::size_t kMbapLengthEnd = 6;
constexpr std::size_t kMbapPdu = 7;
constexpr std::size_t kMbapBeginning = kMbapPdu + 1;  // up to the function: enough to find its transaction
constexpr std::size_t kMbapLeast = 2;
constexpr std::size_t kMbapMost = 1 + kMaxPdu;

// A response with its header, as long as its own counts say; 0: they do not say it.
std::size_t own_length(Bytes frame) {
    constexpr std::size_t kRtuCrc = 2;
    if (frame.size() < kMbapBeginning) return 0;
    const std::size_t length = expected_response_length(frame.subspan(kMbapLengthEnd));
    return length == 0 ? 0 : kMbapLengthEnd + length - kRtuCrc;
}

bool is_off_by_one(std::size_t own, std::size_t promised) {
    return own + 1 == promised || own == promised + 1;
}

bool begins_like_header(Bytes bytes) {
    return bytes.size() > 3 && bytes[2] == 0 && bytes[3] == 0;
}

std::size_t raw_size(Framing framing, std::size_t there) {
    switch (framing) {
        case Framing::rtu: return kMaxRtuFrame;
        case Framing::ascii: return kMaxAsciiFrame;
        case Framing::tcp: break;
    }
    return std::min(there, kMaxTcpFrame);
}

}  // namespace

std::string_view name(FrameFault fault) {
    switch (fault) {
        case FrameFault::none: return "none";
        case FrameFault::checksum: return "checksum";
        case FrameFault::too_short: return "too_short";
        case FrameFault::too_long: return "too_long";
        case FrameFault::pause: return "pause";
        case FrameFault::bad_character: return "bad_character";
        case FrameFault::bad_header: return "bad_header";
        case FrameFault::surplus: return "surplus";
        case FrameFault::too_slow: return "too_slow";
    }
    return "fault";
}

Framer::Framer(const FramerConfig& config, std::span<std::uint8_t> storage, bool stream)
    : config_(config),
      stream_(stream),
      raw_(storage.first(raw_size(config.framing, storage.size()))),
      decoded_(config.framing == Framing::ascii ? storage.subspan(kMaxAsciiFrame, kMaxDecoded)
                                                : std::span<std::uint8_t>{}) {
    TAKT_ASSERT(config.framing != Framing::rtu || config.silence > Duration::zero());
    begin();
}

FramerStep Framer::push(Instant t, Bytes bytes) {
    dropped_ = {};
    if (bytes.empty()) return {};
    FramerStep step;
    switch (config_.framing) {
        case Framing::rtu: step = push_rtu(t, bytes); break;
        case Framing::ascii: step = push_ascii(t, bytes); break;
        case Framing::tcp: step = push_tcp(bytes); break;
    }
    const auto left = static_cast<Duration::rep>(bytes.size() - step.consumed);
    if (step.consumed > 0) last_ = t - left * config_.character;
    return step;
}

FramerStep Framer::on_tick(Instant t) {
    dropped_ = {};
    if (t < next_wakeup()) return {};
    if (config_.framing == Framing::tcp) return complete_frame(0);
    return config_.framing == Framing::rtu ? end_rtu() : drop(FrameFault::pause, 0, State::idle);
}

Instant Framer::next_wakeup() const {
    if (config_.framing == Framing::tcp)
        return state_ == State::ending ? after(last_, config_.silence) : kNever;
    if (!inside()) return kNever;
    return after(last_, config_.framing == Framing::rtu ? config_.silence : config_.ascii_pause);
}

Frame Framer::frame() const {
    TAKT_ASSERT(state_ == State::complete);
    const Bytes raw = raw_.span();
    switch (config_.framing) {
        case Framing::rtu: return {UnitId{raw[0]}, 0, raw.subspan(1, raw.size() - 3)};
        case Framing::ascii: return {UnitId{decoded_[0]}, 0, decoded_.span().subspan(1, decoded_.size() - 2)};
        case Framing::tcp: break;
    }
    return {UnitId{raw[kMbapPdu - 1]}, word_at(raw, 0), raw.subspan(kMbapPdu)};
}

Bytes Framer::raw() const {
    TAKT_ASSERT(state_ == State::complete);
    return raw_.span();
}

void Framer::reset() {
    awaited_.reset();
    expected_.reset();
    dropped_ = {};
    begin();
}

FramerStep Framer::push_tcp(Bytes bytes) {
    if (state_ == State::dead) return {bytes.size(), false, FrameFault::bad_header};
    if (state_ == State::ending) return complete_frame(begins_like_header(bytes) ? 0 : 1);
    if (state_ == State::complete) begin();
    state_ = State::receiving;
    if (to_skip_ > 0) return skip(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        raw_.push_back(bytes[i]);
        if (raw_.size() <= kMbapLengthEnd) {
            if (!mbap_header_good()) return drop(FrameFault::bad_header, bytes.size(), State::dead);
            continue;
        }
        const std::size_t promised = kMbapLengthEnd + word_at(raw_.span(), kMbapLengthEnd - 2);
        const std::size_t whole = mbap_length(promised);
        if (raw_.size() == whole && whole < promised) {
            state_ = State::ending;
            const Bytes rest = bytes.subspan(i + 1);
            if (rest.empty()) return {i + 1};
            return complete_frame(i + (begins_like_header(rest) ? 1 : 2));
        }
        if (raw_.size() == whole) return complete_frame(i + 1);
        if (raw_.size() < kMbapBeginning || whole <= raw_.capacity()) continue;
        to_skip_ = whole - raw_.size();
        return {i + 1};
    }
    return {bytes.size()};
}

// The length of the frame that begins so: as its header promises, unless it is the expected response and
// knows better.
std::size_t Framer::mbap_length(std::size_t promised) const {
    const Bytes raw = raw_.span();
    if (!config_.length_tolerance || !expected_ || raw.size() < kMbapBeginning) return promised;
    if (word_at(raw, 0) != expected_->transaction || !is_expected(raw.subspan(kMbapPdu - 1))) return promised;
    const std::size_t own = own_length(raw);
    return is_off_by_one(own, promised) ? own : promised;
}

bool Framer::length_is_off() const {
    const Bytes raw = raw_.span();
    const std::size_t own = own_length(raw);
    if (config_.framing != Framing::tcp || own == 0) return false;
    const std::size_t promised = kMbapLengthEnd + word_at(raw, kMbapLengthEnd - 2);
    return is_off_by_one(own, promised) && (raw.size() == own || raw.size() == promised);
}

FramerStep Framer::skip(std::size_t there) {
    const std::size_t skipped = std::min(there, to_skip_);
    to_skip_ -= skipped;
    if (to_skip_ > 0) return {skipped};
    state_ = State::complete;
    return {skipped, false, FrameFault::too_long};
}

// Checks each byte when it arrives: a wrong protocol is detected before the length is complete.
bool Framer::mbap_header_good() const {
    const std::size_t size = raw_.size();
    if (size == 3 || size == 4) return raw_.back() == 0;
    if (size != kMbapLengthEnd) return true;
    const std::size_t length = word_at(raw_.span(), kMbapLengthEnd - 2);
    return length >= kMbapLeast && length <= kMbapMost;
}

bool Framer::too_slow(Instant t) const {
    return config_.frame_time > Duration::zero() && t - begun_ > config_.frame_time;
}

void Framer::begin() {
    state_ = State::idle;
    more_ = false;
    shifted_ = damaged_ = false;
    crc_ = kCrcStart;
    to_skip_ = 0;
    raw_.clear();
    decoded_.clear();
}

FramerStep Framer::drop(FrameFault fault, std::size_t consumed, State next) {
    dropped_ = raw_.span();
    begin();
    state_ = next;
    return {consumed, false, fault};
}

FramerStep Framer::complete_frame(std::size_t consumed) {
    state_ = State::complete;
    return {consumed, true};
}

}  // namespace takt::wire
