#include "takt/publish/command_request.hpp"

#include <gtest/gtest.h>

namespace takt::publish {
namespace command_request_test {

TEST(CommandRequest, HasItsKeys) {
    const auto parsed = parse_command(
        R"({"id":"abc-1","command":"set","variable":"Setpoint","value":5.5,)"
        R"("sent":"2026-11-24T02:30:00Z","expires":"2026-11-24T05:30:10.5+03:00","expiry_s":2.5})");
    ASSERT_FALSE(parsed.refused) << parsed.refused->detail;
    EXPECT_EQ(parsed.request.id, "abc-1");
    EXPECT_EQ(parsed.request.verb, CommandVerb::set);
    EXPECT_EQ(parsed.request.subject, "Setpoint");
    EXPECT_EQ(parsed.request.value, "5.5");
    EXPECT_EQ(parsed.request.sent_ns, 1'795'487'400'000'000'000);
    EXPECT_EQ(parsed.request.expires_ns, 1'795'487'410'500'000'000);
    EXPECT_EQ(parsed.request.expiry, std::chrono::milliseconds(2500));
}

TEST(CommandRequest, ARefusalNamesTheKeyTheValueAndWhatIsAllowed) {
    const struct {
        std::string_view payload;
        std::string_view detail;
    } cases[] = {
        {"", "no JSON: "},
        {"5", "no object: 5"},
        {R"({"command":"get","variable":"a"})", "id: missing"},
        {R"({"id":"","command":"get","variable":"a"})", R"(id: ""; allowed: 1 to 64 printable)"},
        {R"({"id":"\n","command":"get","variable":"a"})", R"(id: "\n"; allowed: )"},
        {R"({"id":7,"command":"get","variable":"a"})", "id: 7; allowed: "},
        {R"({"id":"1","variable":"a"})", "command: missing"},
        {R"({"id":"1","command":"run","variable":"a"})", R"(command: "run"; allowed: set, write,)"},
        {R"({"id":"1","command":"get"})", "variable: missing"},
        {R"({"id":"1","command":"get","variable":[]})", "variable: []; allowed: a name"},
        {R"({"id":"1","command":"get","variable":"a","value":1})", "value: not a key of get"},
        {R"({"id":"1","command":"enable","variable":"a"})", "variable: not a key of enable"},
        {R"({"id":"1","command":"enable"})", "device: missing"},
        {R"({"id":"1","command":"set","variable":"a","device":"b","value":1})", "device: not a key of set"},
        {R"({"id":"1","command":"set","variable":"a"})", "value: missing"},
        {R"({"id":"1","command":"set","variable":"a","value":null})", "value: null; allowed: true, false,"},
        {R"({"id":"1","command":"set","variable":"a","value":{}})", "value: {}; allowed: "},
        {R"({"id":"1","command":"get","variable":"a","sent":5})", "sent: 5; allowed: a time like 2026"},
        {R"({"id":"1","command":"get","variable":"a","expires":"now"})", R"(expires: "now"; allowed: )"},
        {R"({"id":"1","command":"get","variable":"a","expiry_s":0})", "expiry_s: 0; allowed: above 0, up to"},
        {R"({"id":"1","command":"get","variable":"a","expiry_s":true})", "expiry_s: true; allowed: "},
        {R"({"id":"1","command":"get","variable":"a","expiry_s":86401})", "expiry_s: 86401; allowed: "},
        {R"({"id":"1","command":"get","variable":"a","qos":1})", R"(key "qos" is unknown; allowed: id,)"},
        {R"({"id":"1","command":"get","variable":"a","id, command":1})", "key \"id, command\" is unknown"},
    };
    for (const auto& [payload, detail] : cases) {
        const auto parsed = parse_command(payload);
        ASSERT_TRUE(parsed.refused) << payload;
        EXPECT_EQ(parsed.refused->why, CommandRefusal::malformed);
        EXPECT_TRUE(parsed.refused->detail.starts_with(detail)) << payload << ": " << parsed.refused->detail;
    }
}

TEST(CommandRequest, IsNotLongerThanItsLimit) {
    const std::string long_one = R"({"id":"1","command":"set","variable":"a","value":")" +
                                 std::string(CommandRequest::kMostBytes, 'x') + "\"}";
    EXPECT_TRUE(parse_command(long_one).refused);
    EXPECT_TRUE(plain_set("1", "a", long_one).refused);
    EXPECT_TRUE(plain_set("1", "a", "").refused);
    EXPECT_TRUE(plain_set("1", "", "5").refused);
    EXPECT_FALSE(plain_set("1", "a", "5").refused);
}

}  // namespace command_request_test
}  // namespace takt::publish
