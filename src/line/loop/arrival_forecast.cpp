#include "loop/arrival_forecast.hpp"

#include <algorithm>

namespace takt::line {

void ArrivalForecast::on_arrival(Instant t) {
    arrivals_[count_++ % arrivals_.size()] = t;
    next_ = expected();
}

Instant ArrivalForecast::arrival(std::size_t ago) const {
    return arrivals_[(count_ - 1 - ago) % arrivals_.size()];
}

ArrivalForecast::Spans ArrivalForecast::spans(std::size_t cycle) const {
    Spans spans{};
    for (std::size_t i = 0; i < kSpans; ++i) spans[i] = arrival(i) - arrival(i + cycle);
    return spans;
}

Instant ArrivalForecast::expected() const {
    const std::size_t longest = std::min(kLongestCycle, count_ > kSpans ? count_ - kSpans : 0);
    std::ptrdiff_t most = kAgreeing - 1;
    Instant best = kNever;
    for (std::size_t cycle = 1; cycle <= longest && most < std::ptrdiff_t{kSpans}; ++cycle) {
        Spans all = spans(cycle);
        auto* const middle = all.begin() + kSpans / 2;
        std::ranges::nth_element(all, middle);
        const Duration median = *middle;
        const auto agree = [&](Duration span) {
            return span - median <= tolerance_ && median - span <= tolerance_;
        };
        const auto agreeing = std::ranges::count_if(all, agree);
        if (agreeing <= most) continue;
        most = agreeing;
        best = after(arrival(cycle - 1), median);
    }
    return best;
}

}  // namespace takt::line
