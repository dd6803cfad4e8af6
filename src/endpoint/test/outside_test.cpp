// Files, commands and CSV columns, for real.
#include "sources/outside.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "folder.hpp"
#include "takt/endpoint/answer.hpp"

namespace takt::endpoint {
namespace outside_test {

using namespace std::chrono_literals;

class Outside : public testing::Test {
protected:
    std::string file(const std::string& content) {
        folder_.write("file", content);
        return folder_ / "file";
    }

    const takt::test::Folder folder_;
    StopFlag stop_{false};
};

std::string shell(const Result<std::string>& result) {
    return result ? *result
                  : "! " + std::string(name(result.error().code)) + " " +
                        std::to_string(result.error().numbers[0]);
}

std::string ran(std::vector<std::string> run, Duration timeout = 20s) {
    const StopFlag stop{false};
    return shell(run_command({std::move(run), timeout}, stop));
}

TEST_F(Outside, Files) {
    EXPECT_EQ(shell(read_small_file(file("21500\n"))), "21500");
    EXPECT_EQ(shell(read_small_file(file(""))), "");
    EXPECT_EQ(shell(read_small_file(file(std::string(kMostText + 1, 'x')))), "! too_long 4096");
    EXPECT_EQ(shell(read_small_file(folder_ / "none")), "! cannot_open 2");
    EXPECT_EQ(shell(read_small_file(folder_.path())), "! io_failed 21");
}

TEST_F(Outside, CommandsAreRunWithoutAShell) {
    EXPECT_EQ(ran({"echo", "$HOME;  x"}), "$HOME;  x");
    EXPECT_EQ(ran({"cat"}), "") << "standard input is empty";
    EXPECT_EQ(ran({"sh", "-c", "echo bad >&2; exit 3"}), "! io_failed 3");
    EXPECT_EQ(ran({folder_ / "none"}), "! cannot_open 2");
    EXPECT_EQ(ran({}), "! not_found 0");
    EXPECT_EQ(ran({"sh", "-c", "kill -9 $$"}), "! io_failed 137");
}

TEST_F(Outside, CommandsAreBounded) {
    EXPECT_EQ(ran({"sleep", "1000"}, 50ms), "! timed_out 50");
    EXPECT_EQ(ran({"yes"}), "! too_long 4096");
    EXPECT_EQ(ran({"sh", "-c", "exec 1>&-; sleep 1000"}, 100ms), "! timed_out 100");
    EXPECT_EQ(ran({"sh", "-c", "sleep 1000 & echo 5"}), "5") << "its own children do not delay the end";
    const StopFlag stop{true};
    EXPECT_EQ(run_command({{"sleep", "1000"}, 1000s}, stop).error().code, Code::timed_out);
}

TEST_F(Outside, TheValueIsAnArgument) {
    const auto filled = with_value({{"{value}", "a={value},{value}", "x"}, 1s}, "$(reboot)");
    EXPECT_EQ(filled.run, (std::vector<std::string>{"{value}", "a=$(reboot),$(reboot)", "x"}));
    EXPECT_EQ(with_value({{"p", "{value}"}, 1s}, "{value}").run[1], "{value}");
}

TEST_F(Outside, Columns) {
    struct Row {
        const char* content;
        const char* column;
        std::vector<double> values;
    };
    const Row rows[] = {
        {"t,v\n1,2\n3,4\n", "v", {2, 4}},
        {"t,v\r\n1,2\r\n\r\n3,4", "1", {1, 3}},
        {"\xEF\xBB\xBF\"t\";v\n1;2.5\n", "t", {1}},
        {"1\t2\n3\t4\n", "2", {2, 4}},
        {"t,v\n1,2\n3\n", "v", {}},
        {"t,v\n1,x\n", "v", {}},
        {"t,v\n", "v", {}},
        {"t,v\n1,2\n", "w", {}},
        {"t,v\n1,2\n", "3", {}},
        {"", "1", {}},
    };
    for (const auto& [content, column, values] : rows) {
        const auto found = read_column(file(content), column);
        if (values.empty())
            EXPECT_FALSE(found) << content;
        else
            EXPECT_EQ(found.value_or(std::vector<double>{}), values) << content;
    }
    EXPECT_EQ(read_column(file("a\n1\nx\n"), "a").error().code, Code::syntax);
}

}  // namespace outside_test
}  // namespace takt::endpoint
