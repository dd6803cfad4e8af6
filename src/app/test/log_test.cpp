// The log file of the program: levels, categories, and text from outside.
#include "log.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <regex>
#include <string>

#include "folder.hpp"

namespace takt::app {
namespace log_test {

/// The lines that `write` logs at a level, without the time of each line.
template <class Write>
std::string logged(const std::string& level, Write write) {
    const takt::test::Folder folder;
    EXPECT_TRUE(begin_log(folder / "takt.log", level));
    write();
    end_log();
    std::string text;
    const auto file = folder.read("takt.log");
    for (std::size_t begin = 0; begin < file.size();) {
        const auto end = file.find('\n', begin);
        constexpr std::size_t kTime = std::string_view("2026-11-21T12:00:00.000+00:00 ").size();
        text += file.substr(begin + kTime, end + 1 - begin - kTime);
        begin = end + 1;
    }
    return text;
}

TEST(Log, WithoutAFileNothingIsWritten) {
    log("line")(LogLevel::warning, "lost", "a", 1);
    end_log();
}

TEST(Log, ALineHasLevelCategoryEventSubjectAndNumber) {
    EXPECT_EQ(logged("trace",
                     [] {
                         log("line")(LogLevel::warning, "link_lost", "rs485-1", -5);
                         log("serve")(LogLevel::error, "refused", "", 0);
                     }),
              "warning line: link_lost rs485-1 -5\nerror serve: refused  0\n");
}

TEST(Log, ALineBeginsWithTheTimeAndItsZone) {
    const takt::test::Folder folder;
    ASSERT_TRUE(begin_log(folder / "takt.log", "info"));
    log("line")(LogLevel::info, "opened");
    end_log();
    const auto text = folder.read("takt.log");
    EXPECT_TRUE(std::regex_match(
        text, std::regex(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d info line: opened.*\n)")))
        << text;
}

TEST(Log, LinesBelowTheLevelAreLeftOut) {
    const auto all = [] {
        const auto to = log("line");
        to(LogLevel::trace, "a");
        to(LogLevel::debug, "b");
        to(LogLevel::info, "c");
        to(LogLevel::warning, "d");
        to(LogLevel::error, "e");
    };
    const struct {
        const char* level;
        const char* events;
    } cases[] = {{"trace", "abcde"}, {"debug", "bcde"}, {"info", "cde"}, {"warning", "de"}, {"error", "e"}};
    for (const auto& [level, events] : cases) {
        std::string found;
        const auto text = logged(level, all);
        for (auto at = text.find(": "); at != std::string::npos; at = text.find(": ", at + 1))
            found += text[at + 2];
        EXPECT_EQ(found, events) << level;
    }
}

TEST(Log, AMessageIsTheTextOfItsCode) {
    const Error error = fail(Code::cannot_open, "plc:502", ECONNREFUSED).error();
    const LogArgument arguments[] = {
        {.name = "line", .text = "plant\n"},
        {.name = "device", .text = "Boiler"},
        {.name = "code", .text = "99"},
        {.name = "exception", .text = "exception.99", .otherwise = "exception.1", .is_code = true},
        {.name = "state", .text = "log.why.exception", .is_code = true},
        {.name = "error", .error = &error}};
    EXPECT_EQ(logged("info",
                     [&] {
                         log("host").message(LogLevel::info, "log.device_state", arguments);
                         log("host").message(LogLevel::warning, "log.link_down", arguments);
                         log("host").message(LogLevel::debug, "log.link_down", arguments);
                     }),
              "info host: line plant\\n, device Boiler: exception 99: illegal function\n"
              "warning host: line plant\\n: plc:502: cannot be opened: connection refused\n");
}

TEST(Log, TextFromOutsideStaysOnItsLine) {
    EXPECT_EQ(logged("info", [] { log("line")(LogLevel::info, "opened", "a\n\x1b[2J", 0); }),
              "info line: opened a\\n\\u{1B}[2J 0\n");
}

TEST(Log, AFileThatCannotBeOpenedIsAnError) {
    const takt::test::Folder folder;
    const auto begun = begin_log(folder / "missing/takt.log", "info");
    ASSERT_FALSE(begun);
    EXPECT_EQ(begun.error().code, Code::cannot_open);
}

}  // namespace log_test
}  // namespace takt::app
