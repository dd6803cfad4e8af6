#include "takt/store/history_codec.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "history/history_bytes.hpp"
#include "history/history_log.hpp"
#include "journal/little_endian.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace history_codec_test {

using Samples = std::vector<HistorySample>;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kStart = 1'790'000'000'000 * kMs;

void expect_same(const Samples& a, const Samples& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(same(a[i], b[i])) << i;
}

void expect_restored(const Samples& samples) {
    for (const bool compress : {false, true}) {
        const auto restored = decode_history(encode_history(samples, {.compress = compress}));
        ASSERT_TRUE(restored);
        expect_same(*restored, samples);
    }
}

Samples of_values(const std::vector<value::Value>& values) {
    Samples samples;
    for (const auto& value : values)
        samples.push_back(
            {.time_ns = kStart + static_cast<std::int64_t>(samples.size()) * 1000 * kMs, .value = value});
    return samples;
}

double bytes_each(const Samples& samples) {
    return static_cast<double>(encode_history(samples).size()) / static_cast<double>(samples.size());
}

TEST(HistoryCodec, RestoresNothing) {
    expect_restored({});
}

TEST(HistoryCodec, RestoresExtremeValuesExactly) {
    using D = std::numeric_limits<double>;
    using I = std::numeric_limits<std::int64_t>;
    expect_restored(of_values({I::min(), I::max(), std::int64_t{0}, I::min(), I::min()}));
    expect_restored(
        of_values({std::numeric_limits<std::uint64_t>::max(), std::uint64_t{0}, std::uint64_t{7}}));
    expect_restored(
        of_values({0.0, -0.0, D::infinity(), -D::infinity(), D::denorm_min(), D::max(), 0.1, 1e-300}));
    expect_restored(of_values({std::nan(""), 1.0}));
    expect_restored(
        of_values({static_cast<double>(0.1F), static_cast<double>(3.4e38F), static_cast<double>(-0.0F)}));
    expect_restored(of_values({std::string("on"), std::string(), std::string("on"), std::string(300, 'x')}));
    expect_restored(of_values({true, true, false, true}));
    expect_restored(
        of_values({{}, true, 1.5, {}, std::int64_t{-3}, std::string("a"), std::uint64_t{3}, 2.5}));
}

TEST(HistoryCodec, RoundsTimesDownToItsUnit) {
    Samples samples{{.time_ns = kStart + 999'999, .previous_ns = kStart - 1, .value = 1.0},
                    {.time_ns = -1, .value = 2.0}};
    const auto restored = decode_history(encode_history(samples));
    ASSERT_TRUE(restored);
    EXPECT_EQ((*restored)[0].time_ns, kStart);
    EXPECT_EQ((*restored)[0].previous_ns, kStart - kMs);
    EXPECT_EQ((*restored)[1].time_ns, -kMs);
}

TEST(HistoryCodec, CostsAFewBytesForScaledSteps) {
    Samples samples;
    for (int i = 0; i < 1000; ++i)
        samples.push_back({.time_ns = kStart + i * 1000 * kMs,
                           .previous_ns = kStart + (i - 1) * 1000 * kMs,
                           .value = 200.0 + 0.5 * (i * 7 % 5)});
    EXPECT_LT(bytes_each(samples), 0.2);
    expect_restored(samples);
}

HistorySample random_sample(std::int64_t& time) {
    time += *rc::gen::element<std::int64_t>(1000, 1001, 999, 0, -5000, 7'200'000) * kMs;
    HistorySample sample{.time_ns = time};
    if (*rc::gen::inRange(0, 3) > 0)
        sample.previous_ns = time - *rc::gen::inRange<std::int64_t>(0, 3000) * kMs;
    sample.quality = *rc::gen::element(value::Quality::good, value::Quality::good, value::Quality::bad,
                                       value::Quality::uncertain, value::Quality::never_read);
    if (sample.quality != value::Quality::good)
        sample.reason = *rc::gen::element(value::Reason::timeout, value::Reason(300));
    switch (*rc::gen::inRange(0, 7)) {
        case 0: break;
        case 1: sample.value = *rc::gen::arbitrary<bool>(); break;
        case 2: sample.value = *rc::gen::arbitrary<std::int64_t>(); break;
        case 3: sample.value = *rc::gen::arbitrary<std::uint64_t>(); break;
        case 4: sample.value = *rc::gen::arbitrary<double>(); break;
        case 5: sample.value = *rc::gen::inRange(-1000, 1000) / 10.0; break;
        default: sample.value = *rc::gen::string<std::string>();
    }
    return sample;
}

Samples random_samples() {
    Samples samples;
    std::int64_t time = kStart;
    const int count = *rc::gen::inRange(0, 40);
    for (int i = 0; i < count; ++i) samples.push_back(random_sample(time));
    return samples;
}

RC_GTEST_PROP(HistoryCodec, RestoresAnySamples, ()) {
    const auto samples = random_samples();
    for (const bool compress : {false, true}) {
        const auto restored = decode_history(encode_history(samples, {.compress = compress}));
        RC_ASSERT(restored.has_value());
        RC_ASSERT(std::ranges::equal(*restored, samples, same));
    }
}

RC_GTEST_PROP(HistoryLog, RestoresAnySamples, ()) {
    std::vector<LoggedSample> logged;
    for (const auto& sample : random_samples())
        logged.push_back({SeriesId{static_cast<std::uint32_t>(*rc::gen::inRange(0, 1000))}, sample});
    const auto restored = decode_log(encode_log(logged));
    RC_ASSERT(restored.has_value());
    RC_ASSERT(restored->size() == logged.size());
    for (std::size_t i = 0; i < logged.size(); ++i)
        RC_ASSERT((*restored)[i].series == logged[i].series && same((*restored)[i].sample, logged[i].sample));
}

// The checksum hides damage from the decoder, so here it fits the damaged bytes.
RC_GTEST_PROP(HistoryCodec, SurvivesArbitraryBytes, ()) {
    auto bytes = encode_history(random_samples(), {.compress = *rc::gen::arbitrary<bool>()});
    bytes.resize(bytes.size() - 4);
    const int changes = *rc::gen::inRange(1, 5);
    for (int i = 0; i < changes; ++i)
        bytes[*rc::gen::inRange<std::size_t>(2, bytes.size())] = *rc::gen::arbitrary<std::uint8_t>();
    bytes.resize(*rc::gen::inRange<std::size_t>(2, bytes.size() + 1));
    put_little(bytes, crc32c(bytes));
    static_cast<void>(decode_history(bytes));
    static_cast<void>(decode_log(bytes));
}

TEST(HistoryCodec, SurvivesALogWithTimesOutOfRange) {
    for (const std::int64_t ms : {INT64_MAX, INT64_MIN}) {
        ByteVector bytes;
        put_varint(bytes, 1);
        put_signed(bytes, ms);
        bytes.push_back(1 << 6);
        put_signed(bytes, -1);
        put_little(bytes, crc32c(bytes));
        EXPECT_TRUE(decode_log(bytes));
    }
}

RC_GTEST_PROP(HistoryCodec, ReportsDamage, ()) {
    auto bytes = encode_history(random_samples(), {.compress = *rc::gen::arbitrary<bool>()});
    const auto at = *rc::gen::inRange<std::size_t>(0, bytes.size());
    bytes[at] = static_cast<std::uint8_t>(bytes[at] ^ (1 << *rc::gen::inRange(0, 8)));
    RC_ASSERT(!decode_history(bytes));
    RC_ASSERT(!decode_history(Bytes(bytes).first(at)));
}

}  // namespace history_codec_test
}  // namespace takt::store
