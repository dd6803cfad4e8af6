#include "takt/host/broadcast_ring.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace takt::host {
namespace broadcast_ring_test {

using Words = std::vector<std::uint64_t>;

TEST(BroadcastRing, ReadersReadEveryRecordIndependently) {
    BroadcastRing ring(64);
    auto early = ring.begin();
    ring.append(Words{1});
    ring.append(Words{2, 3});
    auto late = ring.end();
    ring.append(Words{4});
    Words record;
    for (const Words& expected : {Words{1}, Words{2, 3}, Words{4}}) {
        ASSERT_TRUE(ring.read(early, record));
        EXPECT_EQ(record, expected);
    }
    EXPECT_FALSE(ring.read(early, record));
    ASSERT_TRUE(ring.read(late, record));
    EXPECT_EQ(record, Words{4});
    EXPECT_EQ(early.missed + late.missed, 0U);
}

TEST(BroadcastRing, ASlowReaderContinuesWithTheOldestRecordLeftAndCountsTheRest) {
    BroadcastRing ring(32);  // memory for ten records of one word
    auto cursor = ring.begin();
    Words record;
    ring.append(Words{0});
    ASSERT_TRUE(ring.read(cursor, record));
    for (std::uint64_t i = 1; i <= 100; ++i) ring.append(Words{i});
    ASSERT_TRUE(ring.read(cursor, record));
    EXPECT_EQ(record, Words{91});
    EXPECT_EQ(cursor.missed, 90U);
    for (std::uint64_t i = 92; i <= 100; ++i) {
        ASSERT_TRUE(ring.read(cursor, record));
        EXPECT_EQ(record, Words{i});
    }
    EXPECT_FALSE(ring.has_more(cursor));
    EXPECT_EQ(cursor.missed, 90U);
}

TEST(BroadcastRing, AReaderThatHasReadNothingKnowsWhatItMissed) {
    BroadcastRing ring(32);
    auto from_begin = ring.begin();
    auto from_end = ring.end();
    for (std::uint64_t i = 0; i < 100; ++i) ring.append(Words{i});
    Words record;
    ASSERT_TRUE(ring.read(from_begin, record));
    ASSERT_TRUE(ring.read(from_end, record));
    EXPECT_EQ(from_begin.missed, 90U);
    EXPECT_EQ(from_end.missed, 90U);
    const auto late = ring.end();
    EXPECT_EQ(late.next, 100U);
}

// Every record carries its number in each of its words: a torn or skipped record shows.
TEST(BroadcastRing, ConcurrentReadersSeeWholeRecordsInOrder) {
    static constexpr std::uint64_t kRecords = 200'000;
    BroadcastRing ring(1024);
    const auto read_all = [&ring] {
        BroadcastRing::Cursor cursor{};
        Words record;
        std::uint64_t seen = 0;
        std::uint64_t next = 0;
        while (next < kRecords) {
            if (!ring.read(cursor, record)) continue;
            ASSERT_GE(record.front(), next);
            ASSERT_EQ(record.size(), 1 + record.front() % 7);
            for (const auto word : record) ASSERT_EQ(word, record.front());
            next = record.front() + 1;
            ++seen;
        }
        EXPECT_EQ(seen + cursor.missed, kRecords);
    };
    std::thread first(read_all);
    std::thread second(read_all);
    for (std::uint64_t i = 0; i < kRecords; ++i) ring.append(Words(1 + i % 7, i));
    first.join();
    second.join();
}

}  // namespace broadcast_ring_test
}  // namespace takt::host
