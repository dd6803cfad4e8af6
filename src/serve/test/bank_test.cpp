#include "takt/serve/bank.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <vector>

namespace takt::serve {
namespace bank_test {

TEST(RegisterBank, OffersWhatItStores) {
    std::array<std::uint16_t, 10> values{};
    const RegisterBank bank{100, values, {}, {}};
    struct Row {
        std::uint16_t start, count;
        bool exists;
    };
    constexpr Row kRows[] = {{100, 10, true}, {100, 1, true},      {109, 1, true},
                             {99, 1, false},  {99, 5, false},      {109, 2, false},
                             {110, 1, false}, {100, 65535, false}, {65535, 1, false}};
    for (const auto& [start, count, exists] : kRows) {
        EXPECT_EQ(readable(bank, start, count), exists) << start << "+" << count;
        EXPECT_EQ(writable(bank, start, count), exists) << start << "+" << count;
    }
}

TEST(RegisterBank, AnEmptyOneOffersNothing) {
    EXPECT_FALSE(readable(RegisterBank{}, 0, 1));
    EXPECT_FALSE(readable(BitBank{}, 0, 1));
}

TEST(RegisterBank, TheWholeAddressSpaceAndNotOneBeyond) {
    std::vector<std::uint16_t> values(65536);
    const RegisterBank bank{0, values, {}, {}};
    EXPECT_TRUE(readable(bank, 0, 65535));
    EXPECT_TRUE(readable(bank, 65535, 1));
    EXPECT_FALSE(readable(bank, 65535, 2));
    EXPECT_TRUE(readable(bank, 1, 65535));
    EXPECT_FALSE(readable(bank, 2, 65535));
}

TEST(RegisterBank, RangesLeaveHoles) {
    std::array<std::uint16_t, 20> values{};
    constexpr AddressRange kOffered[] = {{2, 4}, {5, 6}, {10, 12}};
    constexpr AddressRange kReadOnly[] = {{5, 5}, {12, 12}};
    const RegisterBank bank{0, values, kOffered, kReadOnly};
    struct Row {
        std::uint16_t start, count;
        bool reads, writes;
    };
    constexpr Row kRows[] = {{2, 3, true, true},    {2, 5, true, false},  {4, 2, true, false},
                             {6, 1, true, true},    {6, 2, false, false}, {1, 2, false, false},
                             {10, 2, true, true},   {10, 3, true, false}, {5, 1, true, false},
                             {12, 2, false, false}, {0, 1, false, false}, {19, 1, false, false}};
    for (const auto& [start, count, reads, writes] : kRows) {
        EXPECT_EQ(readable(bank, start, count), reads) << start << "+" << count;
        EXPECT_EQ(writable(bank, start, count), writes) << start << "+" << count;
    }
}

RC_GTEST_PROP(RegisterBank, ReadsExactlyTheOfferedAddresses, ()) {
    const auto marked = *rc::gen::container<std::set<std::uint16_t>>(rc::gen::inRange<std::uint16_t>(0, 64));
    std::vector<AddressRange> ranges;
    for (const std::uint16_t address : marked) {
        const bool extends =
            !ranges.empty() && ranges.back().last + 1 == address && *rc::gen::arbitrary<bool>();
        if (extends)
            ranges.back().last = address;
        else
            ranges.push_back({address, address});
    }
    RC_PRE(!ranges.empty());
    std::vector<std::uint16_t> values(64);
    const RegisterBank bank{0, values, ranges, {}};
    const auto start = *rc::gen::inRange<std::uint16_t>(0, 70);
    const auto count = *rc::gen::inRange<std::uint16_t>(1, 20);
    bool all = true;
    for (unsigned a = start; a < start + unsigned{count}; ++a)
        all = all && marked.contains(static_cast<std::uint16_t>(a));
    RC_ASSERT(readable(bank, start, count) == all);
}

TEST(BitBank, KeepsBitsPackedFromItsFirstAddress) {
    std::array<std::uint8_t, 2> packed{};
    BitBank bank{1000, 10, packed, {}, {}};
    bank.set(1000, true);
    bank.set(1009, true);
    bank.set(1003, true);
    EXPECT_EQ(packed, (std::array<std::uint8_t, 2>{0b00001001, 0b00000010}));
    bank.set(1003, false);
    EXPECT_EQ(packed[0], 1);
    EXPECT_TRUE(bank.get(1009));
    EXPECT_FALSE(bank.get(1008));
    EXPECT_FALSE(readable(bank, 1009, 2)) << "the second byte has bits that are no addresses";
}

}  // namespace bank_test
}  // namespace takt::serve
