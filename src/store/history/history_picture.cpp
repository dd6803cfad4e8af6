#include "history/history_picture.hpp"

#include <algorithm>

namespace takt::store {
namespace {

double width_of(const HistoryRange& range) {
    return static_cast<double>(range.to_ns) - static_cast<double>(range.from_ns);
}

void widen(std::optional<double>& least, std::optional<double>& greatest, double value) {
    least = std::min(least.value_or(value), value);
    greatest = std::max(greatest.value_or(value), value);
}

}  // namespace

PictureBuilder::PictureBuilder(const HistoryRange& range, std::size_t pixels,
                               std::span<const HistoryGap> gaps)
    : range_(range), pixels_(pixels), gaps_(gaps) {
    picture_.range = range;
    picture_.gaps.assign(gaps.begin(), gaps.end());
}

std::size_t PictureBuilder::pixel_of(std::int64_t time_ns) const {
    const double share = static_cast<double>(time_ns - range_.from_ns) / width_of(range_);
    return std::min(static_cast<std::size_t>(share * static_cast<double>(pixels_)), pixels_ - 1);
}

bool PictureBuilder::fits(const HistorySummary& summary) const {
    return !summary.mixed && summary.begin_ns >= range_.from_ns && summary.end_ns < range_.to_ns &&
           pixel_of(summary.begin_ns) == pixel_of(summary.end_ns);
}

void PictureBuilder::put_bad(std::int64_t from_ns, std::int64_t to_ns) {
    if (last_->quality == value::Quality::good || from_ns >= to_ns) return;
    auto& spans = picture_.bad;
    const bool joins = !spans.empty() && spans.back().range.to_ns == from_ns &&
                       spans.back().quality == last_->quality && spans.back().reason == last_->reason;
    if (joins)
        spans.back().range.to_ns = to_ns;
    else
        spans.push_back({{from_ns, to_ns}, last_->quality, last_->reason});
}

// The last piece holds from its end, or from the begin of the range, until `until_ns` or a gap.
void PictureBuilder::hold(std::int64_t until_ns) {
    if (!last_) return;
    const std::int64_t end = hold_end(last_->end_ns, until_ns, gaps_);
    put_bad(std::max(last_->begin_ns, range_.from_ns), end);
    const std::int64_t begin = std::max(last_->end_ns, range_.from_ns);
    if (begin >= end) return;
    const double held = static_cast<double>(end - begin) / kNanosecondsPerSecond;
    if (last_->ends_with_number) {
        area_ += last_->last.value * held;
        drawn_s_ += held;
        widen(picture_.min, picture_.max, last_->last.value);
    }
    if (last_->ends_good) good_s_ += held;
}

void PictureBuilder::begin(const HistorySample& before) {
    picture_.before = before;
    last_ = summary_of(before);
    if (before.quality != value::Quality::never_read) polled_ = range_.from_ns;
    const bool holds = hold_end(before.time_ns, range_.from_ns + 1, gaps_) > range_.from_ns;
    if (last_->ends_with_number && holds) picture_.held = last_->last;
}

void PictureBuilder::add(const HistorySample& sample) {
    if (sample.time_ns >= range_.from_ns && sample.time_ns < range_.to_ns) add(summary_of(sample));
}

void PictureBuilder::add(const HistorySummary& summary) {
    hold(summary.begin_ns);
    last_ = summary;
    if (!polled_ && (summary.quality != value::Quality::never_read || summary.mixed))
        polled_ = summary.begin_ns;
    area_ += summary.area;
    drawn_s_ += summary.drawn_s;
    good_s_ += summary.good_s;
    picture_.samples += summary.samples;
    if (summary.samples > 1) ++picture_.rolled_up;
    if (summary.numbers > 0) {
        widen(picture_.min, picture_.max, summary.min.value);
        widen(picture_.min, picture_.max, summary.max.value);
    }
    add_to_pixel(summary);
}

void PictureBuilder::add_to_pixel(const HistorySummary& summary) {
    const std::size_t index = pixel_of(summary.begin_ns);
    auto& all = picture_.pixels;
    if (all.empty() || all.back().index != index) {
        const double width = width_of(range_) / static_cast<double>(pixels_);
        const auto begin = [&](std::size_t i) {
            return range_.from_ns + static_cast<std::int64_t>(static_cast<double>(i) * width);
        };
        all.push_back({.index = index, .range = {begin(index), begin(index + 1)}});
    }
    HistoryPixel& pixel = all.back();
    pixel.samples += summary.samples;
    if (summary.numbers == 0) return;
    if (!pixel.has_value) {
        pixel.has_value = true;
        pixel.first = summary.first;
        pixel.min = summary.min;
        pixel.max = summary.max;
    }
    if (summary.min.value < pixel.min.value) pixel.min = summary.min;
    if (summary.max.value > pixel.max.value) pixel.max = summary.max;
    pixel.last = summary.last;
}

HistoryPicture PictureBuilder::finish(std::int64_t known_until_ns) {
    const std::int64_t end = std::min(range_.to_ns, known_until_ns);
    picture_.known_until_ns = known_until_ns;
    if (last_) hold(std::max(end, last_->end_ns));
    if (drawn_s_ > 0) picture_.mean = area_ / drawn_s_;
    if (polled_) picture_.good_share = good_s_ * kNanosecondsPerSecond / width_of({*polled_, range_.to_ns});
    return std::move(picture_);
}

}  // namespace takt::store
