#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <map>

#include "history/history_summary.hpp"
#include "history_rig.hpp"

namespace takt::store {
namespace history_picture_test {

using namespace history_rig;

struct Stored {
    takt::test::Folder folder;
    std::string path = folder.path() + "/a.history.db";
    std::unique_ptr<History> history;
    SeriesId id;
    std::vector<HistorySample> samples;

    explicit Stored(const HistoryOptions& options = {})
        : history(std::move(History::open(path, options)->history)),
          id(history->series({"a", "", DataType::float64, false, ""}).value()) {}
    void append(const HistorySample& sample) {
        samples.push_back(sample);
        history->append(id, sample);
    }
    HistoryPicture picture(const HistoryRange& range, std::size_t pixels) {
        auto picture = HistoryReader::open(path)->picture(id, range, pixels);
        EXPECT_TRUE(picture);
        return *picture;
    }
};

/// The picture's pixels as they follow from the definition.
std::map<std::size_t, HistoryPixel> expected_pixels(std::vector<HistorySample> samples,
                                                    const HistoryRange& range, std::size_t pixels) {
    std::ranges::stable_sort(samples, {}, &HistorySample::time_ns);
    std::map<std::size_t, HistoryPixel> all;
    for (const auto& sample : samples) {
        if (sample.time_ns < range.from_ns || sample.time_ns >= range.to_ns) continue;
        const double share = static_cast<double>(sample.time_ns - range.from_ns) /
                             static_cast<double>(range.to_ns - range.from_ns);
        HistoryPixel& pixel =
            all[std::min(static_cast<std::size_t>(share * static_cast<double>(pixels)), pixels - 1)];
        ++pixel.samples;
        const auto number = drawn_number(sample);
        if (!number) continue;
        const HistoryPoint point{sample.time_ns, *number, {}};
        if (!pixel.has_value) pixel.first = pixel.min = pixel.max = point;
        pixel.has_value = true;
        if (*number < pixel.min.value) pixel.min = point;
        if (*number > pixel.max.value) pixel.max = point;
        pixel.last = point;
    }
    return all;
}

bool equal(const HistoryPoint& a, const HistoryPoint& b) {
    return a.time_ns == b.time_ns && a.value == b.value;
}

RC_GTEST_PROP(HistoryPicture, HasTheExtremesOfTheSamplesInEachPixel, ()) {
    Stored stored({.retention = Duration::zero(),
                   .chunk_samples = *rc::gen::inRange<std::size_t>(1, 60),
                   .log_commits = *rc::gen::inRange<std::size_t>(1, 5)});
    const int count = *rc::gen::inRange(0, 150);
    const std::int64_t step = *rc::gen::element<std::int64_t>(100, 1000, 7000, 60'000, 1'000'000);
    std::int64_t ms = 0;
    for (int i = 0; i < count; ++i) {
        ms += *rc::gen::weightedElement<std::int64_t>({{30, step}, {5, step + 1}, {3, 0}, {1, -20 * step}});
        HistorySample sample{.time_ns = kStart + ms * 1'000'000,
                             .value = *rc::gen::inRange(-500, 500) / 10.0};
        if (*rc::gen::inRange(0, 12) == 0) sample.quality = value::Quality::bad;
        stored.append(sample);
        if (i % 30 == 29) RC_ASSERT(stored.history->commit(kStart).has_value());
    }
    RC_ASSERT(stored.history->commit(kStart + 1000 * kHour).has_value());
    const std::int64_t length = std::max<std::int64_t>(ms, 1000) * 1'000'000;
    const HistoryRange range{kStart - *rc::gen::inRange<std::int64_t>(-length / 3, length / 3),
                             kStart + length + 1};
    const auto pixels = *rc::gen::inRange<std::size_t>(1, 400);
    const auto picture = stored.picture(range, pixels);
    const auto expected = expected_pixels(stored.samples, range, pixels);
    RC_ASSERT(picture.pixels.size() == expected.size());
    for (const auto& pixel : picture.pixels) {
        const auto& wanted = expected.at(pixel.index);
        RC_ASSERT(pixel.samples == wanted.samples);
        RC_ASSERT(pixel.has_value == wanted.has_value);
        RC_ASSERT(equal(pixel.first, wanted.first) && equal(pixel.last, wanted.last));
        RC_ASSERT(equal(pixel.min, wanted.min) && equal(pixel.max, wanted.max));
    }
}

TEST(HistoryPicture, UsesRollUpsAndStillShowsASpike) {
    Stored stored({.log_commits = 1});
    for (int i = 0; i < 86'400; ++i)
        stored.append({.time_ns = kStart + i * kSecond, .value = i == 40'000 ? 1e6 : i % 7 / 10.0});
    ASSERT_TRUE(stored.history->commit(kStart + 24 * kHour));
    for (const std::size_t pixels : {1U, 10U, 24U, 40U}) {
        const auto picture = stored.picture({kStart, kStart + 24 * kHour}, pixels);
        EXPECT_EQ(picture.samples, 86'400U);
        EXPECT_GT(picture.rolled_up, 0U) << pixels;
        EXPECT_EQ(picture.max, 1e6);
        const auto spike = std::ranges::max_element(
            picture.pixels, {}, [](const HistoryPixel& pixel) { return pixel.max.value; });
        EXPECT_EQ(spike->max.time_ns, kStart + 40'000 * kSecond) << pixels;
        EXPECT_NEAR(*picture.mean, 0.3 + 1e6 / 86'400, 0.001) << pixels;
        EXPECT_NEAR(picture.good_share, 1, 1e-9) << pixels;
    }
}

TEST(HistoryPicture, EndsAValueAtAGapAndBeginsWithTheOneBefore) {
    Stored stored;
    stored.append({.time_ns = kStart, .value = 10.0});
    stored.history->append(HistoryGap{kStart + 40 * kSecond, kStart + 60 * kSecond, GapCause::restart, 0});
    stored.append({.time_ns = kStart + 60 * kSecond, .previous_ns = kStart + 59 * kSecond, .value = 20.0});
    stored.append({.time_ns = kStart + 80 * kSecond,
                   .value = 20.0,
                   .quality = value::Quality::bad,
                   .reason = value::Reason::timeout});
    ASSERT_TRUE(stored.history->commit(kStart + 100 * kSecond));
    const auto picture = stored.picture({kStart + 20 * kSecond, kStart + 120 * kSecond}, 100);
    ASSERT_TRUE(picture.before);
    EXPECT_EQ(picture.before->value, value::Value(10.0));
    ASSERT_EQ(picture.gaps.size(), 1U);
    EXPECT_EQ(picture.gaps[0].cause, GapCause::restart);
    ASSERT_EQ(picture.bad.size(), 1U);
    EXPECT_EQ(picture.bad[0].reason, value::Reason::timeout);
    EXPECT_EQ(picture.bad[0].range.from_ns, kStart + 80 * kSecond);
    EXPECT_EQ(picture.bad[0].range.to_ns, kStart + 100 * kSecond);  // the last commit
    EXPECT_NEAR(*picture.mean, (10.0 * 20 + 20.0 * 20) / 40, 1e-9);
    EXPECT_NEAR(picture.good_share, 0.4, 1e-9);
    ASSERT_EQ(picture.pixels.size(), 2U);
    EXPECT_EQ(picture.pixels[0].first.previous_ns, kStart + 59 * kSecond);
    EXPECT_EQ(picture.min, 10.0);
}

TEST(HistoryPicture, TheGoodShareCountsFromTheFirstPoll) {
    Stored stored;
    stored.append({.time_ns = kStart + 10 * kSecond, .quality = value::Quality::never_read});
    stored.append({.time_ns = kStart + 60 * kSecond, .value = 1.0});
    ASSERT_TRUE(stored.history->commit(kStart + 100 * kSecond));
    EXPECT_NEAR(stored.picture({kStart, kStart + 100 * kSecond}, 100).good_share, 1, 1e-9);
    EXPECT_NEAR(stored.picture({kStart + 20 * kSecond, kStart + 100 * kSecond}, 10).good_share, 1, 1e-9);
    EXPECT_EQ(stored.picture({kStart, kStart + 50 * kSecond}, 10).good_share, 0);
    EXPECT_NEAR(stored.picture({kStart + 70 * kSecond, kStart + 110 * kSecond}, 10).good_share, 0.75, 1e-9);
}

TEST(HistoryPicture, RefusesAnEmptyRange) {
    Stored stored;
    auto reader = HistoryReader::open(stored.path);
    EXPECT_EQ(reader->picture(stored.id, {5, 5}, 10).error().code, Code::out_of_range);
    EXPECT_EQ(reader->picture(stored.id, {5, 6}, 0).error().code, Code::out_of_range);
    EXPECT_EQ(reader->picture(stored.id, {5, 6}, 10)->pixels.size(), 0U);
}

}  // namespace history_picture_test
}  // namespace takt::store
