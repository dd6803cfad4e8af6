// A chunk:
//   version u8 | flags u8 (1: compressed) | body | CRC-32C u32 of all before it
// A compressed body is: its plain length, varint, and one zstd frame. A body, in varints:
//   count | unit in ns | times (regular) | form of the previous polls | previous polls |
//   runs of (quality, reason) | runs of kinds of values | for each kind that is there: its values
// The previous poll of a sample is given relative to the sample before, which is zero when every poll is a
// sample, or as an interval before the sample, which is steady when only changes are samples; whichever is
// shorter. 0 stands for none, other numbers are zigzag + 1.
#include "takt/store/history_codec.hpp"

#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <variant>

#include "history/history_bytes.hpp"
#include "history/history_columns.hpp"
#include "journal/little_endian.hpp"
#include "takt/base/assert.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::uint8_t kChunkVersion = 1;
constexpr std::uint8_t kCompressed = 1;
constexpr std::size_t kChunkHeaderBytes = 2;
constexpr int kLevel = 3;                             // of zstd; see docs/decisions/0042-history.md
constexpr std::uint64_t kLargestBody = 256ULL << 20;  // of a damaged length
constexpr std::uint64_t kMostSamples = 16ULL << 20;

enum class PreviousForm : std::uint8_t { none, to_sample_before, interval };

std::int64_t rounded_down(std::int64_t value, std::int64_t unit) {
    return value / unit - (value % unit < 0 ? 1 : 0);
}

// `previous` in zigzag + 1 does not fit 64 bits for two numbers; they are not times of this planet.
void put_optional(ByteVector& out, bool is_there, std::int64_t number) {
    put_varint(out, is_there ? zigzag(number) + 1 : 0);
}

ByteVector previous_polls(std::span<const HistorySample> samples, std::span<const std::int64_t> times,
                          std::int64_t unit, PreviousForm form) {
    ByteVector out;
    std::int64_t interval = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const bool is_there = samples[i].previous_ns.has_value();
        const std::int64_t previous = is_there ? rounded_down(*samples[i].previous_ns, unit) : 0;
        if (form == PreviousForm::to_sample_before) {
            put_optional(out, is_there, wrapped_difference(previous, times[i > 0 ? i - 1 : 0]));
            continue;
        }
        const std::int64_t its = wrapped_difference(times[i], previous);
        put_optional(out, is_there, wrapped_difference(its, interval));
        if (is_there) interval = its;
    }
    return out;
}

void put_previous(ByteVector& out, std::span<const HistorySample> samples,
                  std::span<const std::int64_t> times, std::int64_t unit) {
    const auto put = [&out](PreviousForm form, const ByteVector& column) {
        out.push_back(static_cast<std::uint8_t>(form));
        out.insert(out.end(), column.begin(), column.end());
    };
    if (std::ranges::none_of(samples, [](const auto& sample) { return sample.previous_ns.has_value(); }))
        return put(PreviousForm::none, {});
    const auto cost = [](const ByteVector& column) {  // bytes, those other than "as expected" count double
        return column.size() + column.size() - static_cast<std::size_t>(std::ranges::count(column, 1));
    };
    const auto relative = previous_polls(samples, times, unit, PreviousForm::to_sample_before);
    const auto intervals = previous_polls(samples, times, unit, PreviousForm::interval);
    if (cost(relative) <= cost(intervals)) return put(PreviousForm::to_sample_before, relative);
    put(PreviousForm::interval, intervals);
}

void take_previous(VarintReader& in, std::vector<HistorySample>& samples, std::span<const std::int64_t> times,
                   std::int64_t unit) {
    const Bytes byte = in.take_bytes(1);
    if (!in.good()) return;
    const auto form = static_cast<PreviousForm>(byte[0]);
    if (form == PreviousForm::none) return;
    if (form != PreviousForm::to_sample_before && form != PreviousForm::interval) return in.fail();
    std::int64_t interval = 0;
    for (std::size_t i = 0; i < samples.size() && in.good(); ++i) {
        const std::uint64_t coded = in.take();
        if (coded == 0) continue;
        const std::int64_t number = from_zigzag(coded - 1);
        std::int64_t previous = wrapped_sum(times[i > 0 ? i - 1 : 0], number);
        if (form == PreviousForm::interval) {
            interval = wrapped_sum(interval, number);
            previous = wrapped_difference(times[i], interval);
        }
        samples[i].previous_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(previous) *
                                                           static_cast<std::uint64_t>(unit));
    }
}

/// Runs of equal keys: the number of runs, then each as `put(first of it)` and its length.
template <class Key, class Put>
void put_runs(ByteVector& out, std::span<const HistorySample> samples, Key key, Put put) {
    ByteVector runs;
    std::uint64_t count = 0;
    for (std::size_t first = 0; first < samples.size(); ++count) {
        std::size_t end = first + 1;
        while (end < samples.size() && key(samples[end]) == key(samples[first])) ++end;
        put(runs, samples[first]);
        put_varint(runs, end - first);
        first = end;
    }
    put_varint(out, count);
    out.insert(out.end(), runs.begin(), runs.end());
}

/// @param take  takes the key of a run, and returns what sets it in a sample
template <class Take>
void take_runs(VarintReader& in, std::span<HistorySample> samples, Take take) {
    const std::uint64_t runs = in.take();
    std::size_t at = 0;
    for (std::uint64_t i = 0; i < runs && in.good(); ++i) {
        const auto set = take();
        const std::uint64_t length = in.take();
        if (length > samples.size() - at) in.fail();
        for (std::uint64_t k = 0; k < length && in.good(); ++k) set(samples[at++]);
    }
    if (at != samples.size()) in.fail();
}

void put_states(ByteVector& out, std::span<const HistorySample> samples) {
    put_runs(
        out, samples, [](const auto& sample) { return std::pair(sample.quality, sample.reason); },
        [](ByteVector& runs, const auto& sample) {
            runs.push_back(static_cast<std::uint8_t>(sample.quality));
            put_varint(runs, static_cast<std::uint16_t>(sample.reason));
        });
}

void take_states(VarintReader& in, std::vector<HistorySample>& samples) {
    take_runs(in, samples, [&in] {
        const Bytes quality = in.take_bytes(1);
        const std::uint64_t reason = in.take();
        if (!in.good() || quality[0] > static_cast<std::uint8_t>(value::Quality::bad) || reason > UINT16_MAX)
            in.fail();
        const std::uint8_t number = in.good() ? quality[0] : 0;
        return [number, reason](HistorySample& sample) {
            sample.quality = static_cast<value::Quality>(number);
            sample.reason = static_cast<value::Reason>(reason);
        };
    });
}

template <class T>
std::vector<T> column_of(std::span<const HistorySample> samples) {
    std::vector<T> column;
    for (const auto& sample : samples)
        if (const auto* const value = std::get_if<T>(&sample.value)) column.push_back(*value);
    return column;
}

void put_values(ByteVector& out, std::span<const HistorySample> samples) {
    put_runs(
        out, samples, [](const auto& sample) { return sample.value.index(); },
        [](ByteVector& runs, const auto& sample) {
            runs.push_back(static_cast<std::uint8_t>(sample.value.index()));
        });
    if (const auto bools = column_of<bool>(samples); !bools.empty()) put_bools(out, bools);
    if (const auto numbers = column_of<std::int64_t>(samples); !numbers.empty()) put_integers(out, numbers);
    if (const auto numbers = column_of<std::uint64_t>(samples); !numbers.empty())
        put_integers(out, std::vector<std::int64_t>(numbers.begin(), numbers.end()));
    if (const auto numbers = column_of<double>(samples); !numbers.empty()) put_reals(out, numbers);
    if (const auto texts = column_of<std::string>(samples); !texts.empty()) put_texts(out, texts);
}

template <class T, class Column>
void set_values(std::vector<HistorySample>& samples, std::size_t kind, const Column& column) {
    std::size_t at = 0;
    for (auto& sample : samples)
        if (sample.value.index() == kind && at < column.size()) sample.value = T(column[at++]);
}

void take_values(VarintReader& in, std::vector<HistorySample>& samples) {
    constexpr std::size_t kKinds = std::variant_size_v<value::Value>;
    std::array<std::size_t, kKinds> counts{};
    static const std::array<value::Value, kKinds> kEmpty{std::monostate{}, false,    std::int64_t{},
                                                         std::uint64_t{},  double{}, std::string{}};
    take_runs(in, samples, [&in, &counts] {
        const Bytes kind = in.take_bytes(1);
        if (!in.good() || kind[0] >= kKinds) in.fail();
        const std::size_t number = in.good() ? kind[0] : 0;
        return [number, &counts](HistorySample& sample) {
            sample.value = kEmpty[number];
            ++counts[number];
        };
    });
    if (!in.good()) return;
    if (counts[1] > 0) set_values<bool>(samples, 1, take_bools(in, counts[1]));
    if (counts[2] > 0) set_values<std::int64_t>(samples, 2, take_integers(in, counts[2]));
    if (counts[3] > 0) set_values<std::uint64_t>(samples, 3, take_integers(in, counts[3]));
    if (counts[4] > 0) set_values<double>(samples, 4, take_reals(in, counts[4]));
    if (counts[5] > 0) set_values<std::string>(samples, 5, take_texts(in, counts[5]));
}

ByteVector body_of(std::span<const HistorySample> samples, std::int64_t unit) {
    std::vector<std::int64_t> times;
    times.reserve(samples.size());
    for (const auto& sample : samples) times.push_back(rounded_down(sample.time_ns, unit));
    ByteVector out;
    put_varint(out, samples.size());
    put_varint(out, static_cast<std::uint64_t>(unit));
    put_regular(out, times);
    put_previous(out, samples, times, unit);
    put_states(out, samples);
    put_values(out, samples);
    return out;
}

Result<std::vector<HistorySample>> samples_of(Bytes body) {
    VarintReader in(body);
    const std::uint64_t count = in.take();
    const auto unit = static_cast<std::int64_t>(in.take());
    // Each time has at least one byte.
    if (!in.good() || count > kMostSamples || count > in.left() || unit <= 0) return fail(Code::malformed);
    const auto times = take_regular(in, static_cast<std::size_t>(count));
    if (!in.good()) return fail(Code::malformed);
    std::vector<HistorySample> samples(times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
        samples[i].time_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(times[i]) *
                                                       static_cast<std::uint64_t>(unit));
    take_previous(in, samples, times, unit);
    take_states(in, samples);
    take_values(in, samples);
    if (!in.good() || in.left() != 0) return fail(Code::malformed);
    return samples;
}

struct FreeCompressor {
    void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

/// The body with its plain length before it; empty: compression does not shorten it.
ByteVector compressed(const ByteVector& body) {
    thread_local const std::unique_ptr<ZSTD_CCtx, FreeCompressor> context(ZSTD_createCCtx());
    ByteVector out;
    put_varint(out, body.size());
    const std::size_t start = out.size();
    out.resize(start + ZSTD_compressBound(body.size()));
    const std::size_t size = ZSTD_compressCCtx(context.get(), out.data() + start, out.size() - start,
                                               body.data(), body.size(), kLevel);
    if (ZSTD_isError(size) != 0 || start + size >= body.size()) return {};
    out.resize(start + size);
    return out;
}

Result<ByteVector> decompressed(Bytes bytes) {
    thread_local const std::unique_ptr<ZSTD_DCtx, FreeCompressor> context(ZSTD_createDCtx());
    VarintReader in(bytes);
    const std::uint64_t length = in.take();
    if (!in.good() || length > kLargestBody) return fail(Code::malformed);
    ByteVector body(static_cast<std::size_t>(length));
    const Bytes frame = in.take_bytes(in.left());
    const std::size_t size =
        ZSTD_decompressDCtx(context.get(), body.data(), body.size(), frame.data(), frame.size());
    if (ZSTD_isError(size) != 0 || size != body.size()) return fail(Code::malformed);
    return body;
}

}  // namespace

bool same(const HistorySample& a, const HistorySample& b) {
    return a.time_ns == b.time_ns && a.previous_ns == b.previous_ns && value::same(a.value, b.value) &&
           a.quality == b.quality && a.reason == b.reason;
}

std::vector<std::uint8_t> encode_history(std::span<const HistorySample> samples,
                                         const HistoryCodecOptions& options) {
    TAKT_ASSERT(options.unit_ns > 0 && samples.size() <= kMostSamples);
    ByteVector body = body_of(samples, options.unit_ns);
    ByteVector packed = options.compress ? compressed(body) : ByteVector();
    ByteVector out{kChunkVersion, packed.empty() ? std::uint8_t{0} : kCompressed};
    const ByteVector& chosen = packed.empty() ? body : packed;
    out.insert(out.end(), chosen.begin(), chosen.end());
    put_little(out, crc32c(out));
    return out;
}

Result<std::vector<HistorySample>> decode_history(Bytes bytes) {
    if (bytes.size() < kChunkHeaderBytes + kCrc32cBytes) return fail(Code::malformed);
    const Bytes checked = bytes.first(bytes.size() - kCrc32cBytes);
    const auto checksum = LittleEndianReader(bytes.last(kCrc32cBytes)).take<std::uint32_t>();
    if (checksum != crc32c(checked) || bytes[0] != kChunkVersion || bytes[1] > kCompressed)
        return fail(Code::malformed);
    const Bytes stored = checked.subspan(kChunkHeaderBytes);
    if (bytes[1] != kCompressed) return samples_of(stored);
    TAKT_TRY(const ByteVector body, decompressed(stored));
    return samples_of(body);
}

}  // namespace takt::store
