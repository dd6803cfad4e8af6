#include "takt/store/posix_journal_storage.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <filesystem>

#include "directory.hpp"
#include "takt/store/journal.hpp"

namespace takt::store {
namespace posix_journal_storage_test {

using namespace std::chrono_literals;

constexpr std::uint64_t kSegment = 64 << 10;

class PosixJournal : public InDirectory {
protected:
    std::unique_ptr<PosixJournalStorage> open() {
        auto storage = PosixJournalStorage::open(directory_, kSegment);
        EXPECT_TRUE(storage);
        return storage ? *std::move(storage) : nullptr;
    }
};

TEST_F(PosixJournal, AppendsAndReads) {
    const auto storage = open();
    overwrite(directory_ / "segment-1", "not ours");
    const std::vector<std::uint8_t> bytes{1, 2, 3};
    ASSERT_TRUE(storage->create(7));
    EXPECT_EQ(storage->create(7).error().numbers[0], EEXIST);
    ASSERT_TRUE(storage->create(8));
    ASSERT_TRUE(storage->append(8, bytes));
    ASSERT_TRUE(storage->append(8, bytes));
    ASSERT_TRUE(storage->sync(8));
    ASSERT_TRUE(storage->sync(7));
    auto files = storage->list_segments().value();
    std::ranges::sort(files, {}, &SegmentFile::number);
    EXPECT_EQ(files, (std::vector<SegmentFile>{{7, 0}, {8, 6}}));
    std::array<std::uint8_t, 8> into{};
    EXPECT_EQ(storage->read(8, 2, into).value(), 4U);
    EXPECT_EQ(into[0], 3);
    ASSERT_TRUE(storage->remove(8));
    ASSERT_TRUE(storage->remove(8));
    EXPECT_EQ(storage->read(8, 0, into).value(), 0U);
}

TEST_F(PosixJournal, FreesTheSpaceBehindALeftSegment) {
    const auto used = [this](const char* name) {
        struct stat status{};
        EXPECT_EQ(::stat((directory_ / name).c_str(), &status), 0);
        return status.st_blocks * 512;
    };
    auto storage = open();
    const std::vector<std::uint8_t> bytes(100, 1);
    for (const std::uint64_t segment : {std::uint64_t{1}, std::uint64_t{2}}) {
        ASSERT_TRUE(storage->create(segment));
        ASSERT_TRUE(storage->append(segment, bytes));
        ASSERT_TRUE(storage->sync(segment));
    }
    EXPECT_LT(used("segment-00000000000000000001"), 16 << 10);
    storage.reset();
    storage = open();
    ASSERT_TRUE(storage->sync(2));
    EXPECT_LT(used("segment-00000000000000000002"), 16 << 10);
    EXPECT_EQ(storage->list_segments().value().front().bytes, 100U);
}

TEST_F(PosixJournal, KeepsTheSlotsOfACursorApart) {
    const auto storage = open();
    EXPECT_EQ(storage->sync_cursor("cloud").error().code, Code::not_found);
    ASSERT_TRUE(storage->write_cursor("cloud", 0, std::vector<std::uint8_t>{1, 2}));
    ASSERT_TRUE(storage->sync_cursor("cloud"));
    std::array<std::uint8_t, 2> into{};
    EXPECT_EQ(storage->read_cursor("cloud", 1, into).value(), 0U);
    ASSERT_TRUE(storage->write_cursor("cloud", 1, std::vector<std::uint8_t>{3, 4}));
    EXPECT_EQ(storage->read_cursor("cloud", 0, into).value(), 2U);
    EXPECT_EQ(into[0], 1);
    EXPECT_EQ(storage->read_cursor("cloud", 1, into).value(), 2U);
    EXPECT_EQ(into[0], 3);
}

TEST_F(PosixJournal, SetsAsideWhatIsNoFile) {
    auto storage = open();
    ASSERT_TRUE(storage->create(1));
    ASSERT_TRUE(storage->append(1, std::vector<std::uint8_t>(100, 1)));
    ASSERT_TRUE(storage->sync(1));
    const auto segment = [](int number) { return "segment-0000000000000000000" + std::to_string(number); };
    std::filesystem::create_directory(directory_ / segment(2));
    ASSERT_EQ(::mkfifo((directory_ / segment(3)).c_str(), 0600), 0);
    std::filesystem::create_symlink("nowhere", directory_ / segment(4));
    ASSERT_EQ(::mkfifo((directory_ / "cursor-cloud").c_str(), 0600), 0);
    const auto files = storage->list_segments();
    ASSERT_TRUE(files);
    ASSERT_EQ(files->size(), 1U);
    EXPECT_EQ(files->front().number, 1U);
    EXPECT_EQ(storage->sync_cursor("cloud").error().code, Code::not_found);
    EXPECT_EQ(storage->set_aside(), directory_ / "cursor-cloud.damaged-1");
    for (const int number : {2, 3, 4}) {
        EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(directory_ / segment(number))));
        EXPECT_TRUE(std::filesystem::exists(
            std::filesystem::symlink_status(directory_ / (segment(number) + ".damaged-1"))));
    }
    // One that takes the place of a segment while the program runs.
    std::filesystem::remove(directory_ / segment(1));
    std::filesystem::create_directory(directory_ / segment(1));
    std::array<std::uint8_t, 10> bytes{};
    EXPECT_EQ(storage->read(1, 0, bytes), std::size_t{0});
    EXPECT_EQ(storage->set_aside(), directory_ / (segment(1) + ".damaged-1"));
}

TEST_F(PosixJournal, KeepsTheEndOfTheStream) {
    std::array<std::uint8_t, 4> bytes{};
    auto storage = open();
    EXPECT_EQ(storage->read_end(0, bytes), std::size_t{0});
    for (const unsigned slot : {0U, 1U})
        ASSERT_TRUE(
            storage->write_end(slot, std::vector<std::uint8_t>(4, static_cast<std::uint8_t>(slot + 5))));
    ASSERT_TRUE(storage->sync_end());
    for (const unsigned slot : {0U, 1U}) {
        ASSERT_EQ(storage->read_end(slot, bytes), std::size_t{4});
        EXPECT_EQ(bytes[3], slot + 5);
    }
}

TEST_F(PosixJournal, IsUsedByOneProgramAtATime) {
    const auto storage = open();
    EXPECT_EQ(PosixJournalStorage::open(directory_, kSegment).error().code, Code::busy);
    EXPECT_EQ(PosixJournalStorage::open(directory_ / "none", kSegment).error().code, Code::cannot_open);
}

TEST_F(PosixJournal, ReportsFilesThatWereRemoved) {
    const auto storage = open();
    const std::vector<std::uint8_t> bytes{1, 2, 3};
    ASSERT_TRUE(storage->create(1));
    ASSERT_TRUE(storage->append(1, bytes));
    ASSERT_TRUE(storage->write_cursor("cloud", 0, bytes));
    ASSERT_TRUE(storage->sync(1));
    ASSERT_TRUE(storage->sync_cursor("cloud"));
    std::filesystem::remove(directory_ / "segment-00000000000000000001");
    std::filesystem::remove(directory_ / "cursor-cloud");
    ASSERT_TRUE(storage->append(1, bytes));
    EXPECT_EQ(storage->sync(1).error().numbers[0], ENOENT);
    EXPECT_EQ(storage->sync_cursor("cloud").error().numbers[0], ENOENT);
    ASSERT_TRUE(storage->write_cursor("cloud", 1, bytes));
    EXPECT_TRUE(storage->sync_cursor("cloud"));
}

TEST_F(PosixJournal, ContinuesWithoutItsFolder) {
    constexpr DestinationId kCloud{0};
    JournalOptions options;
    options.segment_bytes = kSegment;
    options.quota_bytes = 1 << 20;
    const std::array<std::string_view, 1> names{"cloud"};
    const std::vector<std::uint8_t> payload(20'000, 7);
    Instant now{};
    std::uint64_t last = 0;
    {
        const auto storage = open();
        auto journal = Journal::open(*storage, options, names, now, 0);
        ASSERT_TRUE(journal);
        const auto append = [&](int records) {
            for (int i = 0; i < records; ++i) {
                ASSERT_TRUE(journal->append(now, {1, i, i, payload}));
                now += 200ms;
                journal->on_tick(now, 0);
            }
        };
        append(10);
        std::filesystem::remove_all(directory_);
        ASSERT_TRUE(journal->append(now, {1, 0, 0, payload}));
        now += 200ms;
        journal->on_tick(now, 0);
        EXPECT_TRUE(journal->status().failure) << "the samples since the removal are not on the disk";
        append(3);
        EXPECT_FALSE(journal->status().failure);
        std::uint64_t samples = 0;
        std::uint64_t missing = 0;
        while (const auto entry = journal->read(kCloud).value()) {
            last = entry->header.sequence;
            const bool damaged = entry->gap && entry->gap->cause == GapCause::damaged;
            EXPECT_EQ(damaged, entry->gap && entry->gap->samples > 0);
            (entry->gap ? missing : samples) += entry->header.samples;
            ASSERT_TRUE(journal->acknowledge(now, kCloud, last));
        }
        EXPECT_EQ(missing, 10U);
        EXPECT_EQ(samples, 4U);
        EXPECT_TRUE(journal->close(now));
        const auto counters = journal->counters(kCloud);
        EXPECT_EQ(counters.dropped, 10U);
        EXPECT_EQ(counters.appended, counters.delivered + counters.waiting + counters.dropped);
    }
    const auto storage = open();
    auto journal = Journal::open(*storage, options, names, now, 0);
    ASSERT_TRUE(journal);
    EXPECT_EQ(journal->acknowledged(kCloud), last) << "no number is used again";
    EXPECT_EQ(journal->status().epoch, 2U);
}

TEST_F(PosixJournal, ContinuesAfterAKill) {
    JournalOptions options;
    options.segment_bytes = kSegment;
    options.quota_bytes = 1 << 20;
    const std::array<std::string_view, 1> names{"cloud"};
    const std::vector<std::uint8_t> payload(20'000, 7);
    std::uint64_t next = 1;
    Instant now{};
    for (int run = 0; run < 4; ++run) {
        const auto storage = open();
        auto journal = Journal::open(*storage, options, names, now, 0);
        ASSERT_TRUE(journal);
        for (int i = 0; i < 8; ++i) {
            ASSERT_TRUE(journal->append(now, {1, i, i, payload}));
            now += 100ms;
            journal->on_tick(now, 0);
        }
        EXPECT_FALSE(journal->status().failure);
        while (const auto entry = journal->read({0}).value()) {
            EXPECT_EQ(entry->header.sequence, next++);
            ASSERT_TRUE(journal->acknowledge(now, {0}, entry->header.sequence));
        }
        now += 1s;
        journal->on_tick(now, 0);
    }
    EXPECT_EQ(next, 1U + 4 * 9);
}

}  // namespace posix_journal_storage_test
}  // namespace takt::store
