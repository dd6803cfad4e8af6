#include "takt/line/host_places.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace takt::line {
namespace host_places_test {

using Names = std::vector<std::string>;

TEST(HostPlaces, AreTakenInTurn) {
    Names wanted;
    HostPlaces places([&](const std::string& host) { wanted.push_back(host); });
    Names admitted;
    const auto ask = [&](const std::string& host, const std::string& who) {
        return std::optional(places.ask(host, 1, [&, who] { admitted.push_back(who); }));
    };
    auto a = ask("plc", "a");
    auto b = ask("plc", "b");
    auto c = ask("plc", "c");
    auto other = ask("meter", "other");
    EXPECT_EQ(admitted, (Names{"a", "other"}));
    EXPECT_EQ(wanted, (Names{"plc", "plc"}));
    EXPECT_TRUE(places.wanted("plc"));
    EXPECT_FALSE(places.wanted("meter"));
    b.reset();
    EXPECT_EQ(admitted, (Names{"a", "other"})) << "it has only waited";
    a.reset();
    EXPECT_EQ(admitted, (Names{"a", "other", "c"}));
    EXPECT_FALSE(places.wanted("plc"));
    c.reset();
    a = ask("plc", "a");
    EXPECT_EQ(admitted.back(), "a");
}

TEST(HostPlaces, ALineThatNeedsFewerWaitsForThem) {
    HostPlaces places;
    int admitted = 0;
    const auto count = [&] { ++admitted; };
    auto first = std::optional(places.ask("plc", 2, count));
    auto second = std::optional(places.ask("plc", 2, count));
    const auto alone = places.ask("plc", 1, count);
    EXPECT_EQ(admitted, 2);
    first.reset();
    EXPECT_EQ(admitted, 2);
    second.reset();
    EXPECT_EQ(admitted, 3);
}

}  // namespace host_places_test
}  // namespace takt::line
