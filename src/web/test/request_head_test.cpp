#include "http/request_head.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace takt::web {
namespace request_head_test {

ParsedHead parsed(const std::string& fields, const std::string& line = "GET /a?b=c HTTP/1.1") {
    return parse_head(line + "\r\n" + fields + "\r\n");
}

TEST(RequestHead, FindsTheEndOfAHeadInPieces) {
    const std::string bytes = "GET / HTTP/1.1\r\nHost: a\r\n\r\nrest";
    for (std::size_t size = 0; size < 27; ++size)
        EXPECT_FALSE(head_size(std::string_view(bytes).substr(0, size), size > 0 ? size - 1 : 0)) << size;
    for (std::size_t from = 0; from < 27; ++from) EXPECT_EQ(head_size(bytes, from), 27u) << from;
}

using Fields = std::map<std::string, std::string, std::less<>>;

TEST(RequestHead, KeepsKnownFieldsOnly) {
    const auto [head, status] =
        parsed("Host: a\r\nRange: bytes=0-1\r\nCookie: x\r\nX-Takt:  1 \r\nContent-Length: 5\r\n");
    EXPECT_EQ(status, 0);
    EXPECT_EQ(head.method, "GET");
    EXPECT_EQ(head.fields, (Fields{{"host", "a"}, {"x-takt", "1"}}));
    EXPECT_EQ(head.body_bytes, 5u);
    EXPECT_FALSE(head.expects_continue);
    EXPECT_TRUE(parsed("Expect: 100-Continue\r\n").head.expects_continue);
    EXPECT_EQ(head.field("host"), "a");
    EXPECT_EQ(head.field("origin"), std::nullopt);
    EXPECT_EQ(head.text_of("origin"), "");
}

TEST(RequestHead, DecodesTheTarget) {
    using Query = std::multimap<std::string, std::string, std::less<>>;
    struct Case {
        std::string target;
        std::string path;
        Query query;
    };
    const std::vector<Case> cases{
        {"/", "/", {}},
        {"/a%2Fb+c?", "/a/b+c", {}},
        {"/a?b=c&d=%D0%B4+e&b=%26%3d", "/a", {{"b", "c"}, {"b", "&="}, {"d", "д e"}}},
        {"/a?b&=c&&d=e=f#g?h=i", "/a", {{"b", ""}, {"d", "e=f"}}},
    };
    for (const auto& its : cases) {
        const auto [head, status] = parsed("", "GET " + its.target + " HTTP/1.1");
        EXPECT_EQ(status, 0) << its.target;
        EXPECT_EQ(head.path, its.path) << its.target;
        EXPECT_EQ(head.query, its.query) << its.target;
    }
    // The absolute form names the host.
    const std::vector<std::pair<std::string, std::string>> absolute{
        {"http://localhost:8502/a", "/a"}, {"HTTP://localhost:8502", "/"}, {"https://localhost:8502?b", "/"}};
    for (const auto& [target, path] : absolute) {
        const auto [head, status] = parsed("Host: other\r\n", "GET " + target + " HTTP/1.1");
        EXPECT_EQ(status, 0) << target;
        EXPECT_EQ(head.path, path) << target;
        EXPECT_EQ(head.field("host"), "localhost:8502") << target;
    }
    for (const auto* target : {"a", "http:/a", "*"})
        EXPECT_EQ(parsed("", "GET " + std::string(target) + " HTTP/1.1").status, 400) << target;
    for (const auto* target : {"/%", "/%4", "/%4g", "/%g4", "/a?b=%", "/a?%zz=1"})
        EXPECT_EQ(parsed("", "GET " + std::string(target) + " HTTP/1.1").status, 400) << target;
}

TEST(RequestHead, KnowsWhetherTheConnectionStays) {
    EXPECT_TRUE(parsed("").head.keeps_alive);
    EXPECT_FALSE(parsed("Connection: Close\r\n").head.keeps_alive);
    EXPECT_FALSE(parsed("", "GET / HTTP/1.0").head.keeps_alive);
    EXPECT_FALSE(parsed("Connection: x\r\nConnection: close\r\n").head.keeps_alive);
    EXPECT_TRUE(parsed("Connection: Keep-Alive\r\n", "GET / HTTP/1.0").head.keeps_alive);
}

TEST(RequestHead, RejectsWhatIsNotStrict) {
    struct Case {
        std::string line;
        std::string fields;
        int status;
    };
    const std::vector<Case> cases{
        {"GET /", "", 400},
        {"GET  HTTP/1.1", "", 400},
        {"GET / / HTTP/1.1", "", 400},
        {"GET ftp://a/ HTTP/1.1", "", 400},
        {"G\tT / HTTP/1.1", "", 400},
        {"GET / HTTP/2.0", "", 505},
        {"GET / XTTP/1.1", "", 400},
        {"GET /\x01 HTTP/1.1", "", 400},
        {"GET /" + std::string(5000, 'a') + " HTTP/1.1", "", 414},
        {"GET / HTTP/1.1", "Host : a\r\n", 400},
        {"GET / HTTP/1.1", " folded\r\n", 400},
        {"GET / HTTP/1.1", "no colon\r\n", 400},
        {"GET / HTTP/1.1", "Host: a\nX: b\r\n", 400},
        {"GET / HTTP/1.1", "Host: a\rX: b\r\n", 400},
        {"GET / HTTP/1.1", std::string("Host: a\0\r\n", 10), 400},
        {"GET / HTTP/1.1", "Host: a\r\nhost: b\r\n", 400},
        {"GET / HTTP/1.1", "Content-Length: 1\r\nContent-Length: 1\r\n", 400},
        {"GET / HTTP/1.1", "Content-Length: -1\r\n", 400},
        {"GET / HTTP/1.1", "Content-Length: 1, 1\r\n", 400},
        {"GET / HTTP/1.1", "Content-Length: \r\n", 400},
        {"GET / HTTP/1.1", "Content-Length: 16777217\r\n", 413},
        {"GET / HTTP/1.1", "Content-Length: 99999999999999999999\r\n", 413},
        {"GET / HTTP/1.1", "Transfer-Encoding: chunked\r\n", 501},
        {"GET / HTTP/1.1", "Content-Encoding: gzip\r\n", 415},
        {"GET / HTTP/1.1", "Expect: much\r\n", 417},
    };
    for (const auto& its : cases)
        EXPECT_EQ(parsed(its.fields, its.line).status, its.status) << its.line << its.fields;
}

TEST(RequestHead, LimitsHeads) {
    std::string fields;
    for (int i = 0; i < 65; ++i) fields += "A" + std::to_string(i) + ": b\r\n";
    EXPECT_EQ(parsed(fields).status, 431);
    EXPECT_EQ(parsed("A: " + std::string(17000, 'b') + "\r\n").status, 431);
}

TEST(RequestHead, JoinsTheLinesOfProxies) {
    const auto parsed = parse_head(
        "GET / HTTP/1.1\r\nX-Forwarded-For: 192.0.2.7\r\nHost: a\r\nx-forwarded-for: 10.0.0.2,\t10.0.0.3\r\n"
        "X-Forwarded-Proto: https\r\nX-Forwarded-Proto: http\r\n\r\n");
    EXPECT_EQ(parsed.status, 0);
    EXPECT_EQ(parsed.head.fields, (Fields{{"host", "a"},
                                          {"x-forwarded-for", "192.0.2.7, 10.0.0.2,\t10.0.0.3"},
                                          {"x-forwarded-proto", "https, http"}}));
}

}  // namespace request_head_test
}  // namespace takt::web
