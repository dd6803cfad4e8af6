#include "takt/publish/sample_queue.hpp"

#include <gtest/gtest.h>

namespace takt::publish {
namespace sample_queue_test {

QueuedSamples samples(std::size_t bytes, std::int64_t wall_ns) {
    return {.payload = std::vector<std::uint8_t>(bytes, 1),
            .samples = 3,
            .first_wall_ns = wall_ns,
            .last_wall_ns = wall_ns + 1,
            .last_monotonic_ns = 0};
}

TEST(SampleQueue, KeepsTheOrder) {
    SampleQueue queue(100);
    EXPECT_TRUE(queue.push(samples(40, 1)));
    EXPECT_FALSE(queue.push(samples(60, 2)));
    EXPECT_EQ(queue.take()->first_wall_ns, 1);
    EXPECT_EQ(queue.bytes(), 60U);
    EXPECT_EQ(queue.take()->first_wall_ns, 2);
    EXPECT_FALSE(queue.take());
    EXPECT_EQ(queue.pushed().samples, 6U);
}

TEST(SampleQueue, WhatDoesNotFitIsALossInItsPlace) {
    SampleQueue queue(100);
    queue.push(samples(80, 10));
    queue.push(samples(30, 20));
    queue.push(samples(30, 30));
    queue.push_loss(5, 15, 50);
    queue.push(samples(20, 60));
    queue.push(samples(1, 70));
    EXPECT_EQ(queue.take()->first_wall_ns, 10);
    const auto full = queue.take();
    ASSERT_TRUE(full);
    EXPECT_TRUE(full->payload.empty());
    EXPECT_TRUE(full->queue_full);
    EXPECT_EQ(full->samples, 6U);
    EXPECT_EQ(full->first_wall_ns, 20);
    EXPECT_EQ(full->last_wall_ns, 31);
    const auto loss = queue.take();
    ASSERT_TRUE(loss);
    EXPECT_TRUE(loss->payload.empty());
    EXPECT_FALSE(loss->queue_full);
    EXPECT_EQ(loss->samples, 5U);
    EXPECT_EQ(loss->first_wall_ns, 15);
    EXPECT_EQ(loss->last_wall_ns, 50);
    EXPECT_EQ(queue.take()->first_wall_ns, 60);
    EXPECT_EQ(queue.take()->samples, 3U);  // a loss
    EXPECT_FALSE(queue.take());
    EXPECT_EQ(queue.pushed().samples, 20U);
}

TEST(SampleQueue, StaysBoundedWithAnyLoss) {
    SampleQueue queue(10);
    for (int i = 0; i < 5000; ++i) {
        queue.push(samples(20, i));
        queue.push_loss(1, i, i);
    }
    std::size_t entries = 0;
    std::uint64_t lost = 0;
    while (const auto loss = queue.take()) {
        ++entries;
        lost += loss->samples;
    }
    EXPECT_LT(entries, 1100U);
    EXPECT_EQ(lost, 20'000U);
}

}  // namespace sample_queue_test
}  // namespace takt::publish
