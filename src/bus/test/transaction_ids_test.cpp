#include "takt/bus/transaction_ids.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace takt::bus {
namespace transaction_ids_test {

constexpr auto kNone = [](std::uint16_t) { return false; };

TEST(TransactionIds, ConfusesNeighboursAndSwappedBytes) {
    const struct {
        std::uint16_t a, b;
        bool confused;
    } cases[] = {{0x1234, 0x1234, true},  {0x1234, 0x1235, true}, {0x1234, 0x1233, true},
                 {0x1234, 0x1236, false}, {0x1234, 0x3412, true}, {0x1234, 0x3413, false},
                 {0x0000, 0xFFFF, true},  {0xFFFF, 0x0000, true}, {0x0001, 0x0100, true},
                 {0x0001, 0x0101, false}};
    for (const auto& c : cases) {
        EXPECT_EQ(easily_confused(c.a, c.b), c.confused) << c.a << ' ' << c.b;
        EXPECT_EQ(easily_confused(c.b, c.a), c.confused) << c.b << ' ' << c.a;
    }
}

TEST(TransactionIds, BeginWithTheirStartAndAdvanceByTheStep) {
    TransactionIds ids(1);
    EXPECT_EQ(ids.next(kNone), 0x0001);
    EXPECT_EQ(ids.next(kNone), 0x9E38);
    EXPECT_EQ(ids.next(kNone), 0x3C6F);
    EXPECT_EQ(TransactionIds(0).next(kNone), TransactionIds::kStep) << "0 is never used";
}

// Any two of the last 30,000 differ by more than one, from any start.
TEST(TransactionIds, UseNeighboursFarApart) {
    for (const int first : {1, 0x8000, 0xFFFF}) {
        TransactionIds ids(static_cast<std::uint16_t>(first));
        std::vector<int> used_at(65536 + 2, -100'000);  // by id + 1
        for (int n = 0; n < 140'000; ++n) {
            const std::uint16_t id = ids.next(kNone);
            ASSERT_NE(id, 0);
            for (std::size_t near = 0; near <= 2; ++near)
                ASSERT_GT(n - used_at[id + near], 30'000) << "start " << first;
            used_at[id + std::size_t{1}] = n;
        }
    }
}

TEST(TransactionIds, SkipWhatIsTaken) {
    TransactionIds ids(1);
    EXPECT_EQ(ids.next([](std::uint16_t id) { return id == 0x0001; }), 0x9E38);
}

}  // namespace transaction_ids_test
}  // namespace takt::bus
