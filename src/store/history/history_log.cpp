// A row, in varints: for each sample
//   series | time in ms since the sample before | state u8 | reason, unless ok | previous poll: ms before the
//   time, if there is one | value
// state: quality in bits 0 and 1, kind of the value in bits 2 to 4, bit 5: a reason, bit 6: a previous poll
#include "history/history_log.hpp"

#include <algorithm>
#include <bit>
#include <string>
#include <variant>

#include "history/history_bytes.hpp"
#include "journal/little_endian.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::uint8_t kQuality = 3;
constexpr unsigned kKindShift = 2;
constexpr std::uint8_t kKind = 7;
constexpr std::uint8_t kHasReason = 1 << 5;
constexpr std::uint8_t kHasPrevious = 1 << 6;
constexpr std::size_t kDouble = 8;

struct PutValue {
    ByteVector& out;
    void operator()(std::monostate) const {}
    void operator()(bool value) const { out.push_back(value ? 1 : 0); }
    void operator()(std::int64_t value) const { put_signed(out, value); }
    void operator()(std::uint64_t value) const { put_varint(out, value); }
    void operator()(double value) const { put_little(out, std::bit_cast<std::uint64_t>(value)); }
    void operator()(const std::string& value) const { put_text(out, value); }
};

value::Value take_value(VarintReader& in, unsigned kind) {
    switch (kind) {
        case 0: return {};
        case 1: return in.take() != 0;
        case 2: return in.take_signed();
        case 3: return in.take();
        case 4: {
            const Bytes bytes = in.take_bytes(kDouble);
            if (!in.good()) return {};
            return std::bit_cast<double>(LittleEndianReader(bytes).take<std::uint64_t>());
        }
        case 5: return in.take_text();
        default: in.fail(); return {};
    }
}

}  // namespace

std::vector<std::uint8_t> encode_log(std::span<const LoggedSample> samples) {
    ByteVector out;
    std::int64_t last = 0;
    for (const auto& [series, sample] : samples) {
        const std::int64_t time = milliseconds(sample.time_ns);
        put_varint(out, series.value);
        put_signed(out, time - last);
        last = time;
        const bool has_reason = sample.reason != value::Reason::ok;
        out.push_back(static_cast<std::uint8_t>(
            static_cast<unsigned>(sample.quality) | sample.value.index() << kKindShift |
            (has_reason ? kHasReason : 0U) | (sample.previous_ns ? kHasPrevious : 0U)));
        if (has_reason) put_varint(out, static_cast<std::uint16_t>(sample.reason));
        if (sample.previous_ns) put_signed(out, time - milliseconds(*sample.previous_ns));
        std::visit(PutValue{out}, sample.value);
    }
    put_little(out, crc32c(out));
    return out;
}

Result<std::vector<LoggedSample>> decode_log(Bytes bytes) {
    if (bytes.size() < kCrc32cBytes) return fail(Code::malformed);
    const Bytes checked = bytes.first(bytes.size() - kCrc32cBytes);
    if (LittleEndianReader(bytes.last(kCrc32cBytes)).take<std::uint32_t>() != crc32c(checked))
        return fail(Code::malformed);
    std::vector<LoggedSample> samples;
    VarintReader in(checked);
    std::int64_t time = 0;
    while (in.good() && in.left() > 0) {
        LoggedSample logged;
        logged.series.value = static_cast<std::uint32_t>(in.take());
        time = wrapped_sum(time, in.take_signed());
        logged.sample.time_ns = nanoseconds(time);
        const Bytes state = in.take_bytes(1);
        if (!in.good()) break;
        logged.sample.quality = static_cast<value::Quality>(state[0] & kQuality);
        if ((state[0] & kHasReason) != 0) {
            const std::uint64_t reason = in.take();
            if (reason > UINT16_MAX) in.fail();
            logged.sample.reason = static_cast<value::Reason>(reason);
        }
        if ((state[0] & kHasPrevious) != 0)
            logged.sample.previous_ns = nanoseconds(wrapped_difference(time, in.take_signed()));
        logged.sample.value = take_value(in, state[0] >> kKindShift & kKind);
        samples.push_back(std::move(logged));
    }
    if (!in.good()) return fail(Code::malformed);
    return samples;
}

DecodedLog decode_log(std::span<const LogRow> rows, std::int64_t from_ns, std::int64_t to_ns) {
    DecodedLog log;
    std::size_t unbounded = 0;  // the damaged rows before this one have their last time
    const auto bound = [&](std::int64_t next_ns) {
        for (; unbounded < log.damage.size(); ++unbounded) {
            const std::int64_t first = *log.damage[unbounded].first_ns;
            log.damage[unbounded].first_ns = std::min(first, next_ns);
            log.damage[unbounded].last_ns = std::max(first, next_ns);
        }
    };
    for (const LogRow& row : rows) {
        const auto samples = decode_log(row.data);
        if (!samples) {
            log.damage.push_back({.part = HistoryPart::log, .row = row.id, .first_ns = from_ns});
            continue;
        }
        if (samples->empty()) continue;
        const auto [oldest, newest] = std::ranges::minmax(
            *samples, {}, [](const LoggedSample& logged) { return logged.sample.time_ns; });
        bound(oldest.sample.time_ns);
        from_ns = newest.sample.time_ns;
        log.samples.insert(log.samples.end(), samples->begin(), samples->end());
    }
    bound(std::max(from_ns, to_ns));
    return log;
}

}  // namespace takt::store
