#include "network/fragments.hpp"

#include <gtest/gtest.h>

#include <random>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace fragments_test {

using test::Octets;

struct FragmentsTest : testing::Test {
    FragmentTable table;
    Octets whole;

    FragmentsTest() {
        for (int i = 0; i < 40; ++i) whole.push_back(static_cast<std::uint8_t>(i));
    }
    [[nodiscard]] Fragment part(std::uint32_t begin, std::uint32_t end,
                                std::uint32_t identification = 1) const {
        return {.identification = identification,
                .protocol = 6,
                .offset = begin,
                .more = end < whole.size(),
                .payload = Bytes(whole).subspan(begin, end - begin)};
    }
    /// Whether the fragment completes the datagram, which then must be `whole`.
    bool completes(const Fragment& fragment, std::int64_t time_ns = 0) {
        const auto datagram = table.add(fragment, time_ns);
        if (datagram) {
            EXPECT_EQ(Octets(datagram->begin(), datagram->end()), whole);
        }
        return datagram.has_value();
    }
};

TEST_F(FragmentsTest, InEveryOrder) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> cuts{{0, 8}, {8, 24}, {24, 32}, {32, 40}};
    std::mt19937 random(1);  // NOLINT(*-msc51-cpp): the same orders in each run
    for (int round = 0; round < 50; ++round) {
        std::ranges::shuffle(cuts, random);
        for (std::size_t i = 0; i < cuts.size(); ++i)
            EXPECT_EQ(completes(part(cuts[i].first, cuts[i].second)), i + 1 == cuts.size());
    }
    EXPECT_EQ(table.lost(), 0u);
}

TEST_F(FragmentsTest, RepeatedAndOverlappingOnesKeepTheFirstBytes) {
    EXPECT_FALSE(completes(part(0, 16)));
    const Octets other(16, 0xFF);
    EXPECT_FALSE(
        completes({.identification = 1, .protocol = 6, .offset = 0, .more = true, .payload = other}));
    EXPECT_FALSE(completes(part(0, 16)));
    EXPECT_FALSE(completes(part(24, 40)));
    EXPECT_TRUE(completes(part(8, 32)));
}

TEST_F(FragmentsTest, DatagramsAreKeptApart) {
    EXPECT_FALSE(completes(part(0, 16, 1)));
    EXPECT_FALSE(completes(part(16, 40, 2)));
    EXPECT_TRUE(completes(part(16, 40, 1)));
    EXPECT_TRUE(completes(part(0, 16, 2)));
}

TEST_F(FragmentsTest, AreGivenUpAfterATimeAndWhenThereAreTooMany) {
    EXPECT_FALSE(completes(part(0, 16)));
    EXPECT_FALSE(completes(part(16, 40), 31'000'000'000));
    EXPECT_EQ(table.lost(), 1u);
    for (std::uint32_t i = 2; i < 2 + FragmentTable::kMost; ++i)
        EXPECT_FALSE(completes(part(0, 16, i), 31'000'000'000));
    EXPECT_EQ(table.lost(), 2u);
    table.end();
    EXPECT_EQ(table.lost(), 2u + FragmentTable::kMost);
}

}  // namespace fragments_test
}  // namespace takt::capture
