// Standard output and standard error of the program. Data goes to stdout, everything else to stderr.
#pragma once

#include <cstddef>
#include <string>

#include "takt/console/file_reports.hpp"
#include "takt/console/messages.hpp"
#include "takt/report/drawing/panel.hpp"
#include "texts.hpp"

namespace takt::app {

/// Writes `text` to stdout, with everything escaped that a terminal would obey (text::escape_lines()). The
/// first failure (a full disk, a closed pipe) is remembered for stdout_error().
void print(const std::string& text);

/// As print(), for sentences: on a terminal, long lines are broken at blanks.
void print_wrapped(const std::string& text);

/// Writes `text` to stderr, escaped and broken likewise.
void print_status(const std::string& text);

/// As print() and print_status(), for the bytes of a file format and for a display with escape sequences:
/// nothing is escaped. The format or the display must have escaped what comes from outside.
void print_raw(const std::string& text);
void print_status_raw(const std::string& text);

/// Writes "takt: TEXT" and a line end to stderr.
void print_error(const std::string& text);

/// print_status() and print_error() for what prints elsewhere.
[[nodiscard]] console::Messages messages();

/// The errno of the first write to stdout that failed; 0: none failed.
[[nodiscard]] int stdout_error();

/// Records a failure of a writer that does not use print(). 0 is ignored.
void note_stdout_error(int number);

/// A file or stream whose output is incomplete.
struct LostOutput {
    std::string path;
    int number = 0;  ///< errno of the first write that failed
};

/// Records a failed write to another file than stdout. 0 is ignored; the first failure is kept.
void note_lost_output(const std::string& path, int number);

/// Reports a failing file when it fails, and keeps it for note_lost_output() at the end.
[[nodiscard]] console::FileReports file_reports(const Texts& texts);

/// The failure that note_lost_output() kept; number 0: none.
[[nodiscard]] const LostOutput& lost_output();

/// The columns of the terminal behind `descriptor`; SIZE_MAX: it is no terminal.
[[nodiscard]] std::size_t columns_of(int descriptor);

/// The size of the terminal behind `descriptor`; 24 rows of 80 columns where it reports none.
[[nodiscard]] report::Screen screen_of(int descriptor);

}  // namespace takt::app
