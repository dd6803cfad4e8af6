#include "output.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>

#include "takt/report/drawing/word_wrap.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/escape.hpp"

namespace takt::app {
namespace {

// One per process, as stdout is.
int g_stdout_error = 0;
LostOutput g_lost_output;

}  // namespace

void print(const std::string& text) {
    print_raw(text::escape_lines(text));
}

void print_wrapped(const std::string& text) {
    print_raw(report::wrapped(text::escape_lines(text), columns_of(STDOUT_FILENO)));
}

void print_raw(const std::string& text) {
    const bool written =
        std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
    if (!written) note_stdout_error(errno);
}

void print_status(const std::string& text) {
    print_status_raw(report::wrapped(text::escape_lines(text), columns_of(STDERR_FILENO)));
}

void print_status_raw(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
}

void print_error(const std::string& text) {
    print_status("takt: " + text + '\n');
}

console::Messages messages() {
    return {print_status, print_error};
}

int stdout_error() {
    return g_stdout_error;
}

void note_stdout_error(int number) {
    if (g_stdout_error == 0) g_stdout_error = number;
}

void note_lost_output(const std::string& path, int number) {
    if (number != 0 && g_lost_output.number == 0) g_lost_output = {path, number};
}

// The reader of a pipe that is closed has read enough.
console::FileReports file_reports(const Texts& texts) {
    return {
        .on_failed =
            [texts](const Error& error) {
                if (error.numbers[0] == EPIPE) return;
                print_error(texts("app.frames.failed", {{"why", texts.describe(error)}}));
            },
        .on_not_rotated =
            [texts](const Error& error) {
                print_error(texts("app.frames.not_rotated", {{"why", text::what(texts.language(), error)}}));
            },
        .on_lost = note_lost_output};
}

const LostOutput& lost_output() {
    return g_lost_output;
}

std::size_t columns_of(int descriptor) {
    return ::isatty(descriptor) == 1 ? screen_of(descriptor).columns : SIZE_MAX;
}

report::Screen screen_of(int descriptor) {
    winsize size{};
    if (::ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_col == 0) return {};
    return {size.ws_row, size.ws_col};
}

}  // namespace takt::app
