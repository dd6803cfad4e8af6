#include "http/reply_text.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>

namespace takt::web {
namespace reply_text_test {

TEST(ReplyText, HasHeadAndBody) {
    EXPECT_EQ(reply_text({.content_type = "text/csv", .fields = {{"ETag", "\"1\""}}}, "a;b"),
              "HTTP/1.1 200 OK\r\nContent-Type: text/csv\r\nETag: \"1\"\r\nConnection: keep-alive\r\n"
              "Content-Length: 3\r\n\r\na;b");
    EXPECT_EQ(reply_text({.status = 404, .close = true}, ""),
              "HTTP/1.1 404 Not Found\r\nConnection: close\r\nContent-Length: 0\r\n\r\n");
}

TEST(ReplyText, LeavesBodiesOut) {
    EXPECT_TRUE(reply_text({.head_only = true}, "abc").ends_with("Content-Length: 3\r\n\r\n"));
    EXPECT_EQ(reply_text({.status = 304}, "abc"),
              "HTTP/1.1 304 Not Modified\r\nConnection: keep-alive\r\n\r\n");
}

TEST(ReplyText, ABareReplyNamesItsLimit) {
    const auto reply = bare_reply(503);
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 503 Service Unavailable\r\n"));
    EXPECT_NE(reply.find("Retry-After: 1\r\nConnection: close\r\n"), std::string::npos) << reply;
    EXPECT_NE(reply.find("all visitors together"), std::string::npos);
}

TEST(ReplyText, PacksText) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{100'000}}) {
        std::string text(size, ' ');
        for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * i % 251);
        const auto packed = gzip(text);
        EXPECT_TRUE(packed.starts_with("\x1F\x8B"));
        z_stream stream{};
        ASSERT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);
        std::string unpacked(size + 1, '\0');
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
        stream.avail_in = static_cast<uInt>(packed.size());
        stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
        stream.avail_out = static_cast<uInt>(unpacked.size());
        EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
        unpacked.resize(stream.total_out);
        inflateEnd(&stream);
        EXPECT_EQ(unpacked, text);
    }
}

}  // namespace reply_text_test
}  // namespace takt::web
