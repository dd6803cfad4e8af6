#include "takt/report/drawing/progress_text.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace {

using namespace std::chrono_literals;

constexpr double kMostNanoseconds = 9e18;  // a Duration holds 292 years
constexpr std::size_t kMostBar = 24;
constexpr std::size_t kLeastBar = 6;
constexpr std::size_t kBesideBar = 4;   // two brackets, a blank, and the last column
constexpr double kLeastSeconds = 1e-3;  // against a division by zero

std::size_t done_percent(const Done& done) {
    return done.total == 0 ? 0 : std::min(done.done, done.total) * 100 / done.total;
}

}  // namespace

std::string progress_bar(std::size_t done, std::size_t total, std::size_t width) {
    const std::size_t full = total == 0 ? 0 : std::min(done, total) * width / total;
    return '[' + std::string(full, '#') + std::string(width - full, '-') + ']';
}

std::string progress_line(const Texts& texts, const Done& done, Duration elapsed, const std::string& what) {
    const double seconds = std::max(static_cast<double>(elapsed.count()) / 1e9, kLeastSeconds);
    auto text =
        done.total == 0 && !done.requests
            ? what
            : texts("app.progress", {{"percent", std::to_string(done_percent(done))}, {"what", what}});
    if (done.requests)
        text += texts("app.progress.rate",
                      {{"rate", fmt::format("{:.1f}", static_cast<double>(*done.requests) / seconds)}});
    if (!done.requests || done.done == 0 || done.total <= done.done) return text;
    const double left =
        seconds / static_cast<double>(done.done) * static_cast<double>(done.total - done.done);
    const double nanoseconds = std::min(left * 1e9, kMostNanoseconds);
    return text +
           texts("app.progress.left", {{"time", texts.duration(std::chrono::floor<std::chrono::seconds>(
                                                    Duration(static_cast<std::int64_t>(nanoseconds))))}});
}

std::string progress_with_bar(const Texts& texts, const Done& done, Duration elapsed, const std::string& what,
                              std::size_t columns) {
    const auto words = progress_line(texts, done, elapsed, what);
    const std::size_t used = display_width(words) + kBesideBar;
    const std::size_t width = std::clamp(columns > used ? columns - used : 0, kLeastBar, kMostBar);
    return fitted(progress_bar(done.done, done.total, width) + ' ' + words, columns - 1);
}

}  // namespace takt::report
