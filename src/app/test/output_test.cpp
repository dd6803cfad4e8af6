// The output to the standard streams, and the exit code of each error.
#include "output.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "exit_code.hpp"
#include "progress.hpp"

namespace takt::app {
namespace output_test {

using namespace std::chrono_literals;

template <class Write>
std::string stdout_of(Write write) {
    testing::internal::CaptureStdout();
    write();
    return testing::internal::GetCapturedStdout();
}

template <class Write>
std::string stderr_of(Write write) {
    testing::internal::CaptureStderr();
    write();
    return testing::internal::GetCapturedStderr();
}

TEST(Output, DataGoesToStdoutAndWordsToStderrEscaped) {
    const std::string hostile = "a\x1b[2J\nb\x07\n";
    const std::string escaped = "a\\u{1B}[2J\nb\\u{07}\n";
    EXPECT_EQ(stdout_of([&] { print(hostile); }), escaped);
    EXPECT_EQ(stdout_of([&] { print_raw(hostile); }), hostile);
    std::string data;
    EXPECT_EQ(stderr_of([&] { data = stdout_of([&] { print_status(hostile); }); }), escaped);
    EXPECT_EQ(data, "");
    EXPECT_EQ(stderr_of([&] { print_status_raw(hostile); }), hostile);
    EXPECT_EQ(stderr_of([&] { print_error("no port"); }), "takt: no port\n");
    EXPECT_EQ(stderr_of([&] { messages().status("x\n"); }), "x\n");
    EXPECT_EQ(stderr_of([&] { messages().error("x"); }), "takt: x\n");
}

// One of each in a process, and never reset.
TEST(Output, TheFirstFailureIsRemembered) {
    const int first = stdout_error() != 0 ? stdout_error() : ENOSPC;
    for (const int number : {0, ENOSPC, EPIPE, 0}) note_stdout_error(number);
    EXPECT_EQ(stdout_error(), first);
    note_lost_output("none", 0);
    note_lost_output("a.log", EFBIG);
    note_lost_output("b.log", ENOSPC);
    EXPECT_EQ(lost_output().path, "a.log");
    EXPECT_EQ(lost_output().number, EFBIG);
}

TEST(Output, WhatIsNoTerminalHasAnUsualSize) {
    EXPECT_EQ(screen_of(-1), (report::Screen{24, 80}));
}

TEST(ExitCodes, FollowTheCauseOfTheError) {
    const struct {
        Code code;
        ExitCode exit;
    } cases[] = {{Code::cannot_open, ExitCode::cannot_open},
                 {Code::busy, ExitCode::cannot_open},
                 {Code::connection_lost, ExitCode::cannot_open},
                 {Code::io_failed, ExitCode::cannot_open},
                 {Code::replaced, ExitCode::cannot_open},
                 {Code::timed_out, ExitCode::timed_out},
                 {Code::modbus_exception, ExitCode::exception},
                 {Code::bad_checksum, ExitCode::bad_frame},
                 {Code::unexpected_reply, ExitCode::bad_frame},
                 {Code::malformed, ExitCode::bad_frame},
                 {Code::not_modbus, ExitCode::bad_frame},
                 {Code::too_short, ExitCode::bad_frame},
                 {Code::too_long, ExitCode::bad_frame},
                 {Code::out_of_range, ExitCode::usage},
                 {Code::unsupported, ExitCode::usage},
                 {Code::not_found, ExitCode::usage},
                 {Code::overflow, ExitCode::usage},
                 {Code::not_writable, ExitCode::usage},
                 {Code::queue_full, ExitCode::usage},
                 {Code::syntax, ExitCode::usage}};
    for (const auto& [code, exit] : cases) EXPECT_EQ(exit_code(fail(code, "x").error()), exit) << name(code);
    EXPECT_EQ(exit_code(fail(Code::cannot_open, "host", ECANCELED).error()), ExitCode::timed_out)
        << "interrupted while connecting";
}

TEST(ExitCodes, TheErrorIsReported) {
    const auto error = fail(Code::cannot_open, "/dev/ttyS1", ENOENT).error();
    for (const auto language :
         {text::Language::english, text::Language::russian, text::Language::ukrainian}) {
        const Texts texts(language);
        ExitCode code = ExitCode::ok;
        EXPECT_EQ(stderr_of([&] { code = ended_by(texts, error); }), "takt: " + texts.describe(error) + '\n');
        EXPECT_EQ(code, ExitCode::cannot_open);
    }
}

// stderr is a file here, no terminal.
TEST(Progress, IsSilentForTwoSecondsAndThenALineEachTen) {
    const Texts texts(text::Language::english);
    const Instant start{1s};
    Progress progress(texts, start);
    const struct {
        Duration at;
        std::size_t done;
        bool shown;
    } cases[] = {{0s, 0, false},      {1999ms, 1, false}, {2s, 2, true},  {2001ms, 3, false},
                 {11999ms, 4, false}, {12s, 5, true},     {30s, 6, true}, {39s, 7, false}};
    for (const auto& [at, done, shown] : cases) {
        const report::Done part{.done = done, .total = 10};
        const auto text = stderr_of([&] { progress.show(start + at, part, "coil 0"); });
        EXPECT_EQ(text, shown ? report::progress_line(texts, part, at, "coil 0") + '\n' : "");
    }
    EXPECT_EQ(stderr_of([&] { progress.clear(); }), "") << "there is no bar to remove";
}

TEST(Progress, StaysSilentWhereItIsNotWanted) {
    Progress progress(Texts(text::Language::english), Instant{1s}, false);
    EXPECT_EQ(stderr_of([&] { progress.show(Instant{1h}, {.done = 1, .total = 2}, "x"); }), "");
}

}  // namespace output_test
}  // namespace takt::app
