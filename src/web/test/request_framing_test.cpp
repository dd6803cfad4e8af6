#include "http/request_framing.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace takt::web {
namespace request_framing_test {

ParsedHead parsed(const std::string& fields, const std::string& line = "GET /a?b=c HTTP/1.1") {
    return parse_head(line + "\r\n" + fields + "\r\n");
}

TEST(RequestFraming, FindsTheEndOfAHeadInPieces) {
    const std::string bytes = "GET / HTTP/1.1\r\nHost: a\r\n\r\nrest";
    for (std::size_t size = 0; size < 27; ++size)
        EXPECT_FALSE(head_size(std::string_view(bytes).substr(0, size), size > 0 ? size - 1 : 0)) << size;
    for (std::size_t from = 0; from < 27; ++from) EXPECT_EQ(head_size(bytes, from), 27u) << from;
}

TEST(RequestFraming, KeepsKnownFieldsOnly) {
    const auto head =
        parsed("Host: a\r\nRange: bytes=0-1\r\nCookie: x\r\nX-Takt:  1 \r\nContent-Length: 5\r\n");
    EXPECT_EQ(head.status, 0);
    EXPECT_EQ(head.head.text, "GET /a?b=c HTTP/1.1\r\nhost: a\r\nx-takt: 1\r\n\r\n");
    EXPECT_EQ(head.head.body_bytes, 5u);
    EXPECT_FALSE(head.head.expects_continue);
    EXPECT_TRUE(parsed("Expect: 100-Continue\r\n").head.expects_continue);
}

TEST(RequestFraming, RejectsWhatIsNotStrict) {
    struct Case {
        std::string line;
        std::string fields;
        int status;
    };
    const std::vector<Case> cases{
        {"GET /", "", 400},
        {"GET  HTTP/1.1", "", 400},
        {"GET / / HTTP/1.1", "", 400},
        {"GET http://a/ HTTP/1.1", "", 400},
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

TEST(RequestFraming, LimitsHeads) {
    std::string fields;
    for (int i = 0; i < 65; ++i) fields += "A" + std::to_string(i) + ": b\r\n";
    EXPECT_EQ(parsed(fields).status, 431);
    EXPECT_EQ(parsed("A: " + std::string(17000, 'b') + "\r\n").status, 431);
}

TEST(RequestFraming, JoinsTheLinesOfProxies) {
    const auto parsed = parse_head(
        "GET / HTTP/1.1\r\nX-Forwarded-For: 192.0.2.7\r\nHost: a\r\nx-forwarded-for: 10.0.0.2,\t10.0.0.3\r\n"
        "X-Forwarded-Proto: https\r\nX-Forwarded-Proto: http\r\n\r\n");
    EXPECT_EQ(parsed.status, 0);
    EXPECT_EQ(parsed.head.text,
              "GET / HTTP/1.1\r\nhost: a\r\nx-forwarded-for: 192.0.2.7, 10.0.0.2,\t10.0.0.3\r\n"
              "x-forwarded-proto: https, http\r\n\r\n");
}

}  // namespace request_framing_test
}  // namespace takt::web
