#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "output.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kProgressRedrawEvery = 200ms;

std::size_t columns() {
    return screen_of(STDERR_FILENO).columns;
}

}  // namespace

Progress::Progress(const Texts& texts, Instant start, bool wanted, ProgressPace pace)
    : texts_(texts),
      start_(start),
      pace_(pace),
      next_(start + pace.silent_for),
      wanted_(wanted),
      terminal_(::isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
    clear();
}

void Progress::show(Instant t, const report::Done& done, const std::string& what) {
    if (!wanted_ || t < next_) return;
    next_ = after(t, terminal_ ? kProgressRedrawEvery : pace_.line_every);
    if (!terminal_) return print_status(report::progress_line(texts_, done, t - start_, what) + '\n');
    const auto text = report::progress_with_bar(texts_, done, t - start_, what, columns());
    print_status_raw(back() + text + "\x1b[J");
    drawn_ = report::display_width(text);
}

void Progress::clear() {
    if (drawn_ > 0) print_status_raw(back() + "\x1b[J");
    drawn_ = 0;
    if (terminal_ && next_ > start_ + pace_.silent_for) next_ = start_ + pace_.silent_for;
}

// A terminal that became narrower has wrapped the bar into several lines.
std::string Progress::back() const {
    const auto more = drawn_ == 0 ? 0 : (drawn_ - 1) / columns();
    return more > 0 ? fmt::format("\r\x1b[{}A", more) : "\r";
}

plan::Proof prove(const Texts& texts, const host::LoadedProject& loaded, bool late_is_error,
                  bool with_measures, Instant start) {
    Progress progress(texts, start);
    const auto what = texts("app.progress.planning");
    return host::prove(loaded, late_is_error, with_measures, [&](std::size_t done, std::size_t total) {
        progress.show(line::now(), {.done = done, .total = total}, what);
    });
}

}  // namespace takt::app
