#include "takt/publish/sample_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace takt::publish {
namespace sample_codec_test {

const Series kPower{"Power", "Meter", "rs485-1", "kW", DataType::float32, true};
const Series kGo{"go", "", "", "", DataType::boolean, false};

void expect_same(const Sample& a, const Sample& b) {
    EXPECT_TRUE(value::same(a.value, b.value));
    EXPECT_EQ(a.quality, b.quality);
    EXPECT_EQ(a.reason, b.reason);
    EXPECT_EQ(a.cause, b.cause);
    EXPECT_EQ(a.wall_ns, b.wall_ns);
    EXPECT_EQ(a.previous_wall_ns, b.previous_wall_ns);
}

TEST(SampleCodec, KeepsEverySample) {
    constexpr std::int64_t kNow = 1'764'000'000'123'456'789;
    const Sample samples[] = {
        {.series = 7, .value = 0.1, .wall_ns = kNow, .previous_wall_ns = kNow - 100'000'000},
        {.series = 7, .value = std::nan(""), .quality = value::Quality::uncertain, .wall_ns = kNow - 5},
        {.series = 2, .value = true, .cause = SampleCause::heartbeat, .wall_ns = kNow},
        {.series = 2, .value = false, .cause = SampleCause::period, .wall_ns = -1, .previous_wall_ns = -1},
        {.series = 7, .value = std::int64_t{std::numeric_limits<std::int64_t>::min()}, .wall_ns = kNow},
        {.series = 7, .value = std::uint64_t{UINT64_MAX}, .cause = SampleCause::current, .wall_ns = 0},
        {.series = 7, .value = std::string("Ж\0x", 4), .wall_ns = kNow},
        {.series = 2,
         .value = std::monostate{},
         .quality = value::Quality::bad,
         .reason = value::exception_reason(2),
         .wall_ns = std::numeric_limits<std::int64_t>::max(),
         .previous_wall_ns = std::numeric_limits<std::int64_t>::max() - 1},
    };
    SamplePayload payload(4096);
    for (const auto& sample : samples) ASSERT_TRUE(payload.add(sample.series == 7 ? kPower : kGo, sample));
    EXPECT_EQ(payload.samples(), std::size(samples));
    EXPECT_EQ(payload.newest_wall_ns(), std::numeric_limits<std::int64_t>::max());
    const auto bytes = payload.take();
    EXPECT_TRUE(payload.empty());

    const auto batch = decode_samples(bytes);
    ASSERT_TRUE(batch);
    EXPECT_EQ(batch->series, (std::vector<Series>{kPower, kGo}));
    ASSERT_EQ(batch->samples.size(), std::size(samples));
    for (std::size_t i = 0; i < std::size(samples); ++i) {
        expect_same(batch->samples[i], samples[i]);
        EXPECT_EQ(batch->samples[i].series, samples[i].series == 7 ? 0U : 1U);
    }
}

TEST(SampleCodec, AFullPayloadRejectsASampleAndKeepsWhatItHas) {
    SamplePayload payload(1024);
    std::size_t added = 0;
    while (payload.add(kPower, {.series = 0, .value = std::string(100, 'a'), .wall_ns = 5})) ++added;
    EXPECT_GT(added, 5U);
    EXPECT_LE(payload.bytes(), 1024U);
    const auto expected_bytes = payload.bytes();
    const auto bytes = payload.take();
    EXPECT_LE(bytes.size(), expected_bytes);
    EXPECT_EQ(decode_samples(bytes)->samples.size(), added);
    // The series is in the next payload again.
    ASSERT_TRUE(payload.add(kPower, {.series = 0, .value = 1.0}));
    EXPECT_EQ(decode_samples(payload.take())->series, std::vector<Series>{kPower});
}

TEST(SampleCodec, KeepsEveryFloatingNumber) {
    const double numbers[] = {0.0,    -0.0,    1.5,
                              0.1,    -1e300,  static_cast<double>(0.1F),
                              5e-324, 1.0e-45, static_cast<double>(std::numeric_limits<float>::max()),
                              3.5e38, HUGE_VAL};
    SamplePayload payload(1024);
    for (const double number : numbers) ASSERT_TRUE(payload.add(kPower, {.series = 0, .value = number}));
    const auto batch = decode_samples(payload.take());
    ASSERT_TRUE(batch);
    for (std::size_t i = 0; i < std::size(numbers); ++i)
        EXPECT_TRUE(value::same(batch->samples[i].value, numbers[i])) << numbers[i];
}

TEST(SampleCodec, NamesWithACommonBeginningAreShort) {
    const Series series[] = {{"Power-1", "Meter-1", "line", "kW"},
                             {"Power-12", "Meter-1", "line", "kW"},
                             {"Power", "Meter-2", "line", ""},
                             {"Flow", "", "", "m³/h", DataType::uint32, true}};
    SamplePayload payload(1024);
    for (std::uint32_t i = 0; i < std::size(series); ++i) {
        const auto before = payload.bytes();
        ASSERT_TRUE(payload.add(series[i], {.series = i, .value = true}));
        if (i == 1) {
            EXPECT_LE(payload.bytes() - before, 16U);
        }
    }
    const auto batch = decode_samples(payload.take());
    ASSERT_TRUE(batch);
    ASSERT_EQ(batch->series.size(), std::size(series));
    for (std::size_t i = 0; i < std::size(series); ++i) EXPECT_EQ(batch->series[i], series[i]);
}

TEST(SampleCodec, CutsALongText) {
    SamplePayload payload(1024);
    ASSERT_TRUE(payload.add(kPower, {.series = 0, .value = std::string(5000, 'a')}));
    const auto batch = decode_samples(payload.take());
    ASSERT_TRUE(batch);
    EXPECT_EQ(std::get<std::string>(batch->samples[0].value).size(), kLongestTextValue);
}

TEST(SampleCodec, RejectsEveryPayloadThatIsCut) {
    SamplePayload payload(1024);
    ASSERT_TRUE(payload.add(kPower, {.series = 0, .value = 1.5, .wall_ns = 1000, .previous_wall_ns = 500}));
    ASSERT_TRUE(payload.add(kGo, {.series = 1, .value = true, .wall_ns = 2000}));
    const auto bytes = payload.take();
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_FALSE(decode_samples(Bytes(bytes).first(size))) << size;
    auto longer = bytes;
    longer.push_back(0);
    EXPECT_FALSE(decode_samples(longer));
    auto later_version = bytes;
    later_version[0] = 3;
    EXPECT_FALSE(decode_samples(later_version));
}

TEST(SampleCodec, RandomBytesAreDecodedOrRejected) {
    std::mt19937 random(1);
    for (int round = 0; round < 20'000; ++round) {
        std::vector<std::uint8_t> bytes(random() % 60);
        for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random() % (round % 2 == 0 ? 256 : 8));
        if (!bytes.empty()) bytes[0] = 2;
        if (const auto batch = decode_samples(bytes)) {
            for (const auto& sample : batch->samples) EXPECT_LT(sample.series, batch->series.size());
        }
    }
}

}  // namespace sample_codec_test
}  // namespace takt::publish
