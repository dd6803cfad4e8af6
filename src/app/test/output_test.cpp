#include "takt/app/output.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <memory>
#include <sstream>
#include <string>

namespace takt::app {
namespace {

struct Pipe {
    int read_end = -1;
    int write_end = -1;

    Pipe() {
        std::array<int, 2> ends{};
        if (::pipe(ends.data()) != 0) return;
        read_end = ends[0];
        write_end = ends[1];
    }
    ~Pipe() {
        close_reader();
        ::close(write_end);
    }
    void close_reader() {
        if (read_end >= 0) ::close(read_end);
        read_end = -1;
    }
    [[nodiscard]] std::string read_all() {
        ::close(write_end);
        write_end = -1;
        std::string all;
        std::array<char, 4096> buffer;
        for (ssize_t count = 0; (count = ::read(read_end, buffer.data(), buffer.size())) > 0;)
            all.append(buffer.data(), static_cast<std::size_t>(count));
        return all;
    }
};

std::string gap(std::uint64_t missed) {
    return "gap " + std::to_string(missed) + "\n";
}

// The summary of thousands of lines is longer than what may wait.
TEST(Output, WhatIsSaidLastIsNeverLeftOut) {
    Pipe pipe;
    const std::string last(1000, 'x');
    {
        Output out(pipe.write_end, gap, 100);
        out.put(std::string(101, 'y'));
        out.put_last(last);
        out.finish();
    }
    EXPECT_EQ(pipe.read_all(), "gap 1\n" + last);
}

TEST(Output, WritesEverythingInOrder) {
    Pipe pipe;
    std::string expected;
    {
        Output out(pipe.write_end, gap);
        for (int i = 0; i < 1000; ++i) {
            out.put(std::to_string(i) + "\n");
            expected += std::to_string(i) + "\n";
        }
        out.finish();
    }
    EXPECT_EQ(pipe.read_all(), expected);
}

TEST(Output, NeverBlocksAndTellsWhatItDropped) {
    Pipe pipe;
    auto out = std::make_unique<Output>(pipe.write_end, gap, 1000);
    const std::string line(99, 'x');
    for (int i = 0; i < 5000; ++i) out->put(line + "\n");  // nobody reads: the pipe fills up, then the queue
    std::string all(1 << 20, '\0');
    const auto count = ::read(pipe.read_end, all.data(), all.size());
    ASSERT_GT(count, 0);
    all.resize(static_cast<std::size_t>(count));
    while (out->full(100)) std::this_thread::yield();  // until the writer has caught up
    out->put("last\n");
    out->finish();
    out.reset();
    all += pipe.read_all();
    EXPECT_TRUE(all.ends_with("last\n"));
    std::size_t told = 0;
    std::size_t missed = 0;
    std::istringstream lines(all);
    for (std::string text; std::getline(lines, text);) {
        if (text == line) ++told;
        if (text.starts_with("gap ")) missed += std::stoul(text.substr(4));
    }
    EXPECT_GT(missed, 0U);
    EXPECT_EQ(told + missed, 5000U) << "every line is either there or counted";
}

TEST(Output, EndsInTimeThoughNobodyReads) {
    Pipe pipe;
    Output out(pipe.write_end, gap, 1 << 20);
    out.put(std::string(1 << 19, 'x'));
    out.finish();  // returns: the test's time limit is the check
    EXPECT_TRUE(out.closed());
}

TEST(Output, NoticesThatTheReaderIsGone) {
    ::signal(SIGPIPE, SIG_IGN);
    Pipe pipe;
    Output out(pipe.write_end, gap);
    pipe.close_reader();
    out.put("x\n");
    out.finish();
    EXPECT_TRUE(out.closed());
}

}  // namespace
}  // namespace takt::app
