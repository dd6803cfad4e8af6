#include "takt/console/capture_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "folder.hpp"
#include "takt/capture/capture_reader.hpp"

namespace takt::console {
namespace {

using test::Folder;

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

struct CaptureLogTest : testing::Test {
    std::shared_ptr<host::TrafficTap> tap = std::make_shared<host::TrafficTap>();
    std::shared_ptr<wire::TrafficObserver> observer = tap->factory()(line());
    TapSource source = tap_source(*tap);
    Folder folder;
    std::string path = folder / "capture.pcapng";
    int lost = 0;

    static model::Line line() {
        model::Line line;
        line.name = "server";
        line.framing = wire::Framing::tcp;
        return line;
    }
    std::unique_ptr<CaptureLog> open(const CaptureFileOptions& options) {
        auto log =
            CaptureLog::open(options, source, [this](const std::string&, int number) { lost = number; });
        EXPECT_TRUE(log);
        return log ? *std::move(log) : nullptr;
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

TEST_F(CaptureLogTest, AFullDiskIsReportedAtTheEnd) {
    auto log = open({.path = "/dev/full"});
    request(1);
    log.reset();
    EXPECT_EQ(lost, ENOSPC);
}

TEST_F(CaptureLogTest, CannotBeOpenedBelowAFile) {
    const auto log = CaptureLog::open({.path = "/dev/null/x.pcapng"}, source, {});
    ASSERT_FALSE(log);
    EXPECT_EQ(log.error().code, Code::cannot_open);
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

}  // namespace
}  // namespace takt::console
