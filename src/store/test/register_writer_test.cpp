// The writing thread of retained registers, and the files found under a path.
#include "takt/store/register_writer.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>

#include "directory.hpp"

namespace takt::store {
namespace register_writer_test {

namespace fs = std::filesystem;
using Image = std::vector<std::uint8_t>;

const RegisterLayout kLayout{1, {{3, false, 0, 9}}};

/// Holds each synchronisation until it is let through, or refused.
class Gate final : public BlockFile {
public:
    explicit Gate(std::uint64_t size) : bytes_(size) {}

    Result<std::uint64_t> size() override { return bytes_.size(); }
    Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) override {
        std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
        return {};
    }
    Result<void> write_at(std::uint64_t offset, Bytes bytes) override {
        std::ranges::copy(bytes, bytes_.begin() + static_cast<std::ptrdiff_t>(offset));
        return {};
    }
    Result<void> sync() override {
        std::unique_lock lock(mutex_);
        ++at_gate_;
        changed_.notify_all();
        changed_.wait(lock, [this] { return open_ || passes_ > 0; });
        --at_gate_;
        if (!open_) --passes_;
        changed_.notify_all();
        if (refuse_) return fail(Code::io_failed, "gate", 5);
        return {};
    }

    void open(bool refuse = false) {
        const std::lock_guard lock(mutex_);
        open_ = true;
        refuse_ = refuse;
        changed_.notify_all();
    }
    void close(bool refuse = false) {
        const std::lock_guard lock(mutex_);
        open_ = false;
        refuse_ = refuse;
    }
    void let_one_through() {
        const std::lock_guard lock(mutex_);
        ++passes_;
        changed_.notify_all();
    }
    void wait_for_one() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [this] { return at_gate_ > passes_; });
    }

private:
    std::mutex mutex_;
    std::condition_variable changed_;
    Image bytes_;
    bool open_ = true;
    bool refuse_ = false;
    int passes_ = 0;
    int at_gate_ = 0;
};

struct Keeping {
    explicit Keeping(Durability durability, Duration interval = std::chrono::hours(1)) {
        auto owned = std::make_unique<Gate>(RegisterFile::file_size(kLayout));
        gate = owned.get();
        auto file = std::move(RegisterFile::make(*gate, kLayout, Image(kLayout.bytes()))).value();
        RegisterWriter::Options options{durability, interval, [this] {
                                            const std::lock_guard lock(mutex);
                                            ++commits;
                                            changed.notify_all();
                                        }};
        writer.emplace(std::move(owned), std::move(file), std::move(options));
    }
    std::uint64_t set(std::size_t item, std::uint8_t value) {
        const Image bytes{0, value};
        const RegisterWriter::Change change{2 * item, bytes};
        return writer->change({&change, 1});
    }
    void wait_for_commits(int count) {
        std::unique_lock lock(mutex);
        changed.wait(lock, [&] { return commits >= count; });
    }

    Gate* gate = nullptr;
    std::mutex mutex;
    std::condition_variable changed;
    int commits = 0;
    std::optional<RegisterWriter> writer;
};

TEST(RegisterWriter, ManyChangesShareASynchronisation) {
    Keeping keeping(Durability::acknowledged);
    keeping.gate->close();
    keeping.set(0, 1);
    keeping.gate->wait_for_one();
    for (std::uint8_t i = 1; i < 10; ++i) EXPECT_EQ(keeping.set(i, 7), i + 1u);
    EXPECT_EQ(keeping.writer->progress().durable, 0u);
    keeping.gate->let_one_through();
    keeping.wait_for_commits(1);
    EXPECT_EQ(keeping.writer->progress().durable, 1u);
    keeping.gate->let_one_through();
    keeping.wait_for_commits(2);
    EXPECT_EQ(keeping.writer->progress().durable, 10u);
    EXPECT_EQ(keeping.writer->counters().commits, 2u);
}

TEST(RegisterWriter, WhatChangesNothingWaitsForWhatChangedIt) {
    Keeping keeping(Durability::acknowledged);
    keeping.gate->close();
    EXPECT_EQ(keeping.set(0, 0), 0u);
    EXPECT_EQ(keeping.set(0, 1), 1u);
    EXPECT_EQ(keeping.set(0, 1), 1u);
    keeping.gate->open();
    keeping.wait_for_commits(1);
    EXPECT_EQ(keeping.writer->progress().durable, 1u);
    EXPECT_EQ(keeping.set(0, 1), 1u);
}

TEST(RegisterWriter, AFailureTakesBackWhatWasNotAcknowledged) {
    Keeping keeping(Durability::acknowledged);
    keeping.set(0, 1);
    keeping.wait_for_commits(1);
    keeping.gate->open(true);
    keeping.set(0, 2);
    keeping.wait_for_commits(2);
    EXPECT_EQ(keeping.set(1, 3), 3u) << "it comes too late";
    const auto progress = keeping.writer->progress();
    EXPECT_TRUE(progress.failed);
    EXPECT_EQ(progress.durable, 1u);
    EXPECT_EQ(progress.why.code, Code::io_failed);
    Image image;
    keeping.writer->roll_back(image);
    EXPECT_EQ(image[1], 1);
    EXPECT_EQ(image[3], 0);
    keeping.gate->open();
    EXPECT_EQ(keeping.set(1, 4), 4u);
    keeping.wait_for_commits(3);
    EXPECT_EQ(keeping.writer->progress().durable, 4u);
    auto found = RegisterFile::open(*keeping.gate, kLayout);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->image()[1], 1);
    EXPECT_EQ(found->image()[3], 4);
}

TEST(RegisterWriter, AtTheEndARefusedImageIsWrittenOver) {
    Keeping keeping(Durability::acknowledged);
    keeping.gate->open(true);
    keeping.set(0, 9);
    keeping.wait_for_commits(1);
    Image image;
    keeping.writer->roll_back(image);
    keeping.gate->open();
    keeping.writer->close();
    auto found = RegisterFile::open(*keeping.gate, kLayout);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->image()[1], 0);
}

TEST(RegisterWriter, WithAnIntervalWritesOnceInIt) {
    Keeping keeping(Durability::interval);
    keeping.set(0, 1);
    keeping.wait_for_commits(1);
    for (std::uint8_t i = 2; i < 100; ++i) keeping.set(0, i);
    keeping.writer->close();
    EXPECT_EQ(keeping.writer->counters().commits, 2u);
    EXPECT_EQ(RegisterFile::open(*keeping.gate, kLayout)->image()[1], 99);
}

TEST(RegisterWriter, AtTheEndWritesAtTheEnd) {
    Keeping keeping(Durability::at_end);
    for (std::uint8_t i = 2; i < 100; ++i) keeping.set(0, i);
    EXPECT_EQ(keeping.writer->counters().commits, 0u);
    keeping.writer->close();
    EXPECT_EQ(keeping.writer->counters().commits, 1u);
    EXPECT_EQ(RegisterFile::open(*keeping.gate, kLayout)->image()[1], 99);
}

class OpenRegisters : public InDirectory {
protected:
    void write(const Image& image, const RegisterLayout& layout = kLayout) {
        auto opened = open_registers(path_, layout, Image(layout.bytes()));
        ASSERT_TRUE(opened);
        ASSERT_TRUE(opened->file.commit(image));
    }

    std::string path_ = (directory_ / "unit.registers").string();
};

Image counting(const RegisterLayout& layout) {
    Image image(layout.bytes());
    for (std::size_t i = 0; i < image.size(); ++i) image[i] = static_cast<std::uint8_t>(i + 1);
    return image;
}

TEST_F(OpenRegisters, MakesAFileAndFindsItAgain) {
    const auto opened = open_registers(path_, kLayout, counting(kLayout));
    ASSERT_TRUE(opened);
    EXPECT_TRUE(opened->is_new);
    EXPECT_EQ(opened->missing, 10u);
    EXPECT_EQ(open_registers(path_, kLayout, {}).error().code, Code::busy);
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
}

TEST_F(OpenRegisters, GivesBackWhatWasWritten) {
    write(counting(kLayout));
    const auto opened = open_registers(path_, kLayout, Image(kLayout.bytes()));
    ASSERT_TRUE(opened);
    EXPECT_FALSE(opened->is_new || opened->was_damaged || opened->other_layout);
    EXPECT_EQ(opened->taken, 10u);
    const auto image = opened->file.image();
    EXPECT_EQ(Image(image.begin(), image.end()), counting(kLayout));
}

TEST_F(OpenRegisters, TakesOverFromAnotherLayout) {
    const RegisterLayout old{1, {{3, false, 0, 9}, {0, true, 8, 19}}};
    write(counting(old), old);
    const std::string before = bytes_of(path_);
    const RegisterLayout now{1, {{3, false, 5, 14}, {0, true, 10, 11}, {2, false, 0, 1}}};
    const auto opened = open_registers(path_, now, Image(now.bytes(), 0xEE));
    ASSERT_TRUE(opened);
    EXPECT_TRUE(opened->other_layout);
    EXPECT_EQ(opened->taken, 7u);
    EXPECT_EQ(opened->missing, 7u);
    EXPECT_EQ(bytes_of(opened->set_aside), before);
    const auto image = opened->file.image();
    EXPECT_EQ(image[0], 11);  // register 5
    EXPECT_EQ(image[9], 20);  // register 9
    EXPECT_EQ(image[10], 0xEE);
    EXPECT_EQ(image[20] & 3, 21 >> 2 & 3);  // coils 10 and 11
}

TEST_F(OpenRegisters, SetsADamagedFileAside) {
    write(counting(kLayout));
    for (const std::string& damaged :
         {bytes_of(path_).substr(0, 50), bytes_of(path_).substr(0, 5000), bytes_of(path_).substr(0, 1),
          bytes_of(path_).substr(0, 4096) + std::string(8192, 'x'), std::string(100, '\0'),
          std::string(12'288, '\0')}) {
        overwrite(path_, damaged);
        const auto opened = open_registers(path_, kLayout, Image(kLayout.bytes(), 7));
        ASSERT_TRUE(opened);
        EXPECT_TRUE(opened->is_new);
        EXPECT_EQ(bytes_of(opened->set_aside), damaged);
        EXPECT_EQ(opened->file.image()[0], 7);
    }
}

TEST_F(OpenRegisters, AnEmptyFileIsDamaged) {
    overwrite(path_, "");
    const auto opened = open_registers(path_, kLayout, counting(kLayout));
    ASSERT_TRUE(opened);
    EXPECT_TRUE(opened->is_new);
    EXPECT_NE(opened->set_aside, "");
}

TEST_F(OpenRegisters, NothingIsAcknowledgedIntoAFileThatIsNotAtItsPath) {
    for (const bool replaced : {false, true}) {
        std::filesystem::remove(path_);
        auto opened = open_registers(path_, kLayout, counting(kLayout));
        ASSERT_TRUE(opened);
        Image image = counting(kLayout);
        image[0] ^= 1;
        ASSERT_TRUE(opened->file.commit(image));
        std::filesystem::remove(path_);
        if (replaced) overwrite(path_, "x");
        image[0] ^= 2;
        EXPECT_EQ(opened->file.commit(image).error().code, Code::replaced);
        EXPECT_EQ(opened->file.commit(image).error().code, Code::replaced);
    }
}

TEST_F(OpenRegisters, ACommitRestoresAFileThatIsOverwrittenInPlace) {
    const RegisterLayout large{1, {{3, false, 0, 5999}}};  // three pages a copy
    constexpr std::size_t kPage = RegisterFile::kPage;
    enum class Damage : std::uint8_t { emptied, cut, zeros, older };
    for (const auto damage : {Damage::emptied, Damage::cut, Damage::zeros, Damage::older}) {
        std::filesystem::remove(path_);
        auto opened = open_registers(path_, large, Image(large.bytes()));
        ASSERT_TRUE(opened);
        Image image(large.bytes(), 1);
        ASSERT_TRUE(opened->file.commit(image));
        const std::string older = bytes_of(path_);
        image[0] = 2;
        ASSERT_TRUE(opened->file.commit(image));
        const std::string whole = bytes_of(path_);
        overwrite(path_, damage == Damage::emptied ? std::string()
                         : damage == Damage::cut   ? whole.substr(0, kPage)
                         : damage == Damage::zeros ? std::string(whole.size(), '\0')
                                                   : older);
        image[0] = 3;
        ASSERT_TRUE(opened->file.commit(image));
        opened = Result<OpenedRegisters>(fail(Code::not_found));  // closes the file
        for (int commits = 0; commits < 2; ++commits) {
            auto again = open_registers(path_, large, Image(large.bytes()));
            ASSERT_TRUE(again);
            EXPECT_EQ(again->set_aside, "") << static_cast<int>(damage);
            EXPECT_TRUE(std::ranges::equal(again->file.image(), image)) << static_cast<int>(damage);
            ++image[0];
            ASSERT_TRUE(again->file.commit(image));
        }
    }
}

TEST_F(OpenRegisters, LeavesAForeignFileAlone) {
    for (const std::string& foreign : {std::string("x"), std::string("my thesis\n"), std::string(4095, 'x'),
                                       std::string(20'000, 'x'), std::string("{")})
        for (const bool beside : {false, true}) {
            const std::string path = beside ? path_ + ".new" : path_;
            overwrite(path, foreign);
            const auto opened = open_registers(path_, kLayout, Image(kLayout.bytes()));
            ASSERT_FALSE(opened);
            EXPECT_EQ(opened.error().code, Code::unsupported);
            EXPECT_EQ(opened.error().subject.view(), path.substr(0, opened.error().subject.size()));
            EXPECT_EQ(bytes_of(path), foreign);
            EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
            fs::remove(path);
        }
}

TEST_F(OpenRegisters, LeavesAloneWhatIsNoRegularFile) {
    ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    EXPECT_EQ(open_registers(path_, kLayout, Image(kLayout.bytes())).error().code, Code::unsupported);
    EXPECT_TRUE(fs::is_fifo(path_));
    const auto link = (directory_ / "link").string();
    fs::create_symlink(path_, link);
    EXPECT_EQ(open_registers(link, kLayout, Image(kLayout.bytes())).error().code, Code::unsupported);
    fs::remove(path_);
    EXPECT_EQ(open_registers(link, kLayout, Image(kLayout.bytes())).error().code, Code::cannot_open);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);
}

TEST_F(OpenRegisters, SaysWhatCannotBeMade) {
    path_ = (directory_ / "nowhere" / "unit.registers").string();
    EXPECT_EQ(open_registers(path_, kLayout, Image(kLayout.bytes())).error().code, Code::cannot_open);
}

}  // namespace register_writer_test
}  // namespace takt::store
