// Optimal string alignment distance (Damerau and Levenshtein, restricted): three rows of the usual table.
#include "takt/model/nearest.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "takt/base/ascii.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kLongestCompared = 64;

constexpr std::size_t kContained = 4;

bool contains(std::string_view whole, std::string_view part) {
    return part.size() > 2 && whole.substr(0, kLongestCompared).find(part) != std::string_view::npos;
}

std::size_t replace_cost(char a, char b) {
    if (a == b) return 0;
    return lower_case(a) == lower_case(b) ? 1 : 2;
}

}  // namespace

std::size_t typing_distance(std::string_view a, std::string_view b) {
    a = a.substr(0, kLongestCompared);
    b = b.substr(0, kLongestCompared);
    using Row = std::array<std::size_t, kLongestCompared + 1>;
    Row before{};
    Row last{};
    Row row{};
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = 2 * j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before = last;
        last = row;
        row[0] = 2 * i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({last[j] + 2, row[j - 1] + 2, last[j - 1] + replace_cost(a[i - 1], b[j - 1])});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 2);
        }
    }
    return row[b.size()];
}

std::string_view nearest(std::string_view text, std::span<const std::string_view> candidates) {
    std::string_view best;
    auto least = std::numeric_limits<std::size_t>::max();
    for (const auto candidate : candidates) {
        auto distance = typing_distance(text, candidate);
        if (contains(candidate, text) || contains(text, candidate)) distance = std::min(distance, kContained);
        if (distance < least) {
            least = distance;
            best = candidate;
        }
    }
    return best;
}

bool is_unlike(std::string_view text, std::string_view guess) {
    std::string small(text);
    std::ranges::transform(small, small.begin(), lower_case);
    std::string other(guess);
    std::ranges::transform(other, other.begin(), lower_case);
    const bool part = other.find(small) != std::string::npos || small.find(other) != std::string::npos;
    return !part && typing_distance(small, other) > std::max(small.size(), other.size());
}

}  // namespace takt::model
