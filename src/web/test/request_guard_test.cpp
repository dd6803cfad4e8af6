#include "http/request_guard.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace takt::web {
namespace request_guard_test {

using Refused = std::optional<Refusal>;

constexpr auto kSecret = "0123456789abcdef";

GuardedRequest get(const char* host) {
    return {.host = host};
}

GuardedRequest change() {
    return {.reads = false,
            .changes = true,
            .host = "127.0.0.1:8502",
            .mark = "1",
            .content_type = "application/json; charset=utf-8"};
}

TEST(RequestGuard, AdmitsOwnHostsOnly) {
    struct Case {
        const char* bound;
        const char* host;
        bool admitted;
    };
    const std::vector<Case> cases{
        {"127.0.0.1", "127.0.0.1:8502", true},
        {"127.0.0.1", "127.0.0.1", true},
        {"127.0.0.1", "127.9.9.9:1", true},
        {"127.0.0.1", "localhost:9000", true},
        {"127.0.0.1", "LOCALHOST", true},
        {"127.0.0.1", "[::1]:8502", true},
        {"127.0.0.1", "evil.example", false},
        {"127.0.0.1", "127.0.0.1.evil.example", false},
        {"127.0.0.1", "localhost.", false},
        {"127.0.0.1", "10.0.0.5:8502", false},
        {"127.0.0.1", "", false},
        {"127.0.0.1", "localhost:port", false},
        {"127.0.0.1", "localhost:123456", false},
        {"127.0.0.1", "[::1", false},
        {"127.0.0.1", "[evil]", false},
        {"127.0.0.1", "a@localhost", false},
        {"10.0.0.5", "10.0.0.5:8502", true},
        {"10.0.0.5", "localhost", true},
        {"10.0.0.5", "10.0.0.6:8502", false},
        {"10.0.0.5", "station", true},
        {"", "10.0.0.5", true},
        {"0.0.0.0", "10.0.0.5", true},
        {"::", "[fe80::1]:8502", true},
        {"", "evil.example", false},
        {"fe80::1", "[FE80::1]:8502", true},
    };
    for (const auto& its : cases) {
        const RequestGuard guard({.address = its.bound, .names = {"station"}});
        EXPECT_EQ(!guard.check(get(its.host)).has_value(), its.admitted) << its.bound << ' ' << its.host;
    }
    EXPECT_EQ(RequestGuard({}).check({}), (Refusal{421, "host"}));
}

TEST(RequestGuard, AppliesItsRulesInOrder) {
    struct Case {
        std::function<void(GuardedRequest&)> with;
        Refused refused;
    };
    const std::vector<Case> cases{
        {[](auto&) {}, std::nullopt},
        {[](auto& r) { r.origin = "http://127.0.0.1:8502"; }, std::nullopt},
        {[](auto& r) { r.origin = "http://127.0.0.1:8503"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.origin = "https://127.0.0.1:8502"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.origin = "null"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.tls = true, r.origin = "https://127.0.0.1:8502"; }, std::nullopt},
        {[](auto& r) { r.tls = true, r.origin = "http://127.0.0.1:8502"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.forwarded_host = "plant", r.origin = "http://plant"; }, std::nullopt},
        {[](auto& r) { r.forwarded_host = "plant", r.origin = "http://127.0.0.1:8502"; },
         Refusal{403, "origin"}},
        {[](auto& r) { r.forwarded_host = "evil.example"; }, Refusal{421, "host"}},
        {[](auto& r) { r.forwarded_host = "plant", r.host = "evil.example"; }, Refusal{421, "host"}},
        {[](auto& r) { r.fetch_site = "same-origin"; }, std::nullopt},
        {[](auto& r) { r.fetch_site = "none"; }, std::nullopt},
        {[](auto& r) { r.fetch_site = "cross-site"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.fetch_site = "same-site"; }, Refusal{403, "origin"}},
        {[](auto& r) { r.mark = std::nullopt; }, Refusal{403, "mark"}},
        {[](auto& r) { r.mark = "yes"; }, Refusal{403, "mark"}},
        {[](auto& r) { r.content_type = std::nullopt; }, Refusal{415, "content"}},
        {[](auto& r) { r.content_type = "text/plain"; }, Refusal{415, "content"}},
        {[](auto& r) { r.content_type = "application/jsonp"; }, Refusal{415, "content"}},
        {[](auto& r) { r.content_type = "APPLICATION/JSON"; }, std::nullopt},
        {[](auto& r) { r.parameters = 65; }, Refusal{400, "query"}},
        {[](auto& r) { r.longest_parameter = 1025; }, Refusal{400, "query"}},
    };
    const RequestGuard guard({.names = {"plant"}, .allow_write = true});
    for (std::size_t i = 0; i < cases.size(); ++i) {
        auto request = change();
        cases[i].with(request);
        EXPECT_EQ(guard.check(request), cases[i].refused) << i;
    }
}

TEST(RequestGuard, RefusesChangesWithoutAllowWrite) {
    const RequestGuard guard({});
    EXPECT_EQ(guard.check(change()), (Refusal{403, "read_only"}));
    auto evaluation = change();
    evaluation.changes = false;
    EXPECT_EQ(guard.check(evaluation), std::nullopt);
    EXPECT_EQ(guard.check(get("localhost")), std::nullopt);
}

TEST(RequestGuard, NeedsTheToken) {
    const RequestGuard guard({.token = kSecret, .allow_write = true});
    const auto with = [](bool reads, std::optional<std::string> header, std::optional<std::string> query) {
        auto request = change();
        request.reads = reads;
        request.authorization = std::move(header);
        request.query_token = std::move(query);
        return request;
    };
    const std::string secret = kSecret;
    EXPECT_EQ(guard.check(with(true, {}, {})), (Refusal{401, "token"}));
    EXPECT_EQ(guard.check(with(true, "Bearer " + secret, {})), std::nullopt);
    EXPECT_EQ(guard.check(with(false, "bearer " + secret, {})), std::nullopt);
    EXPECT_EQ(guard.check(with(true, "Bearer " + secret + "x", {})), (Refusal{401, "token"}));
    EXPECT_EQ(guard.check(with(true, "Bearer ", {})), (Refusal{401, "token"}));
    EXPECT_EQ(guard.check(with(true, "Basic " + secret, {})), (Refusal{401, "token"}));
    EXPECT_EQ(guard.check(with(true, {}, secret)), std::nullopt);
    EXPECT_EQ(guard.check(with(false, {}, secret)), (Refusal{401, "token"}));
    EXPECT_EQ(guard.check(with(true, "Bearer wrong", secret)), (Refusal{401, "token"}));
    auto page = with(true, {}, {});
    page.api = false;
    EXPECT_EQ(guard.check(page), std::nullopt);
}

TEST(RequestGuard, ComparesWholeTokens) {
    EXPECT_TRUE(equal_in_constant_time("abc", "abc"));
    EXPECT_FALSE(equal_in_constant_time("abc", "abd"));
    EXPECT_FALSE(equal_in_constant_time("abc", "abcabc"));
    EXPECT_FALSE(equal_in_constant_time("abc", ""));
    EXPECT_FALSE(equal_in_constant_time("abc", "ab"));
}

TEST(RequestGuard, KnowsLoopbackAddresses) {
    EXPECT_TRUE(is_loopback("127.0.0.1"));
    EXPECT_TRUE(is_loopback("127.255.0.1"));
    EXPECT_TRUE(is_loopback("::1"));
    EXPECT_FALSE(is_loopback("::"));
    EXPECT_FALSE(is_loopback(""));
    EXPECT_FALSE(is_loopback("0.0.0.0"));
    EXPECT_FALSE(is_loopback("192.168.1.1"));
    EXPECT_FALSE(is_loopback("127.0.0.1.example"));
}

TEST(PeerRates, LimitsEachAddressByItself) {
    using namespace std::chrono_literals;
    PeerRates rates(2, 100ms);
    const Instant t{1s};
    EXPECT_TRUE(rates.admit("a", t));
    EXPECT_TRUE(rates.admit("a", t));
    EXPECT_FALSE(rates.admit("a", t));
    EXPECT_TRUE(rates.admit("b", t));
    EXPECT_TRUE(rates.admit("a", t + 100ms));
}

TEST(PeerRates, ForgetsQuietAddresses) {
    using namespace std::chrono_literals;
    PeerRates rates(1, 100ms);
    Instant t{1s};
    for (std::size_t i = 0; i < PeerRates::kMostPeers; ++i) EXPECT_TRUE(rates.admit(std::to_string(i), t));
    EXPECT_FALSE(rates.admit("one more", t));
    EXPECT_TRUE(rates.admit("one more", t + 100ms));
}

}  // namespace request_guard_test
}  // namespace takt::web
