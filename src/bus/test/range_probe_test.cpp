// The search for what a device has, against devices whose map is known.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "takt/bus/range_probe.hpp"

namespace takt::model {
std::ostream& operator<<(std::ostream& out, const ItemRange& range) {
    return out << range.first << ".." << range.last;
}
}  // namespace takt::model

namespace takt::bus {
namespace range_probe_test {

using Ranges = std::vector<model::ItemRange>;

std::uint32_t number(std::uint32_t least, std::uint32_t end) {
    return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(least, end));
}

/// Answers as a device with that map does.
struct Device {
    Ranges map;
    std::uint16_t limit = 125;
    ProbeReply no = ProbeReply::refused;
    std::size_t whims = 0;    // every so many-th question is refused for no reason; 0: none
    std::size_t dies_at = 0;  // silent from that question on; 0: never
    Ranges failed = {};       // items that exist and are refused by exception 4
    std::size_t asked = 0;
    std::vector<ProbeRead> reads = {};

    ProbeReply operator()(const ProbeRead& read) {
        ++asked;
        reads.push_back(read);
        EXPECT_GE(read.quantity, 1);
        EXPECT_LE(read.start + read.quantity, 65536);
        if (dies_at != 0 && asked >= dies_at) return ProbeReply::silent;
        if (whims != 0 && asked % whims == 0) return ProbeReply::refused;
        if (std::ranges::any_of(failed, [&](const auto& range) {
                return read.start >= range.first && read.start + read.quantity - 1 <= range.last;
            }))
            return ProbeReply::failure;
        const bool there = std::ranges::any_of(map, [&](const auto& range) {
            return read.start >= range.first && read.start + read.quantity - 1 <= range.last;
        });
        return there && read.quantity <= limit ? ProbeReply::values : no;
    }
};

ProbeResult probe(const ProbeConfig& config, Device& device) {
    return probe_ranges(config, [&](const ProbeRead& read) { return device(read); });
}

/// Runs with holes of at least one item between them, inside first..last.
Ranges some_map(std::uint32_t first, std::uint32_t last, std::uint32_t longest) {
    Ranges map;
    std::uint32_t a = first + number(0, 40);
    while (a <= last && map.size() < 12) {
        const std::uint32_t end = std::min(last, a + number(0, longest));
        map.push_back({static_cast<std::uint16_t>(a), static_cast<std::uint16_t>(end)});
        a = end + 2 + number(0, number(1, 120));
    }
    return map;
}

std::size_t items(const Ranges& ranges) {
    std::size_t count = 0;
    for (const auto& range : ranges) count += std::size_t{range.last} - range.first + 1;
    return count;
}

ProbeConfig some_config(std::uint32_t length) {
    ProbeConfig config;
    config.first = static_cast<std::uint16_t>(*rc::gen::element(0U, number(0, 65536 - length)));
    config.last = static_cast<std::uint16_t>(config.first + length - 1);
    config.max_requests = 100'000;
    return config;
}

RC_GTEST_PROP(RangeProbe, FindsExactlyWhatIsThere, ()) {
    auto config = some_config(number(1, 900));
    Device device{.map = some_map(config.first, config.last, number(1, 300)),
                  .limit = static_cast<std::uint16_t>(number(1, 140)),
                  .no = *rc::gen::element(ProbeReply::refused, ProbeReply::no_function)};
    if (device.no == ProbeReply::no_function) {
        // A device that answers 1 to all first requests counts as one without the function.
        const bool at_the_head = !device.map.empty() && device.map[0].first < config.first + 16;
        RC_PRE(at_the_head);
    }
    const auto result = probe(config, device);
    RC_ASSERT(result.end == ProbeEnd::complete);
    RC_ASSERT(result.readable == device.map);
    RC_ASSERT(result.requests == device.asked);
    RC_ASSERT(result.longest <= device.limit);
    if (result.limited) RC_ASSERT(result.longest == device.limit);
    const auto limit = std::min<std::uint16_t>(device.limit, config.most);
    RC_ASSERT(result.requests <= most_probe_requests(config, items(device.map), device.map.size(), limit));
}

RC_GTEST_PROP(RangeProbe, MissesNoRunAsLongAsItsStep, ()) {
    auto config = some_config(number(200, 20'000));
    config.step = static_cast<std::uint16_t>(number(2, 200));
    Device device{.map = some_map(config.first, config.last, number(1, 600))};
    const auto result = probe(config, device);
    RC_ASSERT(result.end == ProbeEnd::complete);
    for (const auto& found : result.readable) RC_ASSERT(std::ranges::count(device.map, found) == 1);
    for (const auto& run : device.map)
        if (run.last - run.first + 1 >= config.step) RC_ASSERT(std::ranges::count(result.readable, run) == 1);
    RC_ASSERT(result.requests <=
              most_probe_requests(config, items(device.map), device.map.size(), config.most));
}

RC_GTEST_PROP(RangeProbe, NeverTakesMoreRequestsThanAllowed, ()) {
    auto config = some_config(number(100, 2000));
    config.max_requests = number(1, 200);
    Device device{.map = some_map(config.first, config.last, 50)};
    const auto result = probe(config, device);
    RC_ASSERT(device.asked <= config.max_requests);
    RC_ASSERT(result.requests == device.asked);
    for (const auto& found : result.readable)
        RC_ASSERT(std::ranges::any_of(
            device.map, [&](const auto& run) { return found.first >= run.first && found.last <= run.last; }));
    if (result.end == ProbeEnd::complete)
        RC_ASSERT(result.readable == device.map);
    else
        RC_ASSERT(result.end == ProbeEnd::out_of_requests);
}

RC_GTEST_PROP(RangeProbe, AWhimNeverInventsItems, ()) {
    auto config = some_config(number(50, 500));
    Device device{.map = some_map(config.first, config.last, 200), .whims = number(2, 30)};
    const auto result = probe(config, device);
    for (const auto& found : result.readable)
        RC_ASSERT(std::ranges::any_of(
            device.map, [&](const auto& run) { return found.first >= run.first && found.last <= run.last; }));
}

RC_GTEST_PROP(RangeProbe, AFinerStepBeginsWithTheReadsOfTheCoarserOne, ()) {
    auto config = some_config(number(200, 20'000));
    const auto step = 1U << number(1, 9);
    Device device{.map = some_map(config.first, config.last, number(1, 300))};
    if (*rc::gen::arbitrary<bool>()) device.failed = some_map(config.first, config.last, 8);
    Device same = device;
    config.step = static_cast<std::uint16_t>(step);
    const auto coarse = probe(config, device);
    config.step = static_cast<std::uint16_t>(step / 2);
    const auto fine = probe(config, same);
    RC_ASSERT(fine.requests >= coarse.requests);
    same.reads.resize(device.reads.size());
    RC_ASSERT(same.reads == device.reads);
}

RC_GTEST_PROP(RangeProbe, ReportsExactlyTheAddressesThatItTested, ()) {
    auto config = some_config(number(1, 3000));
    config.step = static_cast<std::uint16_t>(number(1, 100));
    config.max_requests = number(1, 400);
    Device device{.map = some_map(config.first, config.last, 100)};
    const auto result = probe(config, device);
    std::set<unsigned> tested;
    const auto add = [&](unsigned first, unsigned last) {
        for (unsigned a = first; a <= last; ++a) tested.insert(a);
    };
    for (const auto& read : device.reads)
        if (read.quantity == 1) add(read.start, read.start);
    for (const auto& range : result.readable) add(range.first, range.last);
    std::set<unsigned> reported;
    for (const auto& range : result.tested)
        for (unsigned a = range.first; a <= range.last; ++a) reported.insert(a);
    RC_ASSERT(reported == tested);
}

TEST(RangeProbe, FindsSingleItemsAtLikelyAddresses) {
    // Low addresses, and one to three items behind a round number.
    Device device{.map = {{37, 37}, {255, 255}, {1001, 1001}, {4099, 4099}, {12002, 12002}, {40300, 40300}}};
    ProbeConfig config;
    config.step = 128;
    EXPECT_EQ(probe(config, device).readable, device.map);
}

TEST(RangeProbe, ReportsItemsThatExistAndRefuse) {
    // The refused items are a sign of others: 1010..1012 are read because 1000..1005 refuse.
    Device device{.map = {{0, 9}, {1010, 1012}}, .failed = {{1000, 1005}}};
    ProbeConfig config;
    config.step = 128;
    const auto result = probe(config, device);
    EXPECT_EQ(result.readable, device.map);
    EXPECT_EQ(result.refused, (std::vector<RefusedItems>{{{1000, 1005}, ProbeReply::failure}}));
    EXPECT_FALSE(result.one_refusal);
}

TEST(RangeProbe, ADeviceWithOneRefusalHasNoRefusedItems) {
    for (const auto no : {ProbeReply::bad_value, ProbeReply::failure}) {
        Device device{.map = {{0, 9}, {40, 44}}, .no = no};
        const auto result = probe({.last = 99}, device);
        EXPECT_EQ(result.readable, device.map);
        EXPECT_TRUE(result.refused.empty());
        EXPECT_TRUE(result.one_refusal);
        EXPECT_EQ(result.requests, device.asked);
        EXPECT_EQ(result.tested, (Ranges{{0, 99}}));
    }
}

TEST(RangeProbe, TakesFewRequestsOfAnOrdinaryDevice) {
    // 0..99, 200..249 and 1000..1009 in 65536 addresses.
    Device device{.map = {{0, 99}, {200, 249}, {1000, 1009}}};
    ProbeConfig config;
    config.step = 128;
    const auto result = probe(config, device);
    EXPECT_EQ(result.readable, device.map);
    EXPECT_LT(result.requests, 1700U);

    Device dense{.map = {{0, 9999}}};
    config = {.last = 9999};
    EXPECT_EQ(probe(config, dense).readable, dense.map);
    EXPECT_EQ(dense.asked, 1U + 80U) << "one item, then reads of 125";
}

TEST(RangeProbe, FindsTheLongestRead) {
    Device device{.map = {{0, 99}}, .limit = 16};
    const auto result = probe({.last = 99}, device);
    EXPECT_EQ(result.readable, device.map);
    EXPECT_TRUE(result.limited);
    EXPECT_EQ(result.longest, 16);
}

TEST(RangeProbe, ARunThatWasReadInPartsShowsTheLongestRead) {
    Device device{.map = {{40, 139}}};
    const auto result = probe({.first = 40, .last = 200}, device);
    EXPECT_EQ(result.longest, 100) << "item 40, then 99 items, then all of them at once";
    EXPECT_FALSE(result.limited);
    Device narrow{.map = {{40, 139}}, .limit = 70};
    const auto limited = probe({.last = 200, .step = 90}, narrow);
    EXPECT_EQ(limited.longest, 70);
    EXPECT_TRUE(limited.limited);
    EXPECT_EQ(limited.readable, narrow.map);
}

TEST(RangeProbe, BitsAreReadByThousands) {
    Device device{.map = {{0, 65535}}, .limit = 2000};
    const auto result = probe({.most = 2000}, device);
    EXPECT_EQ(result.readable, device.map);
    EXPECT_LE(device.asked, 36U);
}

TEST(RangeProbe, GivesUpWhatTheDeviceDoesNotHave) {
    Device none{.map = {}, .no = ProbeReply::no_function};
    EXPECT_EQ(probe({.step = 128}, none).end, ProbeEnd::no_function);
    EXPECT_EQ(none.asked, 24U);
    Device mute{.map = {}, .no = ProbeReply::silent};
    EXPECT_EQ(probe({.step = 128}, mute).end, ProbeEnd::no_answer);
    EXPECT_EQ(mute.asked, 8U);
    Device empty{.map = {}};
    const auto result = probe({.last = 499}, empty);
    EXPECT_EQ(result.end, ProbeEnd::complete) << "a device that answers 2 everywhere has nothing";
    EXPECT_EQ(empty.asked, 500U);
}

TEST(RangeProbe, ADeviceThatSaysNoBySilenceIsNotADeadOne) {
    Device device{.map = {{3, 20}, {40, 44}}, .no = ProbeReply::silent};
    const auto result = probe({.last = 60}, device);
    EXPECT_EQ(result.end, ProbeEnd::complete);
    EXPECT_EQ(result.readable, device.map);
}

TEST(RangeProbe, ADeviceThatDiesLeavesNoFalseHoles) {
    Device device{.map = {{0, 2000}}, .dies_at = 5};
    const auto result = probe({.last = 2000}, device);
    EXPECT_EQ(result.end, ProbeEnd::fell_silent);
    EXPECT_EQ(device.asked, 6U) << "the question that stayed without answer, and one that had one before";
    EXPECT_EQ(result.readable, (Ranges{{0, 375}}));
    EXPECT_EQ(result.next, 376U);
}

TEST(RangeProbe, StopsOnRequest) {
    Device device{.map = {{0, 2000}}};
    std::size_t asked = 0;
    const auto result = probe_ranges({.last = 2000}, [&](const ProbeRead& read) {
        return ++asked == 4 ? ProbeReply::stop : device(read);
    });
    EXPECT_EQ(result.end, ProbeEnd::stopped);
    EXPECT_EQ(asked, 4U);
    EXPECT_EQ(result.readable, (Ranges{{0, 250}}));
}

}  // namespace range_probe_test
}  // namespace takt::bus
