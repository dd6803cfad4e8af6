#include "takt/console/capture_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <thread>
#include <vector>

#include "folder.hpp"
#include "takt/capture/capture_reader.hpp"

namespace takt::console {
namespace capture_log_test {

using takt::test::Folder;

const std::vector<std::uint8_t> kPdu{3, 0, 0, 0, 1};
const std::vector<std::uint8_t> kRaw{0, 1, 0, 0, 0, 6, 17, 3, 0, 0, 0, 1};

std::string content_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

struct Counter final : capture::PacketSink {
    std::uint64_t packets = 0;
    std::int64_t last_ns = 0;
    void on_packet(const capture::Packet& packet) override {
        ++packets;
        EXPECT_GE(packet.time_ns, last_ns);
        last_ns = packet.time_ns;
    }
};

/// The packets of a capture that must be complete.
std::uint64_t packets_in(const std::string& path) {
    const auto bytes = content_of(path);
    Counter counter;
    capture::CaptureReader reader(counter);
    for (std::size_t done = 0; done < bytes.size();) {
        const auto space = reader.space();
        const auto count = std::min(space.size(), bytes.size() - done);
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(done), count, space.begin());
        done += count;
        EXPECT_TRUE(reader.filled(count));
    }
    reader.end();
    EXPECT_FALSE(reader.error());
    return counter.packets;
}

/// The frames in a capture that is being written.
int frames_in(const std::string& path) {
    const auto content = content_of(path);
    const std::string_view frame(reinterpret_cast<const char*>(kRaw.data()), kRaw.size());
    int count = 0;
    for (std::size_t at = 0; (at = content.find(frame, at)) != std::string::npos; at += frame.size()) ++count;
    return count;
}

struct CaptureLogTest : testing::Test {
    std::shared_ptr<host::TrafficTap> tap = std::make_shared<host::TrafficTap>();
    std::shared_ptr<wire::TrafficObserver> observer = tap->factory()(line());
    TapSource source = tap_source(*tap);
    Folder folder;
    std::string path = folder / "capture.pcapng";
    int lost = 0;
    std::atomic<int> failures = 0;
    std::atomic<int> not_rotated = 0;

    static model::Line line() {
        model::Line line;
        line.name = "server";
        line.framing = wire::Framing::tcp;
        return line;
    }
    std::unique_ptr<CaptureLog> open(const CaptureFileOptions& options) {
        auto file = CaptureFile::open(options);
        EXPECT_TRUE(file);
        if (!file) return nullptr;
        return std::make_unique<CaptureLog>(
            *std::move(file), source,
            FileReports{.on_failed = [this](const Error&) { ++failures; },
                        .on_not_rotated = [this](const Error&) { ++not_rotated; },
                        .on_lost = [this](const std::string&, int number) { lost = number; }});
    }
    template <class Condition>
    static void wait_for(Condition condition) {
        while (!condition()) std::this_thread::yield();  // the test's time limit is the check
    }
    void request(int at) {
        observer->on_frame(Instant(Duration(at)), wire::Direction::received, UnitId{17}, kPdu, kRaw);
    }
};

TEST_F(CaptureLogTest, WritesWhatWasSeenUntilItsEnd) {
    request(1);
    auto log = open({.path = path});
    for (int i = 2; i <= 100; ++i) request(i);
    log.reset();
    EXPECT_EQ(packets_in(path), 100u);
    EXPECT_EQ(lost, 0);
}

TEST_F(CaptureLogTest, RotatesAndKeepsABoundedNumberOfFiles) {
    const int many = 2000;
    auto log = open({.path = path, .file_bytes = 20'000, .files = 3});
    for (int i = 0; i < many; ++i) request(i);
    log.reset();
    const auto newest = packets_in(path);
    const auto middle = packets_in(folder / "capture.1.pcapng");
    const auto oldest = packets_in(folder / "capture.2.pcapng");
    EXPECT_FALSE(std::filesystem::exists(folder / "capture.3.pcapng"));
    EXPECT_GT(newest, 0u);
    EXPECT_GT(middle, 50u);
    EXPECT_GT(oldest, 50u);
    for (const auto* const name : {"capture.pcapng", "capture.1.pcapng", "capture.2.pcapng"})
        EXPECT_LE(std::filesystem::file_size(folder / name), 20'000u) << name;
}

TEST_F(CaptureLogTest, LostFramesAreInTheCapture) {
    const int many = 100'000;  // more than the ring holds
    for (int i = 0; i < many; ++i) request(i);
    open({.path = path}).reset();
    const auto kept = packets_in(path);
    EXPECT_LT(kept, static_cast<std::uint64_t>(many));
    const auto comment = std::to_string(static_cast<std::uint64_t>(many) - kept) + " frames before this one";
    EXPECT_NE(content_of(path).find(comment), std::string::npos);
}

TEST_F(CaptureLogTest, AFullDiskIsReportedOnceAndAtTheEnd) {
    auto log = open({.path = "/dev/full"});
    request(1);
    wait_for([&] { return failures > 0; });
    EXPECT_EQ(lost, 0);
    for (int i = 2; i <= 100; ++i) request(i);
    log.reset();
    EXPECT_EQ(failures, 1);
    EXPECT_EQ(lost, ENOSPC);
}

// A limit of the file size stands for a full disk.
TEST_F(CaptureLogTest, AFailureAfterWrittenFramesIsReportedAgain) {
    ASSERT_NE(::signal(SIGXFSZ, SIG_IGN), SIG_ERR);
    rlimit limit{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &limit), 0);
    auto log = open({.path = path});
    for (int period = 1; period <= 2; ++period) {
        const auto size = std::filesystem::file_size(path);
        const rlimit full{.rlim_cur = size, .rlim_max = limit.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
        request(2'000'000 * period);
        wait_for([&] { return failures == period; });
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &limit), 0);
        request(2'000'000 * period + 1'000'000);
        wait_for([&] { return frames_in(path) == period; });
    }
    log.reset();
    EXPECT_EQ(failures, 2);
    EXPECT_EQ(lost, EFBIG);
    EXPECT_EQ(packets_in(path), 2u);
}

TEST_F(CaptureLogTest, GrowsAndReportsThatOnceWhereTheNextFileCannotBegin) {
    std::filesystem::create_directory(folder / "capture.1.pcapng");
    auto log = open({.path = path, .file_bytes = 10'000, .files = 2});
    const int many = 1000;
    for (int i = 0; i < many; ++i) request(i);
    log.reset();
    EXPECT_EQ(packets_in(path), static_cast<std::uint64_t>(many));
    EXPECT_EQ(not_rotated, 1);
    EXPECT_EQ(failures, 0);
    EXPECT_EQ(lost, 0) << "it is complete";
}

TEST(CaptureFile, CannotBeOpenedBelowAFile) {
    EXPECT_EQ(CaptureFile::open({.path = "/dev/null/x.pcapng"}).error().code, Code::cannot_open);
}

TEST(CaptureFile, IsOfOneProgramAlsoWhileItIsRotated) {
    const Folder folder;
    const std::string path = folder / "capture.pcapng";
    auto file = CaptureFile::open({.path = path, .files = 3});
    ASSERT_TRUE(file);
    for (const char* const blocks : {"first", "second"}) {
        EXPECT_TRUE(file->write(blocks));
        EXPECT_EQ(CaptureFile::open({.path = path}).error(), (Error{Code::busy, std::string_view(path)}));
        EXPECT_EQ(content_of(path), blocks);
        EXPECT_TRUE(file->rotate());
    }
    EXPECT_EQ(content_of(folder / "capture.2.pcapng"), "first");
    EXPECT_EQ(content_of(folder / "capture.1.pcapng"), "second");
}

// It would rename the link of the system: the tests may run as root.
TEST(CaptureFile, NeverRotatesALinkOfTheSystem) {
    const Folder folder;
    const os::Descriptor target(::open((folder / "target").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    const std::string path = folder / "link";
    std::filesystem::create_symlink("/dev/fd/" + std::to_string(target.get()), path);
    const auto file = CaptureFile::open({.path = path, .file_bytes = 10});
    ASSERT_TRUE(file);
    EXPECT_FALSE(file->is_full(1000));
}

TEST(CaptureFile, APipeGetsWholeBlocksAlsoAfterItsReaderStalled) {
    const Folder folder;
    const std::string path = folder / "live";
    ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
    const os::Descriptor reader(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    auto file = CaptureFile::open({.path = path, .file_bytes = 10});
    ASSERT_TRUE(file);
    EXPECT_FALSE(file->is_full(1000)) << "a pipe is not rotated";
    const std::string first(100'000, 'a');  // more than a pipe holds
    EXPECT_TRUE(file->write(first)) << "the rest waits";
    EXPECT_FALSE(file->write("b"));
    std::string got;
    std::string chunk(1 << 16, ' ');
    const auto take = [&] {
        for (;;) {
            const auto count = ::read(reader.get(), chunk.data(), chunk.size());
            if (count <= 0) return;
            got.append(chunk, 0, static_cast<std::size_t>(count));
        }
    };
    for (int turn = 0; turn < 10 && got.size() <= first.size(); ++turn) {
        take();
        (void)file->write("c");
    }
    EXPECT_EQ(got.substr(0, first.size()), first);
    EXPECT_EQ(got.substr(first.size(), 1), "c") << "what was refused is left out whole";
}

TEST(CaptureFile, PutsTheNumberBeforeTheExtension) {
    EXPECT_EQ(CaptureFile::numbered("a/b.pcapng", 2), "a/b.2.pcapng");
    EXPECT_EQ(CaptureFile::numbered("b", 1), "b.1");
    EXPECT_EQ(CaptureFile::numbered("b.pcapng", 0), "b.pcapng");
}

}  // namespace capture_log_test
}  // namespace takt::console
