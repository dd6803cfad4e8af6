#include "takt/firmware/table_store.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "board_model.hpp"
#include "takt/table/format.hpp"

namespace takt::firmware {
namespace table_store_test {

using model::board;
using Image = std::vector<std::uint8_t>;

constexpr std::size_t kMost = (model::Board::kPageWords - 3) * 4;

Image image(std::uint8_t number) {
    return Image(std::size_t{20} + number % 60, number);
}

Image bytes(Bytes stored) {
    return {stored.begin(), stored.end()};
}

Image newest() {
    return bytes(TableStore::stored()[0]);
}

TEST(TableStore, AnEmptyFlashHoldsNothing) {
    board = {};
    EXPECT_TRUE(TableStore::stored()[0].empty());
    EXPECT_TRUE(TableStore::stored()[1].empty());
}

TEST(TableStore, HoldsTheLastTwo) {
    board = {};
    for (std::uint8_t i = 1; i < 50; ++i) {
        EXPECT_EQ(bytes(TableStore::store(image(i), {}).value()), image(i));
        EXPECT_EQ(newest(), image(i));
        if (i > 1) EXPECT_EQ(bytes(TableStore::stored()[1]), image(i - 1));
    }
}

TEST(TableStore, TheRunningOneStaysWhereItIsTheOlder) {
    board = {};
    const Bytes running = TableStore::store(image(1), {}).value();
    EXPECT_TRUE(TableStore::store(image(2), running));
    EXPECT_TRUE(TableStore::store(image(3), running));
    EXPECT_EQ(newest(), image(3));
    EXPECT_EQ(bytes(TableStore::stored()[1]), image(1));
}

TEST(TableStore, TakesNoMoreThanAPage) {
    board = {};
    EXPECT_TRUE(TableStore::store(Image(kMost, 7), {}));
    const auto refused = TableStore::store(Image(kMost + 1, 8), {});
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Code::too_long);
    EXPECT_EQ(newest(), Image(kMost, 7));
}

// As a programmer writes it: without a sequence.
TEST(TableStore, AnImageAloneIsTheOldest) {
    for (const char* magic : {table::kMagic, table::kOwenMagic}) {
        board = {};
        Image alone(magic, magic + table::kMagicSize);
        alone.resize(30, 1);
        alone[table::kLengthOffset + 1] = alone[table::kLengthOffset + 2] = alone[table::kLengthOffset + 3] =
            0;
        alone[table::kLengthOffset] = 30;
        std::copy(alone.begin(), alone.end(), reinterpret_cast<std::uint8_t*>(board.flash[2].data()));
        EXPECT_EQ(newest(), alone);
        EXPECT_TRUE(TableStore::store(image(5), {}));
        EXPECT_EQ(newest(), image(5));
        EXPECT_EQ(bytes(TableStore::stored()[1]), alone);
    }
}

// Each word in turn, with several kinds of torn words: the new table is there as a whole, or the one before.
TEST(TableStore, ThePowerMayFailAtAnyWord) {
    for (const std::uint32_t torn : {0U, ~0U, 0xFFFFU, 0xFFFF0000U, 0x55555555U, 0x00FF00FFU, 1U}) {
        for (std::size_t word = 0;; ++word) {
            board = {};
            ASSERT_TRUE(TableStore::store(image(1), {}) && TableStore::store(image(2), {}));
            board.fails_after = word;
            board.torn = torn;
            bool failed = false;
            try {
                static_cast<void>(TableStore::store(image(3), {}));
            } catch (const model::PowerFailure&) {
                failed = true;
            }
            const Image after = newest();
            ASSERT_TRUE(after == image(2) || after == image(3)) << word << ' ' << torn;
            if (!failed) break;
            ASSERT_TRUE(TableStore::store(image(4), {}));
            ASSERT_EQ(newest(), image(4));
        }
    }
}

}  // namespace table_store_test
}  // namespace takt::firmware
