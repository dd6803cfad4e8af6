#include "takt/app/progress.hpp"
#include "takt/app/console.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "takt/report/panel.hpp"
#include "takt/report/text_table.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSilentFor = 2s;
constexpr Duration kRedrawEvery = 200ms;
constexpr Duration kLineEvery = 10s;
constexpr std::size_t kBarWidth = 24;
constexpr std::size_t kLeastBar = 6;

std::size_t columns() {
    return screen_of(STDERR_FILENO).columns;
}

}  // namespace

std::string rough_time(Duration time) {
    const auto seconds = std::max<std::int64_t>(time / 1s, 0);
    if (seconds < 60) return fmt::format("{} s", seconds);
    if (seconds < 3600) return fmt::format("{} min {} s", seconds / 60, seconds % 60);
    return fmt::format("{} h {} min", seconds / 3600, seconds / 60 % 60);
}

std::string bar(std::size_t done, std::size_t total, std::size_t width) {
    const std::size_t full = total == 0 ? 0 : std::min(done, total) * width / total;
    return '[' + std::string(full, '#') + std::string(width - full, '-') + ']';
}

Progress::Progress(const Texts& texts, Instant start, bool wanted)
    : texts_(texts),
      start_(start),
      next_(start + kSilentFor),
      wanted_(wanted),
      terminal_(::isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
    clear();
}

void Progress::show(Instant t, const Done& done, const std::string& what) {
    if (!wanted_ || t < next_) return;
    next_ = after(t, terminal_ ? kRedrawEvery : kLineEvery);
    if (!terminal_) return print_status(line(t, done, what) + '\n');
    const auto width = columns();
    const auto words = line(t, done, what);
    const std::size_t used = report::display_width(words) + 4;  // and brackets, a space, the last column
    const std::size_t bar_width = std::clamp(width > used ? width - used : 0, kLeastBar, kBarWidth);
    const auto text = report::fitted(bar(done.done, done.total, bar_width) + ' ' + words, width - 1);
    print_status(back() + text + "\x1b[J");
    drawn_ = report::display_width(text);
}

void Progress::clear() {
    if (drawn_ > 0) print_status(back() + "\x1b[J");
    drawn_ = 0;
    if (terminal_ && next_ > start_ + kSilentFor) next_ = start_ + kSilentFor;
}

// A terminal that became narrower has broken the bar into several lines.
std::string Progress::back() const {
    const auto more = drawn_ == 0 ? 0 : (drawn_ - 1) / columns();
    return more > 0 ? fmt::format("\r\x1b[{}A", more) : "\r";
}

std::string Progress::line(Instant t, const Done& done, const std::string& what) const {
    const double seconds = std::max(static_cast<double>((t - start_).count()) / 1e9, 1e-3);
    const std::size_t percent = done.total == 0 ? 0 : std::min(done.done, done.total) * 100 / done.total;
    auto text = texts_("app.progress",
                       {{"percent", std::to_string(percent)},
                        {"what", what},
                        {"rate", fmt::format("{:.1f}", static_cast<double>(done.requests) / seconds)}});
    if (done.done > 0 && done.total > done.done) {
        const double left =
            seconds / static_cast<double>(done.done) * static_cast<double>(done.total - done.done);
        text += texts_("app.progress.left",
                       {{"time", rough_time(Duration(static_cast<std::int64_t>(left * 1e9)))}});
    }
    return text;
}

}  // namespace takt::app
