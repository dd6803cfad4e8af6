#include "takt/model/item_ranges.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>

namespace takt::model {
namespace item_ranges_test {

ItemRanges ranges_of(const std::set<int>& items) {
    ItemRanges ranges;
    for (const int item : items) {
        const auto i = static_cast<std::uint16_t>(item);
        if (!ranges.empty() && ranges.back().last + 1 == item)
            ranges.back().last = i;
        else
            ranges.push_back({i, i});
    }
    return ranges;
}

std::set<int> random_items() {
    const auto list = *rc::gen::container<std::vector<int>>(
        rc::gen::oneOf(rc::gen::inRange(0, 40), rc::gen::inRange(65500, 65536)));
    return {list.begin(), list.end()};
}

RC_GTEST_PROP(ItemRanges, AreTheSetsTheyStandFor, ()) {
    const auto a = random_items();
    const auto b = random_items();
    std::set<int> both = a;
    both.insert(b.begin(), b.end());
    std::set<int> left;
    for (const int item : a)
        if (!b.contains(item)) left.insert(item);
    RC_ASSERT(united(ranges_of(a), ranges_of(b)) == ranges_of(both));
    RC_ASSERT(without(ranges_of(a), ranges_of(b)) == ranges_of(left));
    RC_ASSERT(all_but(all_but(ranges_of(a))) == ranges_of(a));
    for (const auto& range : ranges_of(a)) RC_ASSERT(holds(united(ranges_of(a), ranges_of(b)), range));
}

TEST(ItemRanges, AllButNothingIsAll) {
    EXPECT_EQ(all_but({}), (ItemRanges{{0, 65535}}));
    EXPECT_EQ(all_but({{0, 65535}}), ItemRanges{});
    EXPECT_FALSE(holds({{0, 4}, {6, 9}}, {4, 6}));
}

}  // namespace item_ranges_test
}  // namespace takt::model
