#include "http/http_router.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "http/page.hpp"

namespace takt::web {
namespace http_router_test {

class OneEvent final : public StreamSource {
public:
    bool take(std::string& out) override {
        out += event_text("hello", "1");
        return false;
    }
};

HttpRouter router(bool streams_free = true) {
    return HttpRouter(
        {.names = {"plant.example.com"}, .allow_write = true}, {*parse_network("10.0.0.1")},
        text::Language::english,
        {{Method::get, "/echo", false,
          [](const ApiRequest& request) {
              auto object = file::Json::object();
              for (const auto& [name, value] : request.query) object.set(name, value);
              object.set("peer", request.peer);
              object.set("language", text::tag(request.texts.language()));
              return ApiResponse::json(object);
          }},
         {Method::post, "/echo", true,
          [](const ApiRequest& request) {
              return ApiResponse{.content_type = "text/csv", .body = request.body, .file_name = "a\"b.csv"};
          },
          Work::device},
         {Method::get, "/newest", false, [](const ApiRequest&) { return ApiResponse{}; }, Work::planning,
          true},
         {Method::get, "/long", false,
          [](const ApiRequest&) { return ApiResponse{.body = std::string(100'000, 'x')}; }},
         {Method::get, "/fails", false,
          [](const ApiRequest&) -> ApiResponse { throw std::runtime_error("secret"); }}},
        {{"/events",
          [streams_free](const ApiRequest&) -> std::unique_ptr<StreamSource> {
              return streams_free ? std::make_unique<OneEvent>() : nullptr;
          }}},
        {});
}

RequestHead head_of(const std::string& text) {
    auto parsed = parse_head(text + "\r\n");
    EXPECT_EQ(parsed.status, 0) << text;
    return std::move(parsed.head);
}

/// As a connection does it.
HttpReply answer(const HttpRouter& routes, HttpRequest request) {
    if (auto refusal = routes.admit(request)) return *std::move(refusal);
    return routes.reply(std::move(request));
}

std::string get(const std::string& target, const std::string& more = "", const std::string& method = "GET") {
    return answer(router(),
                  {.head = head_of(method + " " + target + " HTTP/1.1\r\nhost: localhost\r\n" + more),
                   .peer = "10.0.0.5"})
        .bytes;
}

std::string body_of(const std::string& reply) {
    return reply.substr(reply.find("\r\n\r\n") + 4);
}

TEST(HttpRouter, GivesDecodedQueriesToHandlers) {
    const auto reply = get("/api/v1/echo?a=%D0%B4+b&lang=uk&token=x");
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 200 OK\r\n")) << reply;
    EXPECT_EQ(body_of(reply), "{\"a\":\"д b\",\"lang\":\"uk\",\"peer\":\"10.0.0.5\",\"language\":\"uk\"}\n");
}

TEST(HttpRouter, ChoosesTheLanguage) {
    EXPECT_NE(get("/api/v1/echo", "accept-language: ru-RU,en;q=0.5\r\n").find("\"ru\""), std::string::npos);
    EXPECT_NE(get("/api/v1/echo?lang=xx").find("\"en\""), std::string::npos);
}

TEST(HttpRouter, PutsItsFieldsIntoEveryAnswer) {
    for (const auto* target : {"/", "/api/v1/echo", "/api/v1/none", "/none"}) {
        const auto reply = get(target);
        for (const auto* field : {"Content-Security-Policy: default-src 'self'", "frame-ancestors 'none'",
                                  "X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer",
                                  "Cross-Origin-Opener-Policy: same-origin", "Cache-Control: no-"})
            EXPECT_NE(reply.find(field), std::string::npos) << target << ' ' << field;
    }
}

TEST(HttpRouter, AnswersWithTheStatusOfEachMistake) {
    EXPECT_TRUE(get("/api/v1/none").starts_with("HTTP/1.1 404 "));
    EXPECT_TRUE(get("/api/v2/echo").starts_with("HTTP/1.1 404 "));
    EXPECT_TRUE(get("/api").starts_with("HTTP/1.1 404 "));
    EXPECT_TRUE(get("/../etc/passwd").starts_with("HTTP/1.1 404 "));
    const std::string marked = "x-takt: 1\r\ncontent-type: application/json\r\n";
    EXPECT_TRUE(get("/api/v1/long", marked, "POST").starts_with("HTTP/1.1 405 "));
    EXPECT_TRUE(get("/api/v1/long", marked, "DELETE").starts_with("HTTP/1.1 405 "));
    EXPECT_TRUE(get("/api/v1/events", marked, "POST").starts_with("HTTP/1.1 405 "));
    EXPECT_TRUE(get("/", marked, "POST").starts_with("HTTP/1.1 405 "));
    EXPECT_NE(get("/api/v1/long", marked, "PUT").find("\r\nAllow: GET, HEAD\r\n"), std::string::npos);
    EXPECT_NE(get("/api/v1/echo", marked, "PUT").find("\r\nAllow: GET, HEAD, POST\r\n"), std::string::npos);
    EXPECT_NE(get("/api/v1/events", marked, "PUT").find("\r\nAllow: GET\r\n"), std::string::npos);
    EXPECT_TRUE(get("/api/v1/echo", "", "POST").starts_with("HTTP/1.1 403 "));
}

TEST(HttpRouter, HidesWhyAHandlerFailed) {
    const auto reply = get("/api/v1/fails");
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 500 "));
    EXPECT_EQ(reply.find("secret"), std::string::npos);
    EXPECT_NE(reply.find("\"internal\""), std::string::npos);
}

TEST(HttpRouter, HandsBodiesOverAndNamesDownloads) {
    const auto routes = router();
    const auto head = head_of(
        "POST /api/v1/echo HTTP/1.1\r\nhost: localhost\r\nx-takt: 1\r\ncontent-type: "
        "application/json\r\n");
    const auto reply = answer(routes, {.head = head, .body = "{}"}).bytes;
    EXPECT_EQ(body_of(reply), "{}");
    EXPECT_NE(reply.find("Content-Disposition: attachment; filename=\"a_b.csv\"\r\n"), std::string::npos);
    EXPECT_TRUE(answer(routes, {.head = head, .body = "\xFF"}).bytes.starts_with("HTTP/1.1 400 "));
}

TEST(HttpRouter, CompressesOnRequest) {
    EXPECT_GT(get("/api/v1/long").size(), 100'000u);
    const auto packed = get("/api/v1/long", "accept-encoding: br, gzip\r\n");
    EXPECT_LT(packed.size(), 5'000u);
    EXPECT_NE(packed.find("Content-Encoding: gzip"), std::string::npos);
    EXPECT_GT(get("/api/v1/long", "accept-encoding: br\r\n").size(), 100'000u);
    for (const auto* none : {"gzip;q=0", "gzip; q=0.0", "x-gzip", "notgzip", ""})
        EXPECT_GT(get("/api/v1/long", "accept-encoding: " + std::string(none) + "\r\n").size(), 100'000u)
            << none;
    for (const auto* some : {"GZIP", "br, gzip;q=0.5", "gzip ; q=1"})
        EXPECT_LT(get("/api/v1/long", "accept-encoding: " + std::string(some) + "\r\n").size(), 5'000u)
            << some;
}

TEST(HttpRouter, ServesThePage) {
    const auto* const page = find_page_file("/");
    ASSERT_TRUE(page);
    EXPECT_EQ(body_of(get("/")), page->plain);
    EXPECT_EQ(body_of(get("/", "accept-encoding: gzip\r\n")), page->gzip);
    const auto same = get("/", "if-none-match: " + std::string(page->etag) + "\r\n");
    EXPECT_TRUE(same.starts_with("HTTP/1.1 304 ")) << same;
    EXPECT_EQ(body_of(same), "");
    EXPECT_EQ(body_of(get("/", "", "HEAD")), "");
    const std::string etag(page->etag);
    for (const auto& tags : {"W/" + etag, "\"x\", " + etag, std::string("*")})
        EXPECT_TRUE(get("/", "if-none-match: " + tags + "\r\n").starts_with("HTTP/1.1 304 ")) << tags;
    EXPECT_TRUE(get("/", "if-none-match: \"x\"\r\n").starts_with("HTTP/1.1 200 "));
}

TEST(HttpRouter, OpensStreams) {
    const auto head = head_of("GET /api/v1/events HTTP/1.1\r\nhost: localhost\r\n");
    auto reply = answer(router(), {.head = head});
    ASSERT_TRUE(reply.stream);
    EXPECT_TRUE(reply.bytes.starts_with("HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n"));
    std::string events;
    EXPECT_FALSE(reply.stream->take(events));
    EXPECT_EQ(events, "event: hello\ndata: 1\n\n");
    reply = answer(router(false), {.head = head});
    EXPECT_FALSE(reply.stream);
    EXPECT_TRUE(reply.bytes.starts_with("HTTP/1.1 503 "));
}

TEST(HttpRouter, AdmitsByTheHead) {
    const auto routes = router();
    const auto admitted = [&](const std::string& start, const std::string& fields) {
        HttpRequest request{.head = head_of(start + " HTTP/1.1\r\nhost: localhost\r\n" + fields),
                            .peer = "10.0.0.5"};
        const auto refusal = routes.admit(request);
        return std::pair(refusal ? refusal->bytes : "", std::move(request));
    };
    const std::string body = "content-length: 2\r\n";
    const std::string marked = "x-takt: 1\r\ncontent-type: application/json\r\n" + body;
    const auto [none, change] = admitted("POST /api/v1/echo", marked);
    EXPECT_EQ(none, "");
    EXPECT_EQ(change.work, Work::device);
    EXPECT_EQ(change.superseded_by, "");
    EXPECT_FALSE(change.is_stream);
    const auto [refused, stranger] = admitted("POST /api/v1/echo", body);
    EXPECT_TRUE(refused.starts_with("HTTP/1.1 403 ")) << refused;
    EXPECT_NE(refused.find("Connection: close\r\n"), std::string::npos) << "its body is not received";
    EXPECT_EQ(stranger.visitor, change.visitor);
    EXPECT_TRUE(admitted("GET /api/v1/events", "").second.is_stream);
    const auto newest = admitted("GET /api/v1/newest?client=a", "").second;
    EXPECT_EQ(newest.work, Work::planning);
    EXPECT_EQ(newest.superseded_by, "10.0.0.5 a");
    EXPECT_EQ(admitted("GET /", "").first, "");
}

TEST(HttpRouter, FieldsOfANamedProxyCount) {
    const auto routes = router();
    const auto ask = [&](const char* peer, const std::string& fields) {
        HttpRequest request{
            .head = head_of("GET /api/v1/echo HTTP/1.1\r\nhost: plant.example.com\r\n" + fields),
            .peer = peer};
        const auto refusal = routes.admit(request);
        return std::pair(request.visitor, refusal ? refusal->bytes : routes.reply(request).bytes);
    };
    const std::string fields =
        "x-forwarded-for: 1.2.3.4, 192.0.2.7\r\nx-forwarded-proto: https\r\norigin: "
        "https://plant.example.com\r\n";
    const auto [client, answer] = ask("10.0.0.1", fields);
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 200 ")) << answer;
    EXPECT_NE(answer.find("\"peer\":\"192.0.2.7\""), std::string::npos) << answer;
    EXPECT_EQ(client, ask("192.0.2.7", "").first);
    const auto [other, refused] = ask("10.0.0.2", fields);
    EXPECT_TRUE(refused.starts_with("HTTP/1.1 403 ")) << refused;
    EXPECT_NE(other, client);
    EXPECT_TRUE(ask("10.0.0.1", "x-forwarded-host: evil.example\r\n").second.starts_with("HTTP/1.1 421 "));
}

TEST(HttpRouter, VisitorsWithTheTokenAreCountedApart) {
    const HttpRouter routes({.token = "0123456789abcdef"}, {}, text::Language::english, {}, {}, {});
    const auto visitor = [&](const std::string& fields) {
        HttpRequest request{.head = head_of("GET /api/v1/x HTTP/1.1\r\nhost: localhost\r\n" + fields),
                            .peer = "10.0.0.5"};
        static_cast<void>(routes.admit(request));
        return request.visitor;
    };
    EXPECT_NE(visitor("authorization: Bearer 0123456789abcdef\r\n"), visitor(""));
    EXPECT_EQ(visitor("authorization: Bearer wrong\r\n"), visitor(""));
}

TEST(HttpRouter, ClosesWhatAsksForIt) {
    const auto routes = router();
    const std::string head = "GET /api/v1/echo HTTP/1.1\r\nhost: localhost\r\n";
    EXPECT_FALSE(answer(routes, {.head = head_of(head)}).close);
    EXPECT_TRUE(answer(routes, {.head = head_of(head + "connection: close\r\n")}).close);
}

}  // namespace http_router_test
}  // namespace takt::web
