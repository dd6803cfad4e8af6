// Two series of times that were measured in alternating blocks, and the ratios between them.
#pragma once

#include <cstddef>
#include <vector>

namespace takt::bench {

/// The blocks of one peer, in microseconds.
using Blocks = std::vector<std::vector<double>>;

struct Ratio {
    double value = 0;
    double low = 0;  ///< 95 % interval, from a bootstrap over the pairs of blocks
    double high = 0;
};

/// The nearest-rank percentile of all blocks. @param percent  0..100
[[nodiscard]] double percentile(const Blocks& blocks, double percent);
[[nodiscard]] double greatest(const Blocks& blocks);

/// The percentile of `a` over that of `b`. Block i of both was measured at about the same time.
[[nodiscard]] Ratio ratio(const Blocks& a, const Blocks& b, double percent);

}  // namespace takt::bench
