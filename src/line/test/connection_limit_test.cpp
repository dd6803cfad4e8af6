#include "takt/line/connection_limit.hpp"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace takt::line {
namespace connection_limit_test {

using Names = std::vector<std::string>;

TEST(ConnectionLimit, AreTakenInTurn) {
    Names wanted;
    ConnectionLimit limit([&](const std::string& host) { wanted.push_back(host); });
    Names admitted;
    const auto ask = [&](const std::string& host, const std::string& who) {
        return std::optional(limit.ask(host, 1, [&, who] { admitted.push_back(who); }));
    };
    auto a = ask("plc", "a");
    auto b = ask("plc", "b");
    auto c = ask("plc", "c");
    auto other = ask("meter", "other");
    EXPECT_EQ(admitted, (Names{"a", "other"}));
    EXPECT_EQ(wanted, (Names{"plc", "plc"}));
    EXPECT_TRUE(limit.wanted("plc"));
    EXPECT_FALSE(limit.wanted("meter"));
    b.reset();
    EXPECT_EQ(admitted, (Names{"a", "other"})) << "it has only waited";
    a.reset();
    EXPECT_EQ(admitted, (Names{"a", "other", "c"}));
    EXPECT_FALSE(limit.wanted("plc"));
    c.reset();
    a = ask("plc", "a");
    EXPECT_EQ(admitted.back(), "a");
}

TEST(ConnectionLimit, ALineThatNeedsFewerWaitsForThem) {
    ConnectionLimit limit;
    int admitted = 0;
    const auto count = [&] { ++admitted; };
    auto first = std::optional(limit.ask("plc", 2, count));
    auto second = std::optional(limit.ask("plc", 2, count));
    const auto alone = limit.ask("plc", 1, count);
    EXPECT_EQ(admitted, 2);
    first.reset();
    EXPECT_EQ(admitted, 2);
    second.reset();
    EXPECT_EQ(admitted, 3);
}

}  // namespace connection_limit_test
}  // namespace takt::line
