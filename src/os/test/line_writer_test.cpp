#include "takt/os/record_writer.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <future>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include "folder.hpp"
#include "takt/os/rotating_file.hpp"

namespace takt::os {
namespace line_writer_test {

using takt::test::Folder;

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

using namespace std::chrono_literals;

std::string gap(std::uint64_t missed) {
    return "gap " + std::to_string(missed) + "\n";
}

const WriterOptions kGaps{.gap_line = gap};

// The summary of thousands of lines is longer than the queue may be.
TEST(LineWriter, NeverDropsTheLastText) {
    Pipe pipe;
    const std::string last(1000, 'x');
    {
        LineWriter out(pipe.write_end, {.limit = 100, .gap_line = gap});
        out.put(std::string(101, 'y'));
        out.put_last(last);
        out.finish();
    }
    EXPECT_EQ(pipe.read_all(), "gap 1\n" + last);
}

TEST(LineWriter, WritesEverythingInOrder) {
    Pipe pipe;
    std::string expected;
    {
        LineWriter out(pipe.write_end, kGaps);
        for (int i = 0; i < 1000; ++i) {
            out.put(std::to_string(i) + "\n");
            expected += std::to_string(i) + "\n";
        }
        out.finish();
    }
    EXPECT_EQ(pipe.read_all(), expected);
}

TEST(LineWriter, NeverBlocksAndReportsHowManyLinesItDropped) {
    Pipe pipe;
    auto out = std::make_unique<LineWriter>(pipe.write_end, WriterOptions{.limit = 1000, .gap_line = gap});
    const std::string line(99, 'x');
    for (int i = 0; i < 5000; ++i)
        out->put(line + "\n");  // there is no reader: the pipe fills up, then the queue
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
    std::size_t written = 0;
    std::size_t dropped = 0;
    std::istringstream lines(all);
    for (std::string text; std::getline(lines, text);) {
        if (text == line) ++written;
        if (text.starts_with("gap ")) dropped += std::stoul(text.substr(4));
    }
    EXPECT_GT(dropped, 0U);
    EXPECT_EQ(written + dropped, 5000U) << "every line is either there or counted";
}

TEST(LineWriter, EndsInTimeWithoutAReader) {
    Pipe pipe;
    LineWriter out(pipe.write_end, {.limit = 1 << 20, .gap_line = gap});
    out.put(std::string(1 << 19, 'x'));
    out.finish(1ms);  // returns: the test's time limit is the check
    EXPECT_TRUE(out.closed());
    EXPECT_EQ(out.error(), ETIMEDOUT);
}

TEST(LineWriter, NoticesThatTheReaderIsGone) {
    ::signal(SIGPIPE, SIG_IGN);
    Pipe pipe;
    LineWriter out(pipe.write_end, kGaps);
    EXPECT_FALSE(out.closed());
    pipe.close_reader();
    EXPECT_TRUE(out.closed()) << "also while nothing is written";
    out.put("x\n");
    out.finish();
    EXPECT_EQ(out.error(), EPIPE);
}

TEST(LineWriter, ReportsADropThatNoLineFollows) {
    Pipe pipe;
    {
        LineWriter out(pipe.write_end, kGaps);
        out.put("first\n");
        out.drop();
        out.drop();
    }
    const auto all = pipe.read_all();
    EXPECT_TRUE(all == "first\ngap 2\n" || all == "first\ngap 1\ngap 1\n") << all;
}

TEST(LineWriter, ReportsDropsNoMoreOftenThanItsIntervalAllows) {
    Pipe pipe;
    {
        LineWriter out(pipe.write_end, {.gap_line = gap, .gap_interval = 1h});
        for (int i = 0; i < 5; ++i) {
            out.drop();
            out.put("line\n");
        }
    }
    EXPECT_EQ(pipe.read_all(), "gap 1\nline\nline\nline\nline\nline\ngap 4\n");
}

/// Fails until it is repaired.
class BrokenSink final : public Sink {
public:
    BrokenSink(std::string& text, std::shared_future<void> repaired)
        : text_(text), repaired_(std::move(repaired)) {}
    Written write(std::string_view text) override {
        if (!failed_) {
            failed_ = true;
            repaired_.wait();
            return {.bytes = 0, .error = ENOSPC, .closed = false};
        }
        text_ += text;
        return {.bytes = text.size(), .error = 0, .closed = false};
    }

private:
    std::string& text_;
    std::shared_future<void> repaired_;
    bool failed_ = false;
};

TEST(LineWriter, CountsTheLinesOfAFailedWriteAndGoesOn) {
    std::string text;
    std::promise<void> repaired;
    {
        LineWriter out(std::make_unique<BrokenSink>(text, repaired.get_future().share()), kGaps);
        out.put("1\n2\n");
        repaired.set_value();
        while (out.failures() == 0) std::this_thread::yield();
        EXPECT_EQ(out.error(), ENOSPC);
        out.put("3\n");
        out.finish();
        EXPECT_EQ(out.failures(), 1u);
        EXPECT_EQ(out.error(), 0) << "it works again";
    }
    EXPECT_EQ(text, "3\ngap 2\n") << "the report is delayed after a failure";
}

TEST(LineWriter, ReportsTheFirstFailureOfARow) {
    struct Scripted final : Sink {
        explicit Scripted(std::vector<int> results) : errors(std::move(results)) {}
        Written write(std::string_view text) override {
            if (text.starts_with("gap") || errors.empty()) return {.bytes = text.size()};
            const int error = errors.front();
            errors.erase(errors.begin());
            return {.bytes = error == 0 ? text.size() : 0, .error = error};
        }
        std::vector<int> errors;
    };
    std::vector<int> reported;
    {
        const std::vector<int> results{ENOSPC, EDQUOT, 0, EFBIG, ENOSPC};
        LineWriter out(std::make_unique<Scripted>(results),
                       {.gap_line = gap, .on_failure = [&](int error) { reported.push_back(error); }});
        for (std::size_t i = 0; i < results.size(); ++i) {
            out.put("x\n");
            while (out.full(WriterOptions{}.limit)) std::this_thread::yield();  // one record in each write
        }
    }
    EXPECT_EQ(reported, (std::vector{ENOSPC, EFBIG}));
}

// A disk that is full at the end: the shorter report of what was lost may fit.
TEST(LineWriter, KeepsTheErrorOfALineThatIsLostAtTheEnd) {
    struct NearlyFull final : Sink {
        Written write(std::string_view text) override {
            if (text.size() > 8) return {.bytes = 0, .error = ENOSPC, .closed = false};
            return {.bytes = text.size(), .error = 0, .closed = false};
        }
    };
    LineWriter out(std::make_unique<NearlyFull>(), kGaps);
    out.put("1\n");
    out.finish();
    EXPECT_EQ(out.error(), 0);
    LineWriter losing(std::make_unique<NearlyFull>(), kGaps);
    losing.put("1\n");
    losing.put_last("a long summary\n");
    losing.finish();
    EXPECT_EQ(losing.error(), ENOSPC);
}

// A limit of the file size stands for a full disk.
TEST(DescriptorSink, GoesOnWhenAFullDiskHasRoomAgain) {
    for (const int flags : {0, O_APPEND}) {
        const Folder folder;
        const Descriptor file(::open((folder / "out").c_str(), O_WRONLY | O_CREAT | O_EXCL | flags, 0600));
        ASSERT_TRUE(file);
        ASSERT_NE(::signal(SIGXFSZ, SIG_IGN), SIG_ERR);
        rlimit limit{};
        ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
        const rlimit small{.rlim_cur = 10, .rlim_max = limit.rlim_max};
        DescriptorSink sink(file.get());
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
        const auto written = sink.write("first\nsecond\n");
        const auto again = sink.write("third line\n");
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
        EXPECT_EQ(written.bytes, 6u);
        EXPECT_EQ(written.error, EFBIG);
        EXPECT_FALSE(written.closed);
        EXPECT_EQ(again.bytes, 0u);
        EXPECT_EQ(folder.read("out"), "first\n");
        EXPECT_EQ(sink.write("fourth\n").error, 0);
        EXPECT_EQ(folder.read("out"), "first\nfourth\n");
    }
}

TEST(DescriptorSink, IsClosedByOtherErrors) {
    const Descriptor file(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    const auto written = DescriptorSink(file.get()).write("x\n");
    EXPECT_EQ(written.error, EBADF);
    EXPECT_TRUE(written.closed);
}

TEST(LineWriter, FormatsRecordsIntoAFileThatRotates) {
    const Folder folder;
    auto file = RotatingFile::open(folder / "log", {.file_bytes = 4, .old_files = 9});
    ASSERT_TRUE(file);
    RecordWriter<int> out(*std::move(file), kGaps, [](const int& number, std::string& text) {
        text += std::to_string(number) + "\n";
    });
    for (int i = 1; i <= 6; ++i) out.put(i);
    out.finish();
    std::string all;
    for (int i = 9; i >= 0; --i) all += folder.read(i == 0 ? "log" : "log." + std::to_string(i));
    EXPECT_EQ(all, "1\n2\n3\n4\n5\n6\n");
    EXPECT_LE(folder.read("log").size(), 4u);
}

TEST(RecordWriter, LimitsTheBytesOfRecords) {
    Pipe pipe;
    std::promise<void> repaired;
    std::string text;
    RecordWriter<int> out(std::make_unique<BrokenSink>(text, repaired.get_future().share()),
                          {.limit = 3 * sizeof(int), .gap_line = gap},
                          [](const int&, std::string& line) { line += "x\n"; });
    for (int i = 0; i < 10; ++i) out.put(i);
    EXPECT_TRUE(out.full(1));
    repaired.set_value();
    out.finish();
    EXPECT_LE(std::ranges::count(text, 'x'), 3) << text;
    EXPECT_TRUE(text.find("gap ") != std::string::npos) << text;
}

}  // namespace line_writer_test
}  // namespace takt::os
