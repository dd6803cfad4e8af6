#include "project/unified_diff.hpp"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace takt::web {
namespace {

using Lines = std::vector<std::string_view>;

constexpr std::size_t kContext = 3;

/// Each with its line break; the last one may have none.
Lines lines_of(std::string_view text) {
    Lines lines;
    while (!text.empty()) {
        const auto end = text.find('\n');
        const auto size = end == std::string_view::npos ? text.size() : end + 1;
        lines.push_back(text.substr(0, size));
        text.remove_prefix(size);
    }
    return lines;
}

/// Lines [begin, end) of the old text become lines [new_begin, new_end).
struct Change {
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t new_begin = 0;
    std::size_t new_end = 0;
};

/// The furthest line of the old text on each diagonal, after each number of differences.
class Myers {
public:
    Myers(const Lines& a, const Lines& b, std::size_t front, std::size_t back)
        : a_(a.begin() + static_cast<std::ptrdiff_t>(front), a.end() - static_cast<std::ptrdiff_t>(back)),
          b_(b.begin() + static_cast<std::ptrdiff_t>(front), b.end() - static_cast<std::ptrdiff_t>(back)),
          front_(front) {}

    /// @returns nothing beyond kMostDifferences
    std::optional<std::vector<Change>> run() {
        const int most = std::min(kMostDifferences, rows() + columns());
        for (int d = 0; d <= most; ++d) {
            std::vector<int> furthest(static_cast<std::size_t>(2 * d + 1));
            for (int k = -d; k <= d; k += 2) {
                int x = begins_down(d, k) ? at(d - 1, k + 1) : at(d - 1, k - 1) + 1;
                if (d == 0) x = 0;
                while (x < rows() && x - k < columns() && x - k >= 0 && a_[index(x)] == b_[index(x - k)]) ++x;
                furthest[index(k + d)] = x;
                if (x >= rows() && x - k >= columns()) {
                    trace_.push_back(std::move(furthest));
                    return path(d, k);
                }
            }
            trace_.push_back(std::move(furthest));
        }
        return std::nullopt;
    }

private:
    static std::size_t index(int value) { return static_cast<std::size_t>(value); }
    [[nodiscard]] int rows() const { return static_cast<int>(a_.size()); }
    [[nodiscard]] int columns() const { return static_cast<int>(b_.size()); }

    [[nodiscard]] int at(int d, int k) const {
        return d < 0 || k < -d || k > d ? -1 : trace_[index(d)][index(k + d)];
    }
    [[nodiscard]] bool begins_down(int d, int k) const {
        return k == -d || (k != d && at(d - 1, k - 1) < at(d - 1, k + 1));
    }

    // Back from the end: one inserted or removed line for each difference.
    [[nodiscard]] std::vector<Change> path(int d, int k) const {
        std::vector<Change> changes;
        for (; d > 0; --d) {
            const bool down = begins_down(d, k);
            const int before = down ? k + 1 : k - 1;
            const int x = at(d - 1, before);
            const auto row = front_ + index(x);
            const auto column = front_ + index(x - before);
            changes.push_back({row, row + (down ? 0 : 1), column, column + (down ? 1 : 0)});
            k = before;
        }
        std::ranges::reverse(changes);
        return changes;
    }

    Lines a_;
    Lines b_;
    std::size_t front_;
    std::vector<std::vector<int>> trace_;
};

std::vector<Change> changes_of(const Lines& a, const Lines& b) {
    const auto most = std::min(a.size(), b.size());
    std::size_t front = 0;
    while (front < most && a[front] == b[front]) ++front;
    std::size_t back = 0;
    while (back < most - front && a[a.size() - 1 - back] == b[b.size() - 1 - back]) ++back;
    if (front == a.size() && front == b.size()) return {};
    if (auto shortest = Myers(a, b, front, back).run()) return *std::move(shortest);
    return {{front, a.size() - back, front, b.size() - back}};
}

void put_line(std::string& out, char mark, std::string_view line) {
    out += mark;
    out += line;
    if (!line.ends_with('\n')) out += "\n\\ No newline at end of file\n";
}

std::string range_text(std::size_t begin, std::size_t count) {
    const auto first = std::to_string(count == 0 ? begin : begin + 1);
    return count == 1 ? first : first + ',' + std::to_string(count);
}

void put_hunk(std::string& out, const Lines& a, const Lines& b, const std::vector<Change>& changes) {
    const auto lead = std::min(changes.front().begin, kContext);
    const auto begin = changes.front().begin - lead;
    const auto end = std::min(changes.back().end + kContext, a.size());
    const auto new_begin = changes.front().new_begin - lead;
    const auto new_end = std::min(changes.back().new_end + (end - changes.back().end), b.size());
    out +=
        "@@ -" + range_text(begin, end - begin) + " +" + range_text(new_begin, new_end - new_begin) + " @@\n";
    auto at = begin;
    for (const auto& change : changes) {
        for (; at < change.begin; ++at) put_line(out, ' ', a[at]);
        for (; at < change.end; ++at) put_line(out, '-', a[at]);
        for (auto line = change.new_begin; line < change.new_end; ++line) put_line(out, '+', b[line]);
    }
    for (; at < end; ++at) put_line(out, ' ', a[at]);
}

/// Neighbouring differences as one, removed lines before added ones.
std::vector<Change> joined(const std::vector<Change>& changes) {
    std::vector<Change> result;
    for (const auto& change : changes) {
        if (!result.empty() && result.back().end == change.begin &&
            result.back().new_end == change.new_begin) {
            result.back().end = change.end;
            result.back().new_end = change.new_end;
        } else {
            result.push_back(change);
        }
    }
    return result;
}

}  // namespace

std::string unified_diff(std::string_view old_text, std::string_view new_text, std::string_view before,
                         std::string_view after) {
    const auto a = lines_of(old_text);
    const auto b = lines_of(new_text);
    std::string out;
    std::vector<Change> hunk;
    for (const auto& change : joined(changes_of(a, b))) {
        if (out.empty()) out.append("--- ").append(before).append("\n+++ ").append(after).append("\n");
        if (!hunk.empty() && change.begin - hunk.back().end > 2 * kContext) {
            put_hunk(out, a, b, hunk);
            hunk.clear();
        }
        hunk.push_back(change);
    }
    if (!hunk.empty()) put_hunk(out, a, b, hunk);
    return out;
}

}  // namespace takt::web
