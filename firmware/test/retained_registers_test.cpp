#include "takt/firmware/retained_registers.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "board_model.hpp"

namespace takt::firmware {
namespace retained_registers_test {

using model::board;
using Values = std::array<std::uint16_t, 5>;

struct Write {
    std::size_t first;
    std::size_t count;
};

Write write_of(std::uint16_t step) {
    const std::size_t first = step % 5;
    return {first, std::min<std::size_t>(1 + step % 3, 5 - first)};
}

void set(Values& values, std::uint16_t step) {
    for (std::size_t i = 0; i < write_of(step).count; ++i)
        values[write_of(step).first + i] = static_cast<std::uint16_t>(100 * step + i);
}

TEST(RetainedRegisters, AnEmptyFlashHoldsNothing) {
    board = {};
    Values values{1, 2, 3, 4, 5};
    RetainedRegisters retained(values);
    EXPECT_FALSE(retained.restore());
    EXPECT_EQ(values, (Values{1, 2, 3, 4, 5}));
}

TEST(RetainedRegisters, EachStoredValueIsThereAfterARestart) {
    board = {};
    Values values{};
    RetainedRegisters retained(values);
    for (std::uint16_t step = 0; step < 200; ++step) {
        set(values, step);
        retained.store(write_of(step).first, write_of(step).count);
        Values restored{};
        ASSERT_TRUE(RetainedRegisters(restored).restore());
        ASSERT_EQ(restored, values) << step;
    }
}

TEST(RetainedRegisters, NumbersBehindTheLastOneAreIgnored) {
    board = {};
    Values values{1, 2, 3, 4, 5};
    RetainedRegisters retained(values);
    retained.store(5, 1);
    EXPECT_FALSE(RetainedRegisters(values).restore());
    retained.store(4, 100);
    values = {};
    EXPECT_TRUE(RetainedRegisters(values).restore());
    EXPECT_EQ(values, (Values{1, 2, 3, 4, 5}));
}

// The power fails at each word and each erasure of 60 writes, with each kind of torn word, and once more in
// what follows the restart. What store() promised is there; a write that failed is there as a whole or not.
TEST(RetainedRegisters, NoPowerFailureLosesOrTearsAWrite) {
    constexpr std::uint16_t kWrites = 60;
    std::size_t failures = 0;
    for (const std::uint32_t torn : {0U, ~0U, 0x0000FFFFU, 0xFFFF0000U, 0xAAAAAAAAU, 0x00010000U, 1U})
        for (std::size_t at = 0;; ++at) {
            board = {};
            board.fails_after = at;
            board.torn = torn;
            Values promised{};
            bool failed_once = false;
            std::optional<std::uint16_t> open;  // a write that failed
            const auto check = [&](Values values, bool held) {
                if (!held) {
                    ASSERT_EQ(promised, Values{}) << "torn " << torn << " at " << at;
                    return;
                }
                Values other = promised;
                if (open) set(other, *open);
                ASSERT_TRUE(values == promised || values == other) << "torn " << torn << " at " << at;
                promised = values;
            };
            std::uint16_t step = 0;
            while (step < kWrites) {
                Values values{};
                RetainedRegisters retained(values);
                const bool held = retained.restore();
                check(values, held);
                if (HasFatalFailure()) return;
                open.reset();
                values = promised;
                try {
                    for (; step < kWrites; ++step) {
                        open = step;
                        set(values, step);
                        retained.store(write_of(step).first, write_of(step).count);
                        promised = values;
                        open.reset();
                    }
                } catch (const model::PowerFailure&) {
                    ++step;
                    ++failures;
                    if (!std::exchange(failed_once, true)) board.fails_after = at % 7;
                }
            }
            Values values{};
            const bool held = RetainedRegisters(values).restore();
            check(values, held);
            if (HasFatalFailure()) return;
            if (!failed_once) break;  // later than the last word
        }
    EXPECT_GT(failures, 2'000U);
}

TEST(RetainedRegisters, SequenceNumbersWrapAround) {
    board = {};
    Values values{9, 8, 7, 6, 5};
    for (const std::uint32_t sequence : {0xFFFFFFFEU, 0U}) {
        board = {};
        RetainedRegisters first(values);
        first.store(0, 5);
        // The same page with another number: its record does not belong to it.
        board.flash[0][0] = sequence;
        board.flash[0][1] = ~sequence;
        Values restored{};
        EXPECT_TRUE(RetainedRegisters(restored).restore());
        EXPECT_EQ(restored, Values{}) << sequence;
    }
}

}  // namespace retained_registers_test
}  // namespace takt::firmware
