// The search for what a device has, against devices whose map is known.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <ostream>
#include <set>

#include "takt/discover/range_probe.hpp"

namespace takt::model {
std::ostream& operator<<(std::ostream& out, const ItemRange& range) {
    return out << range.first << ".." << range.last;
}
}  // namespace takt::model

namespace takt::discover {
namespace {

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
    std::size_t asked = 0;

    ProbeReply operator()(const ProbeRead& read) {
        ++asked;
        EXPECT_GE(read.quantity, 1);
        EXPECT_LE(read.start + read.quantity, 65536);
        if (dies_at != 0 && asked >= dies_at) return ProbeReply::silent;
        if (whims != 0 && asked % whims == 0) return ProbeReply::refused;
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

TEST(RangeProbe, TakesFewRequestsOfAnOrdinaryDevice) {
    // 0..99, 200..249 and 1000..1009 in 65536 addresses.
    Device device{.map = {{0, 99}, {200, 249}, {1000, 1009}}};
    ProbeConfig config;
    config.step = 128;
    const auto result = probe(config, device);
    EXPECT_EQ(result.readable, device.map);
    EXPECT_LT(result.requests, 1300U);

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

TEST(RangeProbe, StopsWhenItIsTold) {
    Device device{.map = {{0, 2000}}};
    std::size_t asked = 0;
    const auto result = probe_ranges({.last = 2000}, [&](const ProbeRead& read) {
        return ++asked == 4 ? ProbeReply::stop : device(read);
    });
    EXPECT_EQ(result.end, ProbeEnd::stopped);
    EXPECT_EQ(asked, 4U);
    EXPECT_EQ(result.readable, (Ranges{{0, 250}}));
}

}  // namespace
}  // namespace takt::discover
