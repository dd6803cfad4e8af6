// docs/specification.md, section 2: a queue of at most 1024 requests; what is beyond is left out with a
// warning.
#include "takt/plan/queue_limit.hpp"

#include <gtest/gtest.h>

#include "takt/plan/plan.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::plan {
namespace queue_limit_test {

/// Devices of `sizes` variables that are read one by one, each also by a trigger: one record each.
model::Project project(const std::vector<std::pair<int, int>>& addresses_and_sizes) {
    model::Project result;
    result.profile = model::Profile::owen_kc1;
    result.locals.emplace_back();
    auto& line = result.lines.emplace_back();
    for (const auto& [address, size] : addresses_and_sizes) {
        auto& device = line.devices.emplace_back();
        device.name = "D" + std::to_string(address);
        device.address = UnitId{static_cast<std::uint8_t>(address)};
        for (int i = size - 1; i >= 0; --i) {
            auto& variable = device.variables.emplace_back();
            variable.name = device.name + "V" + std::to_string(i);
            variable.register_number = static_cast<std::uint16_t>(i);
            variable.read = wire::Function::read_holding_registers;
            variable.read_trigger = 0;
            variable.period = std::chrono::milliseconds(100);
        }
    }
    return result;
}

std::size_t requests(const model::Project& project) {
    return make_plan(project).lines[0].requests.size();
}

TEST(QueueLimit, WhatFitsStays) {
    auto described = project({{1, 512}, {2, 512}});
    ASSERT_EQ(requests(described), 1024U);
    EXPECT_TRUE(keep_to_queue(described).findings.empty());
    EXPECT_EQ(requests(described), 1024U);
}

TEST(QueueLimit, WhatIsBeyondGoesInTheOrderOfAddressThenOfTheFile) {
    auto described = project({{9, 400}, {3, 800}});
    const auto [findings, plan] = keep_to_queue(described);
    ASSERT_TRUE(plan);
    EXPECT_EQ(plan->lines[0].requests.size(), 1024U) << "the plan of what is left";
    EXPECT_EQ(requests(described), 1024U);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "plan.too_many_requests");
    EXPECT_EQ(findings[0].severity, model::Severity::warning);
    EXPECT_EQ(findings[0].path, "D9");
    EXPECT_EQ(findings[0].value, "D9V175");  // 224 of 400 fit, in the order of the file: 399 down to 176
    for (const auto& v : described.lines[0].devices[1].variables) EXPECT_TRUE(v.read) << v.name;
    for (std::size_t i = 0; i < 400; ++i)
        EXPECT_EQ(described.lines[0].devices[0].variables[i].read.has_value(), i < 224) << i;
}

// Ungrouped, a variable that is only written by commands has an entry too.
TEST(QueueLimit, LeavesOutWhatIsOnlyWritten) {
    auto described = project({{1, 1030}});
    for (auto& variable : described.lines[0].devices[0].variables) {
        variable.read.reset();
        variable.read_trigger.reset();
        variable.write = wire::Function::write_multiple_registers;
    }
    EXPECT_EQ(keep_to_queue(described).findings.size(), 1U);
    EXPECT_EQ(requests(described), 1024U);
}

TEST(QueueLimit, IsTheProfiles) {
    auto described = project({{1, 1200}});
    described.profile = model::Profile::generic;
    const auto [findings, plan] = keep_to_queue(described);
    EXPECT_TRUE(findings.empty());
    EXPECT_FALSE(plan);
    EXPECT_EQ(requests(described), 1200U);
}

TEST(QueueLimit, IsSpokenOf) {
    for (const auto language : text::kLanguages)
        for (const auto* code : {"plan.too_many_requests", "plan.too_many_requests.advice"})
            EXPECT_TRUE(text::has(language, code)) << code;
}

}  // namespace queue_limit_test
}  // namespace takt::plan
