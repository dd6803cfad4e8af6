#include "paired.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace takt::bench {
namespace {

constexpr std::size_t kResamples = 500;

double percentile_of(std::vector<double>& times, double percent) {
    const auto rank = static_cast<std::size_t>(std::ceil(percent / 100 * static_cast<double>(times.size())));
    const auto nth = times.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
    std::nth_element(times.begin(), nth, times.end());
    return *nth;
}

std::vector<double> gathered(const Blocks& blocks, const std::vector<std::size_t>& chosen) {
    std::vector<double> times;
    for (const auto i : chosen) times.insert(times.end(), blocks[i].begin(), blocks[i].end());
    return times;
}

std::vector<std::size_t> each(const Blocks& blocks) {
    std::vector<std::size_t> all(blocks.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
    return all;
}

}  // namespace

double percentile(const Blocks& blocks, double percent) {
    auto times = gathered(blocks, each(blocks));
    return percentile_of(times, percent);
}

double greatest(const Blocks& blocks) {
    double most = 0;
    for (const auto& block : blocks) most = std::max(most, *std::ranges::max_element(block));
    return most;
}

// Efron's percentile bootstrap. A pair of blocks is drawn as a whole: what disturbed both stays in both.
Ratio ratio(const Blocks& a, const Blocks& b, double percent) {
    std::mt19937 random(1);
    std::uniform_int_distribution<std::size_t> any(0, a.size() - 1);
    std::vector<double> ratios;
    for (std::size_t i = 0; i < kResamples; ++i) {
        std::vector<std::size_t> chosen(a.size());
        for (auto& block : chosen) block = any(random);
        auto of_a = gathered(a, chosen);
        auto of_b = gathered(b, chosen);
        ratios.push_back(percentile_of(of_a, percent) / percentile_of(of_b, percent));
    }
    return {percentile(a, percent) / percentile(b, percent), percentile_of(ratios, 2.5),
            percentile_of(ratios, 97.5)};
}

}  // namespace takt::bench
