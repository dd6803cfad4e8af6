#include "reads/distinct_read.hpp"

#include <gtest/gtest.h>

#include <map>

namespace takt::poll {
namespace distinct_read_test {

using bus::Ambiguity;
using plan::ReadAlternative;
using Kind = ReadAlternative::Kind;

constexpr auto kRead = wire::Function::read_holding_registers;

/// A read of 4 registers, one wider read, one part, and another read.
DistinctRead made() {
    plan::ReadAlternatives all;
    all.push_back({Kind::wider, kRead, 0, 5});
    all.push_back({Kind::part, kRead, 0, 2});
    all.push_back({Kind::another, kRead, 100, 9});
    return DistinctRead(all);
}

/// The quantity that is sent, 4 for the planned read; `ambiguous` has those that are not `none`.
int chosen(DistinctRead& read, std::map<int, Ambiguity> ambiguous) {
    const auto* instead = read.choose(ambiguous[4], [&](wire::Function, int quantity) {
        return ambiguous.contains(quantity) ? ambiguous[quantity] : Ambiguity::none;
    });
    read.send(instead);
    return instead ? instead->quantity : 4;
}

TEST(DistinctRead, IsTheLeastAmbiguousWithAllValues) {
    using enum Ambiguity;
    const struct {
        std::map<int, Ambiguity> ambiguous;
        int sent;
    } cases[] = {
        {{}, 4},
        {{{4, passed}}, 5},
        {{{4, held}}, 5},
        {{{4, passed}, {5, passed}}, 4},
        {{{4, suspected}, {5, held}}, 4},
        {{{4, held}, {5, passed}}, 5},
        {{{4, held}, {5, held}}, 2},
        {{{4, doubted}, {5, doubted}, {2, passed}}, 9},
        {{{4, held}, {5, held}, {2, held}, {9, held}}, 4},
    };
    for (const auto& c : cases) {
        auto read = made();
        EXPECT_EQ(chosen(read, c.ambiguous), c.sent);
    }
}

TEST(DistinctRead, OnePartIsReadForEachAnswerOfTheWhole) {
    auto read = made();
    const std::map<int, Ambiguity> lost = {{4, Ambiguity::held}, {5, Ambiguity::held}};
    EXPECT_EQ(chosen(read, lost), 2);
    read.on_part_answered();
    EXPECT_EQ(chosen(read, lost), 4) << "it waits";
    read.on_answered();
    EXPECT_EQ(chosen(read, lost), 2);
}

TEST(DistinctRead, WhatTheDeviceRefusesIsNotSentAgain) {
    auto read = made();
    EXPECT_EQ(chosen(read, {{4, Ambiguity::held}}), 5);
    read.on_refused();
    EXPECT_EQ(chosen(read, {{4, Ambiguity::held}}), 2);
}

}  // namespace distinct_read_test
}  // namespace takt::poll
