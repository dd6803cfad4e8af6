#include "takt/publish/message_format.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace takt::publish {
namespace message_format_test {

constexpr std::int64_t kNow = 1'764'000'000'123'456'789;  // 2025-11-24T16:00:00.123Z
const Series kPower{"Power", "Meter", "rs485-1", "kW", DataType::float32, false};
const Series kGo{"go", "", "", "", DataType::boolean, false};

std::string message(const Series& series, const Sample& sample, bool repeated = false) {
    return variable_message({&series, &sample, 12}, 3, repeated);
}

TEST(MessageFormat, AVariableHasItsQualityAndTheIntervalOfItsChange) {
    EXPECT_EQ(message(kPower, {.value = 0.1, .wall_ns = kNow, .previous_wall_ns = kNow - 100'000'000}),
              R"({"variable":"Power","device":"Meter","value":0.1,"unit":"kW","quality":"good",)"
              R"("time":"2025-11-24T16:00:00.123Z","after":"2025-11-24T16:00:00.023Z","cause":"change",)"
              R"("epoch":3,"seq":12})");
    EXPECT_EQ(message(kGo, {.value = true, .cause = SampleCause::heartbeat, .wall_ns = kNow}, true),
              R"({"variable":"go","value":true,"quality":"good","time":"2025-11-24T16:00:00.123Z",)"
              R"("cause":"heartbeat","epoch":3,"seq":12,"repeated":true})");
}

TEST(MessageFormat, ABadValueHasItsReason) {
    EXPECT_EQ(message(kPower, {.value = std::monostate{},
                               .quality = value::Quality::bad,
                               .reason = value::exception_reason(2),
                               .wall_ns = kNow}),
              R"({"variable":"Power","device":"Meter","value":null,"unit":"kW","quality":"bad",)"
              R"("reason":"exception","exception":2,"time":"2025-11-24T16:00:00.123Z","cause":"change",)"
              R"("epoch":3,"seq":12})");
}

TEST(MessageFormat, ABadValueHasItsLastGoodRead) {
    const auto text = message(kPower, {.value = 0.1,
                                       .quality = value::Quality::bad,
                                       .reason = value::Reason::timeout,
                                       .wall_ns = kNow,
                                       .previous_wall_ns = kNow - 100'000'000});
    EXPECT_NE(
        text.find(R"("time":"2025-11-24T16:00:00.123Z","last_good":"2025-11-24T16:00:00.023Z","cause")"),
        std::string::npos)
        << text;
}

TEST(MessageFormat, ValuesAreExact) {
    const struct {
        value::Value value;
        std::string_view text;
    } cases[] = {{std::uint64_t{UINT64_MAX}, R"("value":18446744073709551615,)"},
                 {std::numeric_limits<std::int64_t>::min(), R"("value":-9223372036854775808,)"},
                 {std::nan(""), R"("value":null,"special":"nan",)"},
                 {-std::numeric_limits<double>::infinity(), R"("value":null,"special":"-infinity",)"},
                 {std::string("a\"\n\x01\xff"), "\"value\":\"a\\\"\\n\\u0001\xEF\xBF\xBD\","}};
    for (const auto& [value, text] : cases)
        EXPECT_NE(message(kGo, {.value = value}).find(text), std::string::npos)
            << message(kGo, {.value = value});
}

TEST(MessageFormat, AGroupHasEachVariable) {
    const Series other{"Energy", "Meter", "rs485-1", "", DataType::uint32, false};
    const Sample power{.value = 1.5, .wall_ns = kNow};
    const Sample energy{.value = std::uint64_t{7}, .wall_ns = kNow};
    const PlacedSample samples[] = {{&kPower, &power, 12}, {&other, &energy, 13}};
    EXPECT_EQ(group_message(samples, 3, false),
              R"({"device":"Meter","values":{"Power":{"value":1.5,"unit":"kW","quality":"good",)"
              R"("time":"2025-11-24T16:00:00.123Z","cause":"change","seq":12},"Energy":{"value":7,)"
              R"("quality":"good",)"
              R"("time":"2025-11-24T16:00:00.123Z","cause":"change","seq":13}},"epoch":3})");
}

TEST(MessageFormat, AGapHasItsCauseAndCount) {
    EXPECT_EQ(gap_message({.cause = "quota", .samples = 5, .first_number = 8, .last_wall_ns = kNow}, 2, true),
              R"({"gap":{"cause":"quota","samples":5,"first":"1970-01-01T00:00:00.000Z",)"
              R"("last":"2025-11-24T16:00:00.123Z"},"epoch":2,"seq":8,"repeated":true})");
}

}  // namespace message_format_test
}  // namespace takt::publish
