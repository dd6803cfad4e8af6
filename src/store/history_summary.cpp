// The roll-ups of minutes are three chunks of samples: their numbers reuse the codec of history_codec.hpp,
// and so does their checksum. Each minute gives a sample for first, minimum, maximum and last; the other
// figures are small integers and two doubles.
#include "history_summary.hpp"

#include <algorithm>
#include <cmath>
#include <variant>

#include "history_bytes.hpp"
#include "takt/store/history_codec.hpp"

namespace takt::store {
namespace {

constexpr std::int64_t kMinute = 60'000'000'000;
constexpr double kSecond = 1e9;
constexpr std::uint64_t kMostMinutes = 100'000;

double seconds(std::int64_t from_ns, std::int64_t to_ns) {
    return static_cast<double>(to_ns - from_ns) / kSecond;
}

HistorySample number_sample(std::int64_t time_ns, double value) {
    return {.time_ns = time_ns, .value = value};
}

enum Flag : std::uint8_t { kMixed = 1, kEndsGood = 2, kEndsWithNumber = 4, kHasNumber = 8 };

void put_chunk(ByteVector& out, std::span<const HistorySample> samples) {
    const auto bytes = encode_history(samples);
    put_varint(out, bytes.size());
    out.insert(out.end(), bytes.begin(), bytes.end());
}

std::vector<HistorySample> take_chunk(VarintReader& in, std::size_t count) {
    auto samples = decode_history(in.take_bytes(in.take()));
    if (!samples || samples->size() != count) in.fail();
    return in.good() ? std::move(*samples) : std::vector<HistorySample>(count);
}

double number_of(const HistorySample& sample) {
    const auto* const number = std::get_if<double>(&sample.value);
    return number != nullptr ? *number : 0;
}

}  // namespace

std::optional<double> drawn_number(const HistorySample& sample) {
    if (sample.quality != value::Quality::good && sample.quality != value::Quality::uncertain) return {};
    if (const auto* const real = std::get_if<double>(&sample.value))
        return std::isfinite(*real) ? std::optional(*real) : std::nullopt;
    if (const auto* const integer = std::get_if<std::int64_t>(&sample.value))
        return static_cast<double>(*integer);
    if (const auto* const integer = std::get_if<std::uint64_t>(&sample.value))
        return static_cast<double>(*integer);
    if (const auto* const bit = std::get_if<bool>(&sample.value)) return *bit ? 1 : 0;
    return {};
}

std::int64_t hold_end(std::int64_t from_ns, std::int64_t to_ns, std::span<const HistoryGap> gaps) {
    const auto gap = std::ranges::lower_bound(gaps, from_ns, {}, &HistoryGap::first_ns);
    return gap == gaps.end() ? to_ns : std::min(to_ns, gap->first_ns);
}

HistorySummary summary_of(const HistorySample& sample) {
    HistorySummary summary{.begin_ns = sample.time_ns,
                           .end_ns = sample.time_ns,
                           .samples = 1,
                           .quality = sample.quality,
                           .reason = sample.reason,
                           .ends_good = sample.quality == value::Quality::good};
    if (const auto number = drawn_number(sample)) {
        summary.numbers = 1;
        summary.first = {sample.time_ns, *number, sample.previous_ns};
        summary.min = summary.max = summary.last = summary.first;
        summary.ends_with_number = true;
    }
    return summary;
}

void append(HistorySummary& summary, const HistorySummary& next, std::span<const HistoryGap> gaps) {
    const double held = seconds(summary.end_ns, hold_end(summary.end_ns, next.begin_ns, gaps));
    if (summary.ends_with_number) {
        summary.area += summary.last.value * held;
        summary.drawn_s += held;
    }
    if (summary.ends_good) summary.good_s += held;
    summary.area += next.area;
    summary.drawn_s += next.drawn_s;
    summary.good_s += next.good_s;
    summary.mixed =
        summary.mixed || next.mixed || next.quality != summary.quality || next.reason != summary.reason;
    if (next.numbers > 0) {
        if (summary.numbers == 0) {
            summary.first = next.first;
            summary.min = next.min;
            summary.max = next.max;
        }
        if (next.min.value < summary.min.value) summary.min = next.min;
        if (next.max.value > summary.max.value) summary.max = next.max;
        summary.last = next.last;
    }
    summary.numbers += next.numbers;
    summary.samples += next.samples;
    summary.end_ns = next.end_ns;
    summary.ends_good = next.ends_good;
    summary.ends_with_number = next.ends_with_number;
}

HistorySummary summary_of(std::span<const HistorySample> samples, std::span<const HistoryGap> gaps) {
    HistorySummary summary = summary_of(samples.front());
    for (const auto& sample : samples.subspan(1)) append(summary, summary_of(sample), gaps);
    return summary;
}

std::vector<std::uint8_t> encode_minutes(std::span<const HistorySample> samples,
                                         std::span<const HistoryGap> gaps) {
    ByteVector head;
    std::vector<HistorySample> points;
    std::vector<HistorySample> figures;
    std::uint64_t count = 0;
    const auto minute_of = [](const HistorySample& sample) { return sample.time_ns / kMinute; };
    while (!samples.empty()) {
        const auto end = std::ranges::find_if(
            samples, [&](const auto& sample) { return minute_of(sample) != minute_of(samples.front()); });
        const auto length = static_cast<std::size_t>(end - samples.begin());
        const auto minute = summary_of(samples.first(length), gaps);
        samples = samples.subspan(length);
        ++count;
        put_varint(head, minute.samples);
        put_varint(head, minute.numbers);
        head.push_back(static_cast<std::uint8_t>(
            (minute.mixed ? kMixed : 0) | (minute.ends_good ? kEndsGood : 0) |
            (minute.ends_with_number ? kEndsWithNumber : 0) | (minute.numbers > 0 ? kHasNumber : 0)));
        HistorySample begin = number_sample(minute.begin_ns, 0);
        begin.quality = minute.quality;
        begin.reason = minute.reason;
        figures.push_back(begin);
        figures.push_back(number_sample(minute.end_ns, minute.drawn_s));
        figures.push_back(number_sample(minute.end_ns, minute.good_s));
        figures.push_back(number_sample(minute.end_ns, minute.area));
        if (minute.numbers == 0) continue;
        for (const auto& point : {minute.first, minute.min, minute.max, minute.last})
            points.push_back(number_sample(point.time_ns, point.value));
    }
    ByteVector out;
    put_varint(out, count);
    out.insert(out.end(), head.begin(), head.end());
    put_chunk(out, points);
    put_chunk(out, figures);
    return out;
}

Result<std::vector<HistorySummary>> decode_minutes(Bytes bytes) {
    VarintReader in(bytes);
    const std::uint64_t count = in.take();
    if (count > kMostMinutes || count > in.left()) in.fail();
    std::vector<HistorySummary> minutes(in.good() ? static_cast<std::size_t>(count) : 0);
    std::size_t with_numbers = 0;
    for (auto& minute : minutes) {
        minute.samples = in.take();
        minute.numbers = in.take();
        const Bytes flags = in.take_bytes(1);
        const std::uint8_t set = in.good() ? flags[0] : 0;
        minute.mixed = (set & kMixed) != 0;
        minute.ends_good = (set & kEndsGood) != 0;
        minute.ends_with_number = (set & kEndsWithNumber) != 0;
        if (minute.numbers > 0) ++with_numbers;
    }
    const auto points = take_chunk(in, 4 * with_numbers);
    const auto figures = take_chunk(in, 4 * minutes.size());
    if (!in.good() || in.left() != 0) return fail(Code::malformed);
    const HistorySample* point = points.data();
    const HistorySample* figure = figures.data();
    for (auto& minute : minutes) {
        minute.begin_ns = figure->time_ns;
        minute.quality = figure->quality;
        minute.reason = figure++->reason;
        minute.end_ns = figure->time_ns;
        minute.drawn_s = number_of(*figure++);
        minute.good_s = number_of(*figure++);
        minute.area = number_of(*figure++);
        if (minute.numbers == 0) continue;
        for (HistoryPoint* to : {&minute.first, &minute.min, &minute.max, &minute.last}) {
            *to = {point->time_ns, number_of(*point), std::nullopt};
            ++point;
        }
    }
    return minutes;
}

}  // namespace takt::store
