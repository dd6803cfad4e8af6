// docs/specification.md, section 2: a queue of at most 1024 requests; what is beyond is left out with a
// warning.
#include "takt/plan/queue_limit.hpp"

#include <gtest/gtest.h>

#include "takt/plan/plan.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::plan {
namespace {

/// Devices of `sizes` variables that are read one by one, each also by a trigger: two counted requests each.
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
    return make_plan(project).lines[0].request_count;
}

TEST(QueueLimit, WhatFitsStays) {
    auto described = project({{1, 256}, {2, 256}});
    ASSERT_EQ(requests(described), 1024U);
    EXPECT_TRUE(keep_to_queue(described).findings.empty());
    EXPECT_EQ(requests(described), 1024U);
}

TEST(QueueLimit, WhatIsBeyondGoesInTheOrderOfAddressThenOfTheFile) {
    auto described = project({{9, 200}, {3, 400}});
    const auto [findings, plan] = keep_to_queue(described);
    ASSERT_TRUE(plan);
    EXPECT_EQ(plan->lines[0].request_count, 1024U) << "the plan of what is left";
    EXPECT_EQ(requests(described), 1024U);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_EQ(findings[0].code, "plan.too_many_requests");
    EXPECT_EQ(findings[0].severity, model::Severity::warning);
    EXPECT_EQ(findings[0].path, "D9");
    EXPECT_EQ(findings[0].value, "D9V87");  // 112 of 200 fit, in the order of the file: 199 down to 88
    for (const auto& v : described.lines[0].devices[1].variables) EXPECT_TRUE(v.read) << v.name;
    for (std::size_t i = 0; i < 200; ++i)
        EXPECT_EQ(described.lines[0].devices[0].variables[i].read.has_value(), i < 112) << i;
}

TEST(QueueLimit, IsTheProfiles) {
    auto described = project({{1, 600}});
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

}  // namespace
}  // namespace takt::plan
