// A journal with two destinations on a simulated disk.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "simulated_disk.hpp"
#include "takt/store/journal.hpp"

namespace takt::store::test {

using namespace std::chrono_literals;
inline constexpr std::array<std::string_view, 2> kNames{"cloud", "site"};
inline constexpr DestinationId kCloud{0};
inline constexpr DestinationId kSite{1};
inline constexpr std::int64_t kSecond = 1'000'000'000;

inline JournalOptions small() {
    JournalOptions options;
    options.segment_bytes = 64 << 10;
    options.buffer_bytes = 128 << 10;
    options.quota_bytes = 1 << 20;
    return options;
}

class JournalTest : public testing::Test {
protected:
    void start() {
        journal_.reset();
        auto opened = Journal::open(disk_, options_, kNames, now_, wall());
        ASSERT_TRUE(opened) << name(opened.error().code);
        journal_.emplace(*std::move(opened));
    }
    Result<void> append(std::size_t bytes, std::uint64_t samples = 1) {
        return journal_->append(now_, {samples, wall(), 0, std::vector<std::uint8_t>(bytes, 0x5A)});
    }
    /// Records of one sample, two to a segment.
    void append_records(int records) {
        for (int i = 0; i < records; ++i) {
            ASSERT_TRUE(append(30'000));
            tick();
        }
    }
    void tick(Duration time = 100ms) {
        now_ += time;
        journal_->on_tick(now_, wall());
    }
    std::vector<JournalEntry> read_all(DestinationId id) {
        std::vector<JournalEntry> entries;
        for (;;) {
            const auto entry = journal_->read(id);
            if (!entry || !*entry) return entries;
            entries.push_back(**entry);
        }
    }
    /// Reads all. @returns how many entries are marked as repeated; they are the first ones
    std::size_t repeated(DestinationId id) {
        const auto entries = read_all(id);
        const auto is_new = [](const JournalEntry& entry) { return !entry.repeated; };
        const auto first = std::ranges::find_if(entries, is_new);
        EXPECT_TRUE(std::all_of(first, entries.end(), is_new));
        return static_cast<std::size_t>(first - entries.begin());
    }
    void acknowledge_all(DestinationId id) {
        const auto entries = read_all(id);
        if (!entries.empty()) {
            ASSERT_TRUE(journal_->acknowledge(now_, id, entries.back().header.sequence));
        }
    }
    [[nodiscard]] std::int64_t wall() const { return kSecond + now_.time_since_epoch().count(); }

    SimulatedDisk disk_;
    JournalOptions options_ = small();
    std::optional<Journal> journal_;
    Instant now_{};
};

}  // namespace takt::store::test
