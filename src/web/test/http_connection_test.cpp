#include "http/http_connection.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

namespace takt::web {
namespace http_connection_test {

using namespace std::chrono_literals;

/// A connection without a socket.
struct Rig {
    Instant t{1s};
    std::vector<HttpRequest> requests;
    int refuse = 0;  ///< status
    std::ptrdiff_t held = 0;
    std::ptrdiff_t most_held = 32 << 20;
    std::string not_admitted;  ///< the answer to heads; empty: they are admitted
    int gone = 0;              ///< calls of input_ended
    bool destroyed = false;
    std::unique_ptr<HttpConnection> connection = std::make_unique<HttpConnection>(
        HttpConnection::Limits{}, "10.0.0.5:49152", t,
        HttpConnection::Owner{.admit =
                                  [this](HttpRequest& request) {
                                      request.visitor = "visitor";
                                      return not_admitted.empty()
                                                 ? std::nullopt
                                                 : std::optional(HttpReply{.bytes = not_admitted});
                                  },
                              .execute =
                                  [this](HttpRequest request) {
                                      if (refuse == 0) requests.push_back(std::move(request));
                                      return refuse;
                                  },
                              .reserve =
                                  [this](std::string_view visitor, std::ptrdiff_t change) {
                                      held += change;
                                      EXPECT_TRUE(change == 0 || visitor == "visitor");
                                      return held <= most_held ? 0 : 429;
                                  },
                              .input_ended = [this] { ++gone; },
                              .destroyed = [this] { destroyed = true; }});

    Rig() { engine().on_link(t, true); }
    Engine& engine() { return connection->engine(); }

    void receive(std::string_view text) {
        engine().on_bytes(t, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    }
    std::string sent() {
        std::string all;
        for (auto bytes = engine().transmit(t); !bytes.empty(); bytes = engine().transmit(t))
            all.append(bytes.begin(), bytes.end());
        return all;
    }
    void wait(Duration time) {
        t += time;
        if (engine().next_wakeup() <= t) engine().on_tick(t);
    }
    void answer(std::string bytes, bool close = false) {
        connection->answer({.bytes = std::move(bytes), .close = close});
    }
};

const std::string kGet = "GET / HTTP/1.1\r\nHost: a\r\n\r\n";

TEST(HttpConnection, ExecutesOneRequestAfterTheOther) {
    Rig rig;
    rig.receive(kGet + kGet);
    ASSERT_EQ(rig.requests.size(), 1u);
    EXPECT_EQ(rig.requests[0].head.path, "/");
    EXPECT_EQ(rig.requests[0].head.field("host"), "a");
    EXPECT_EQ(rig.requests[0].peer, "10.0.0.5");
    EXPECT_LE(rig.connection->wants_bytes(), 16u << 10);
    EXPECT_FALSE(rig.connection->drained());
    rig.answer("first");
    EXPECT_EQ(rig.sent(), "first");
    ASSERT_EQ(rig.requests.size(), 2u);
    rig.answer("second");
    EXPECT_EQ(rig.sent(), "second");
    EXPECT_TRUE(rig.connection->drained());
    EXPECT_GT(rig.connection->wants_bytes(), 0u);
    EXPECT_EQ(rig.held, 0);
}

TEST(HttpConnection, TakesRequestsByteByByte) {
    Rig rig;
    for (const char c : "POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc") {
        if (c == '\0') break;
        EXPECT_TRUE(rig.requests.empty());
        rig.receive({&c, 1});
    }
    ASSERT_EQ(rig.requests.size(), 1u);
    EXPECT_EQ(rig.requests[0].body, "abc");
}

TEST(HttpConnection, AsksForABodyThatWaits) {
    Rig rig;
    rig.receive("POST / HTTP/1.1\r\nContent-Length: 3\r\nExpect: 100-continue\r\n\r\n");
    EXPECT_EQ(rig.sent(), "HTTP/1.1 100 Continue\r\n\r\n");
    rig.receive("abc");
    ASSERT_EQ(rig.requests.size(), 1u);
    rig.answer("done");
    EXPECT_EQ(rig.sent(), "done");
}

TEST(HttpConnection, ClosesAfterARejectedRequestNotAtOnce) {
    Rig rig;
    rig.receive("nonsense\r\n\r\n");
    EXPECT_TRUE(rig.sent().starts_with("HTTP/1.1 400 "));
    EXPECT_FALSE(rig.connection->finished());
    rig.receive(std::string(100'000, 'x'));
    EXPECT_EQ(rig.sent(), "");
    rig.wait(1s);
    EXPECT_TRUE(rig.connection->finished());
}

TEST(HttpConnection, EndsItsSideRightBehindTheLastAnswer) {
    Rig rig;
    rig.receive("GET / HTTP/1.0\r\nHost: a\r\n\r\n");
    EXPECT_FALSE(rig.connection->output_ended());
    rig.answer("last", true);
    EXPECT_EQ(rig.sent(), "last");
    EXPECT_TRUE(rig.connection->output_ended());
    EXPECT_FALSE(rig.connection->finished());
}

TEST(HttpConnection, TakesAnEmptyLineBeforeARequest) {
    Rig rig;
    for (const char c : "\r\n" + kGet) rig.receive({&c, 1});
    ASSERT_EQ(rig.requests.size(), 1u);
    rig.answer("done");
    EXPECT_EQ(rig.sent(), "done");
    rig.receive("\r\n\r\n" + kGet);
    EXPECT_EQ(rig.requests.size(), 2u);
}

TEST(HttpConnection, LimitsTheTimeOfARequest) {
    Rig rig;
    for (int i = 0; i < 9; ++i) {
        rig.receive("G");
        rig.wait(1s);
        EXPECT_EQ(rig.sent(), "");
    }
    rig.wait(1s);
    EXPECT_TRUE(rig.sent().starts_with("HTTP/1.1 408 "));
}

TEST(HttpConnection, GivesLongBodiesMoreTime) {
    Rig rig;
    rig.receive("POST / HTTP/1.1\r\nContent-Length: 1000000\r\n\r\n");
    rig.wait(30s);
    EXPECT_EQ(rig.sent(), "");
    rig.wait(31s);
    EXPECT_TRUE(rig.sent().starts_with("HTTP/1.1 408 "));
    EXPECT_EQ(rig.held, 0);
}

TEST(HttpConnection, ClosesWhenIdle) {
    Rig rig;
    rig.wait(19s);
    EXPECT_FALSE(rig.connection->finished());
    rig.wait(1s);
    EXPECT_TRUE(rig.connection->finished());
    EXPECT_EQ(rig.sent(), "");
}

TEST(HttpConnection, WaitsForSlowHandlersWithoutLimit) {
    Rig rig;
    rig.receive(kGet);
    rig.wait(1h);
    EXPECT_FALSE(rig.connection->finished());
    rig.answer("late");
    EXPECT_EQ(rig.sent(), "late");
}

TEST(HttpConnection, RejectsWhatTheServerCannotExecute) {
    Rig rig;
    rig.refuse = 503;
    rig.receive(kGet);
    const auto reply = rig.sent();
    EXPECT_TRUE(reply.starts_with("HTTP/1.1 503 "));
    EXPECT_NE(reply.find("Retry-After: 1\r\n"), std::string::npos);
}

TEST(HttpConnection, CountsBodiesAsTheyAreReceived) {
    Rig rig;
    rig.most_held = 1000;
    rig.receive("POST / HTTP/1.1\r\nContent-Length: 1001\r\n\r\n");
    EXPECT_EQ(rig.held, 0);
    rig.receive(std::string(1000, 'x'));
    EXPECT_EQ(rig.held, 1000);
    EXPECT_EQ(rig.sent(), "");
    rig.receive("x");
    EXPECT_TRUE(rig.sent().starts_with("HTTP/1.1 429 "));
    EXPECT_EQ(rig.held, 0);
}

TEST(HttpConnection, ReceivesNoBodyThatIsNotAdmitted) {
    Rig rig;
    rig.not_admitted = "HTTP/1.1 401 ";
    rig.receive("POST / HTTP/1.1\r\nContent-Length: 16000000\r\n\r\n");
    EXPECT_EQ(rig.sent(), "HTTP/1.1 401 ");
    rig.receive(std::string(100'000, 'x'));
    EXPECT_EQ(rig.held, 0);
    rig.wait(1s);
    EXPECT_TRUE(rig.connection->finished());
    EXPECT_TRUE(rig.requests.empty());
}

TEST(HttpConnection, GoesOnAfterARequestWithoutABodyThatIsNotAdmitted) {
    Rig rig;
    rig.not_admitted = "HTTP/1.1 401 ";
    rig.receive(kGet);
    EXPECT_EQ(rig.sent(), "HTTP/1.1 401 ");
    rig.not_admitted.clear();
    rig.receive(kGet);
    EXPECT_EQ(rig.requests.size(), 1u);
}

TEST(HttpConnection, ReportsThatItsClientHasGone) {
    Rig rig;
    rig.connection->on_input_end();
    EXPECT_EQ(rig.gone, 0) << "no request is executed";
    rig.receive(kGet);
    rig.connection->on_input_end();
    EXPECT_EQ(rig.gone, 1);
    rig.answer("still sent");
    EXPECT_EQ(rig.sent(), "still sent");
}

TEST(HttpConnection, ReadsLittleBehindARequestThatIsExecuted) {
    Rig rig;
    rig.receive(kGet);
    const auto most = rig.connection->wants_bytes();
    EXPECT_GT(most, 0u) << "the end of the connection is noticed";
    rig.receive(std::string(most, 'x'));
    EXPECT_EQ(rig.connection->wants_bytes(), 0u);
}

TEST(HttpConnection, LimitsEndlessHeads) {
    Rig rig;
    rig.receive("GET / HTTP/1.1\r\n");
    for (int i = 0; i < 5; ++i) rig.receive("A: " + std::string(4000, 'x'));
    EXPECT_TRUE(rig.sent().starts_with("HTTP/1.1 431 "));
}

TEST(HttpConnection, GivesItsMemoryBack) {
    Rig rig;
    rig.receive(kGet);
    rig.answer(std::string(1'000'000, 'x'));
    EXPECT_EQ(rig.held, 1'000'000);
    rig.connection.reset();
    EXPECT_EQ(rig.held, 0);
    EXPECT_TRUE(rig.destroyed);
}

class Numbers final : public StreamSource {
public:
    bool take(std::string& out) override {
        if (next == 3) return false;
        if (ready) out += "data: " + std::to_string(next++) + "\n\n";
        ready = false;
        return true;
    }
    int next = 0;
    bool ready = true;
};

TEST(HttpConnection, StreamsUntilTheSourceEnds) {
    Rig rig;
    auto source = std::make_unique<Numbers>();
    auto* const numbers = source.get();
    rig.receive(kGet);
    rig.connection->answer({.bytes = "head ", .stream = std::move(source)});
    EXPECT_TRUE(rig.connection->streams());
    EXPECT_EQ(rig.sent(), "head data: 0\n\n");
    EXPECT_TRUE(rig.connection->drained());  // the end of the browser's side ends it
    rig.receive("ignored");
    numbers->ready = true;
    EXPECT_EQ(rig.sent(), "data: 1\n\n");
    rig.wait(1h);
    EXPECT_FALSE(rig.connection->finished());
    numbers->next = 3;
    EXPECT_EQ(rig.sent(), "");
    EXPECT_FALSE(rig.connection->streams());
    rig.wait(1s);
    EXPECT_TRUE(rig.connection->finished());
    EXPECT_EQ(rig.held, 0);
}

TEST(HttpConnection, SplitsLongAnswers) {
    Rig rig;
    rig.receive(kGet);
    rig.answer(std::string(200'000, 'x'));
    EXPECT_EQ(rig.engine().transmit(rig.t).size(), std::size_t{64} << 10);
    EXPECT_EQ(rig.sent().size(), 200'000 - (std::size_t{64} << 10));
}

}  // namespace http_connection_test
}  // namespace takt::web
