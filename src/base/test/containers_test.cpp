#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <vector>

#include "takt/base/bounded_vector.hpp"
#include "takt/base/inplace_string.hpp"
#include "takt/base/inplace_vector.hpp"

namespace takt {
namespace containers_test {

TEST(InplaceString, CutsWhatDoesNotFit) {
    EXPECT_EQ(InplaceString<4>("abcdef").view(), "abcd");
    EXPECT_EQ(InplaceString<4>("ab").view(), "ab");
    EXPECT_TRUE(InplaceString<4>().empty());
}

TEST(InplaceVector, RefusesBeyondItsCapacity) {
    InplaceVector<int, 2> values;
    EXPECT_TRUE(values.try_push_back(1));
    EXPECT_TRUE(values.try_push_back(2));
    EXPECT_FALSE(values.try_push_back(3));
    EXPECT_EQ(values, (InplaceVector<int, 2>{1, 2}));
    values.drop_front(1);
    EXPECT_EQ(values, (InplaceVector<int, 2>{2}));
    values.resize(2);
    EXPECT_EQ(values[1], 0) << "new elements are value-initialised, also where an old one stood";
}

TEST(BoundedVector, HoldsWhatItsStorageHolds) {
    std::array<int, 2> storage{};
    BoundedVector<int> values(storage);
    EXPECT_TRUE(values.empty());
    values.push_back(1);
    EXPECT_TRUE(values.try_push_back(2));
    EXPECT_TRUE(values.full());
    EXPECT_FALSE(values.try_push_back(3));
    EXPECT_EQ(values.back(), 2);
    EXPECT_EQ(storage, (std::array{1, 2}));
    values.assign(std::array{7});
    EXPECT_EQ(values.size(), 1U);
    EXPECT_EQ(values[0], 7);
    EXPECT_TRUE(BoundedVector<int>().full());
}

TEST(BoundedVectorDeathTest, StopsAtItsEnd) {
    std::array<int, 1> storage{};
    BoundedVector<int> values(storage);
    EXPECT_DEATH((void)values[0], "");
    EXPECT_DEATH(values.assign(std::array{1, 2}), "");
}

TEST(InplaceVectorDeathTest, StopsAtAWrongIndex) {
    const InplaceVector<int, 2> values{1};
    EXPECT_DEATH((void)values[1], "");
}

}  // namespace containers_test
}  // namespace takt
