// Format, version 2:
//
//   version (1 byte) | number of series (varint) | series ... | number of samples (varint) | samples ...
//
// A series: four texts (variable, device, line, unit), type (1 byte), scaled (1 byte). Each of these texts is
// the number of bytes that are equal to the beginning of the same text of the series before it (varint), the
// length of the rest (varint), and the rest: names of a plant have long common beginnings.
//
// A sample: number of its series (varint), flags (2 bytes, below), wall time in ns as the difference to the
// sample before it (zigzag varint), where flagged the time since the read before (varint) and the reason
// (varint), and the value: nothing, an integer (zigzag varint or varint), a double (8 bytes, little-endian;
// 4 bytes if a float has the same value), a text (length as varint, bytes).
//
// Varints are LEB128; zigzag as in Protocol Buffers.
#include "takt/publish/sample_codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>

#include "takt/base/assert.hpp"

namespace takt::publish {
namespace {

constexpr std::uint8_t kVersion = 2;

// Flags of a sample: quality in bits 0-1, cause in bits 2-3, kind of the value in bits 4-6: the alternative
// of value::Value, or kFloatKind.
constexpr unsigned kFloatKind = 6;
static_assert(std::variant_size_v<value::Value> == kFloatKind);
constexpr std::uint8_t kHasPrevious = 1U << 7U;
// In the second byte.
constexpr std::uint8_t kHasReason = 1U << 0U;
constexpr std::uint8_t kTrue = 1U << 1U;

constexpr std::size_t kMostHead = 1 + 10 + 10;  // version and the two counts

void put_varint(std::vector<std::uint8_t>& out, std::uint64_t number) {
    while (number >= 0x80) {
        out.push_back(static_cast<std::uint8_t>(number | 0x80U));
        number >>= 7U;
    }
    out.push_back(static_cast<std::uint8_t>(number));
}

void put_signed(std::vector<std::uint8_t>& out, std::int64_t number) {
    const auto bits = static_cast<std::uint64_t>(number);
    put_varint(out, (bits << 1U) ^ (number < 0 ? ~std::uint64_t{0} : 0));
}

void put_text(std::vector<std::uint8_t>& out, std::string_view text) {
    put_varint(out, text.size());
    out.insert(out.end(), text.begin(), text.end());
}

/// A text of a series, after the same text of the series before it.
void put_name(std::vector<std::uint8_t>& out, std::string_view before, std::string_view name) {
    const auto first_other = std::ranges::mismatch(before, name).in2;
    const auto equal = static_cast<std::size_t>(first_other - name.begin());
    put_varint(out, equal);
    put_text(out, name.substr(equal));
}

void put_series(std::vector<std::uint8_t>& out, const Series& before, const Series& series) {
    put_name(out, before.variable, series.variable);
    put_name(out, before.device, series.device);
    put_name(out, before.line, series.line);
    put_name(out, before.unit, series.unit);
    out.push_back(static_cast<std::uint8_t>(series.type));
    out.push_back(series.scaled ? 1 : 0);
}

bool is_float(const value::Value& value) {
    const auto* d = std::get_if<double>(&value);
    return d != nullptr && std::abs(*d) <= std::numeric_limits<float>::max() &&
           static_cast<double>(static_cast<float>(*d)) == *d;
}

template <class Bits>
void put_bits(std::vector<std::uint8_t>& out, Bits bits) {
    for (unsigned at = 0; at < 8 * sizeof bits; at += 8) out.push_back(static_cast<std::uint8_t>(bits >> at));
}

void put_value(std::vector<std::uint8_t>& out, const value::Value& value, unsigned kind) {
    if (const auto* i = std::get_if<std::int64_t>(&value)) return put_signed(out, *i);
    if (const auto* u = std::get_if<std::uint64_t>(&value)) return put_varint(out, *u);
    if (const auto* text = std::get_if<std::string>(&value))
        return put_text(out, std::string_view(*text).substr(0, kLongestTextValue));
    const auto* d = std::get_if<double>(&value);
    if (d == nullptr) return;
    if (kind == kFloatKind) return put_bits(out, std::bit_cast<std::uint32_t>(static_cast<float>(*d)));
    put_bits(out, std::bit_cast<std::uint64_t>(*d));
}

void put_sample(std::vector<std::uint8_t>& out, std::uint32_t series, const Sample& sample,
                std::int64_t base) {
    const auto previous = sample.previous_wall_ns;
    const auto* const boolean = std::get_if<bool>(&sample.value);
    const auto kind = is_float(sample.value) ? kFloatKind : static_cast<unsigned>(sample.value.index());
    put_varint(out, series);
    out.push_back(static_cast<std::uint8_t>(static_cast<unsigned>(sample.quality) |
                                            static_cast<unsigned>(sample.cause) << 2U | kind << 4U |
                                            (previous ? kHasPrevious : 0U)));
    out.push_back(static_cast<std::uint8_t>((sample.reason != value::Reason::ok ? kHasReason : 0U) |
                                            (boolean != nullptr && *boolean ? kTrue : 0U)));
    put_signed(out, sample.wall_ns - base);
    if (previous)
        put_varint(out, static_cast<std::uint64_t>(sample.wall_ns - std::min(*previous, sample.wall_ns)));
    if (sample.reason != value::Reason::ok) put_varint(out, static_cast<std::uint16_t>(sample.reason));
    put_value(out, sample.value, kind);
}

/// Takes numbers and texts from a payload. After the first error everything it returns is zero or empty.
class PayloadReader {
public:
    explicit PayloadReader(Bytes bytes) : rest_(bytes) {}

    [[nodiscard]] bool failed() const { return failed_; }
    [[nodiscard]] bool at_end() const { return rest_.empty(); }
    /// Bytes that are left: an upper limit for every count.
    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    void fail() {
        failed_ = true;
        rest_ = {};
    }

    std::uint8_t byte() {
        if (rest_.empty()) return fail(), std::uint8_t{0};
        const auto byte = rest_.front();
        rest_ = rest_.subspan(1);
        return byte;
    }
    std::uint64_t varint() {
        std::uint64_t number = 0;
        for (unsigned shift = 0; shift < 64; shift += 7) {
            const auto next = byte();
            number |= static_cast<std::uint64_t>(next & 0x7FU) << shift;
            if ((next & 0x80U) == 0) return number;
        }
        return fail(), 0;
    }
    std::int64_t signed_varint() {
        const auto bits = varint();
        return static_cast<std::int64_t>((bits >> 1U) ^ (~(bits & 1U) + 1U));
    }
    std::string text() {
        const auto size = varint();
        if (size > rest_.size()) return fail(), std::string();
        std::string text(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(size));
        rest_ = rest_.subspan(static_cast<std::size_t>(size));
        return text;
    }
    /// A text of a series, after the same text of the series before it.
    std::string name(std::string_view before) {
        const auto equal = varint();
        if (equal > before.size()) return fail(), std::string();
        return std::string(before.substr(0, static_cast<std::size_t>(equal))) + text();
    }
    template <class Bits>
    Bits bits() {
        Bits bits = 0;
        for (unsigned at = 0; at < 8 * sizeof bits; at += 8) bits |= static_cast<Bits>(byte()) << at;
        return bits;
    }
    /// A count of things that take at least one byte each.
    std::size_t count() {
        const auto count = varint();
        if (count > left()) return fail(), 0;
        return static_cast<std::size_t>(count);
    }

private:
    Bytes rest_;
    bool failed_ = false;
};

Series take_series(PayloadReader& reader, const Series& before) {
    Series series;
    series.variable = reader.name(before.variable);
    series.device = reader.name(before.device);
    series.line = reader.name(before.line);
    series.unit = reader.name(before.unit);
    const auto type = reader.byte();
    if (type > static_cast<std::uint8_t>(DataType::string)) reader.fail();
    series.type = static_cast<DataType>(type);
    series.scaled = reader.byte() != 0;
    return series;
}

value::Value take_value(PayloadReader& reader, unsigned kind, bool is_true) {
    switch (kind) {
        case 0: return std::monostate{};
        case 1: return is_true;
        case 2: return reader.signed_varint();
        case 3: return reader.varint();
        case 4: return std::bit_cast<double>(reader.bits<std::uint64_t>());
        case 5: return reader.text();
        case kFloatKind: return static_cast<double>(std::bit_cast<float>(reader.bits<std::uint32_t>()));
        default: return reader.fail(), std::monostate{};
    }
}

Sample take_sample(PayloadReader& reader, std::size_t series_count, std::int64_t& base) {
    Sample sample;
    const auto series = reader.varint();
    if (series >= series_count) reader.fail();
    sample.series = static_cast<std::uint32_t>(series);
    const auto flags = reader.byte();
    const auto more = reader.byte();
    sample.quality = static_cast<value::Quality>(flags & 3U);
    sample.cause = static_cast<SampleCause>((flags >> 2U) & 3U);
    // Wrapping arithmetic: the differences of a damaged payload may be anything.
    base = static_cast<std::int64_t>(static_cast<std::uint64_t>(base) +
                                     static_cast<std::uint64_t>(reader.signed_varint()));
    sample.wall_ns = base;
    if ((flags & kHasPrevious) != 0)
        sample.previous_wall_ns =
            static_cast<std::int64_t>(static_cast<std::uint64_t>(base) - reader.varint());
    if ((more & kHasReason) != 0) sample.reason = static_cast<value::Reason>(reader.varint());
    sample.value = take_value(reader, (flags >> 4U) & 7U, (more & kTrue) != 0);
    return sample;
}

}  // namespace

std::string_view name(SampleCause cause) {
    switch (cause) {
        case SampleCause::change: return "change";
        case SampleCause::period: return "period";
        case SampleCause::heartbeat: return "heartbeat";
        case SampleCause::current: return "current";
    }
    return "";
}

SamplePayload::SamplePayload(std::size_t limit) : limit_(limit) {
    TAKT_ASSERT(limit >= 1024);
}

std::size_t SamplePayload::bytes() const {
    return kMostHead + series_.size() + body_.size();
}

bool SamplePayload::add(const Series& series, const Sample& sample) {
    if (sample.series >= local_of_.size()) local_of_.resize(sample.series + 1);
    auto& local = local_of_[sample.series];
    scratch_.clear();
    if (local == 0) put_series(scratch_, last_series_, series);
    const auto series_bytes = scratch_.size();
    const auto number = local == 0 ? static_cast<std::uint32_t>(used_.size()) : local - 1;
    put_sample(scratch_, number, sample, base_);
    if (bytes() + scratch_.size() > limit_) return false;

    const auto split = scratch_.begin() + static_cast<std::ptrdiff_t>(series_bytes);
    series_.insert(series_.end(), scratch_.begin(), split);
    body_.insert(body_.end(), split, scratch_.end());
    if (local == 0) {
        used_.push_back(sample.series);
        last_series_ = series;
        local = number + 1;
    }
    newest_ = count_ == 0 ? sample.wall_ns : std::max(newest_, sample.wall_ns);
    base_ = sample.wall_ns;
    ++count_;
    return true;
}

std::vector<std::uint8_t> SamplePayload::take() {
    std::vector<std::uint8_t> payload;
    payload.reserve(bytes());
    payload.push_back(kVersion);
    put_varint(payload, used_.size());
    payload.insert(payload.end(), series_.begin(), series_.end());
    put_varint(payload, count_);
    payload.insert(payload.end(), body_.begin(), body_.end());
    for (const auto used : used_) local_of_[used] = 0;
    series_.clear();
    body_.clear();
    used_.clear();
    last_series_ = {};
    count_ = 0;
    base_ = newest_ = 0;
    return payload;
}

Result<SampleBatch> decode_samples(Bytes payload) {
    PayloadReader reader(payload);
    if (reader.byte() != kVersion) return fail(Code::malformed, "samples");
    SampleBatch batch;
    const auto series_count = reader.count();
    for (std::size_t i = 0; i < series_count && !reader.failed(); ++i)
        batch.series.push_back(take_series(reader, i == 0 ? Series{} : batch.series.back()));
    const auto count = reader.count();
    std::int64_t base = 0;
    for (std::size_t i = 0; i < count && !reader.failed(); ++i)
        batch.samples.push_back(take_sample(reader, batch.series.size(), base));
    if (reader.failed() || !reader.at_end()) return fail(Code::malformed, "samples");
    return batch;
}

}  // namespace takt::publish
