#include "takt/serve/tcp_connection.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "support.hpp"

namespace takt::serve {
namespace tcp_connection_test {

using namespace std::chrono_literals;

class Scripted final : public Responder {
public:
    [[nodiscard]] bool serves(UnitId) const override { return true; }
    [[nodiscard]] Answer handle(const Context& context, const wire::RequestView&) override {
        ++calls;
        peer = std::string(context.peer) + "/" + std::string(context.role);
        return next;
    }
    Answer next;
    int calls = 0;
    std::string peer;
};

/// One connection to unit 1, its time moved by the test. A driver that always can send.
class Rig {
public:
    explicit Rig(const TcpConfig& config = {}, Responder* responder = nullptr)
        : units{Unit{UnitId{1}, storage.banks(), nullptr}},
          server(units),
          connection(config, responder ? *responder : server) {
        connection.on_link(now, true);
    }

    /// Gives the bytes in chunks, never more than are wanted.
    void receive(const std::string& text, std::size_t chunk = 4096) {
        const auto data = bytes(text);
        for (std::size_t done = 0; done < data.size() && connection.wants_bytes() > 0;) {
            const std::size_t count = std::min({chunk, data.size() - done, connection.wants_bytes()});
            connection.on_bytes(now, Bytes(data).subspan(done, count));
            done += count;
            collect();
        }
    }
    std::string exchange(const std::string& text, std::size_t chunk = 4096) {
        sent.clear();
        receive(text, chunk);
        return sent;
    }
    void run(Duration length) {
        const Instant end = now + length;
        while (connection.next_wakeup() <= end) {
            now = std::max(now, connection.next_wakeup());
            connection.on_tick(now);
            collect();
        }
        now = end;
    }
    void collect() {
        for (Bytes out = connection.transmit(now); !out.empty(); out = connection.transmit(now)) {
            EXPECT_LE(out.size(), kTcpBuffer);
            if (!sent.empty()) sent += ' ';
            sent += hex(out);
        }
    }

    Storage storage;
    std::array<Unit, 1> units;
    Server server;
    TcpConnection connection;
    Instant now{};
    std::string sent;
};

TEST(TcpConnection, GoldenFrame) {
    Rig rig;
    rig.units[0].id = UnitId{17};
    rig.storage.holding[0x6B] = 555;
    rig.storage.holding[0x6C] = 100;
    rig.storage.holding[0x6D] = 127;
    for (std::size_t chunk = 1; chunk <= 12; ++chunk)
        EXPECT_EQ(rig.exchange("0001 0000 0006 11 03 006B 0003", chunk),
                  "00 01 00 00 00 09 11 03 06 02 2B 00 64 00 7F");
    EXPECT_EQ(rig.connection.counters().requests, 12u);
    EXPECT_EQ(rig.connection.counters().answers, 12u);
}

TEST(TcpConnection, EveryUnitIsAnswered) {
    Rig rig;
    EXPECT_EQ(rig.exchange(tcp(1, 0, "03 0005 0001")), tcp(1, 0, "03 02 0005"));
    EXPECT_EQ(rig.exchange(tcp(2, 255, "03 0005 0001")), tcp(2, 255, "03 02 0005"));
    EXPECT_EQ(rig.exchange(tcp(3, 0, "06 0005 1234")), tcp(3, 0, "06 0005 1234")) << "no broadcast over TCP";
    EXPECT_EQ(rig.exchange(tcp(4, 9, "03 0005 0001")), tcp(4, 9, "83 0A"));
}

// hostile-inputs 1-5, 15: closed within 8 bytes, no answer.
TEST(TcpConnection, ABadHeaderEndsTheConnection) {
    const char* openings[] = {
        "0001 0001 0006 01 03 0000 0001", "0001 0100 0006 01",       "0001 0000 0000 01",
        "0001 0000 0001 01 03",           "0001 0000 00FF 01 03",    "0001 0000 FFFF 01",
        "47 45 54 20 2F 20 48 54",        "16 03 01 02 00 01 00 01", "FF FF FF FF FF FF FF FF",
    };
    for (const char* opening : openings) {
        for (const std::size_t chunk : {1u, 64u}) {
            Rig rig;
            EXPECT_EQ(rig.exchange(std::string(opening).substr(0, 23), chunk), "") << opening;
            EXPECT_EQ(rig.connection.close_reason(), CloseReason::bad_header) << opening;
            EXPECT_EQ(rig.connection.wants_bytes(), 0u);
            EXPECT_EQ(rig.connection.next_wakeup(), kNever);
            EXPECT_EQ(rig.connection.counters().of(wire::FrameFault::bad_header), 1u);
            rig.connection.on_bytes(rig.now, bytes(tcp(1, 1, "03 0000 0001")));
            rig.collect();
            EXPECT_EQ(rig.sent, "") << "after " << opening;
        }
    }
}

TEST(TcpConnection, WhatCameBeforeABadHeaderIsStillAnswered) {
    Rig rig;
    EXPECT_EQ(rig.exchange(tcp(1, 1, "03 0001 0001") + "0002 4444 0006 01 03 0000 0001"),
              tcp(1, 1, "03 02 0001"));
    EXPECT_EQ(rig.connection.close_reason(), CloseReason::bad_header);
}

// 6, 7
TEST(TcpConnection, WrongLengthsAreExceptionThree) {
    Rig rig;
    EXPECT_EQ(rig.exchange("0007 0000 000B 01 03 0000 0001 06 0001 0003"), tcp(7, 1, "83 03"));
    EXPECT_EQ(rig.storage.holding[1], 1);
    EXPECT_EQ(rig.exchange("0008 0000 0004 01 03 0000"), tcp(8, 1, "83 03"));
    EXPECT_EQ(rig.exchange("0009 0000 0002 01 10"), tcp(9, 1, "90 03"));
    EXPECT_EQ(rig.exchange(tcp(10, 1, "03 0001 0001")), tcp(10, 1, "03 02 0001"));
    EXPECT_EQ(rig.connection.close_reason(), CloseReason::none);
}

// 12: in order, however the bytes are split into segments.
TEST(TcpConnection, FiftyRequestsInOneSegment) {
    std::string requests, answers;
    for (std::uint16_t i = 0; i < 50; ++i) {
        const std::string address = hex(std::array{std::uint8_t{0}, static_cast<std::uint8_t>(i)});
        requests += tcp(i, 1, "03 " + address + "0001") + " ";
        answers += (i ? " " : "") + tcp(i, 1, "03 02 " + address);
    }
    for (const std::size_t chunk : {1u, 7u, 100u, 600u}) {
        Rig rig;
        EXPECT_EQ(rig.exchange(requests, chunk), answers) << chunk;
    }
}

TEST(TcpConnection, HoldsTheReaderBackWhileAnswersPileUp) {
    Rig rig;
    const auto request = bytes(tcp(1, 1, "03 0000 007D"));
    std::size_t given = 0;
    while (rig.connection.wants_bytes() >= request.size() && given < 10'000) {
        rig.connection.on_bytes(rig.now, request);
        ++given;
    }
    EXPECT_LE(given, 16u + kTcpBuffer / request.size()) << "the driver has sent nothing";
    rig.collect();
    EXPECT_EQ(bytes(rig.sent).size(), given * 259) << "and none is lost";
    EXPECT_EQ(rig.connection.wants_bytes(), kTcpBuffer);
    EXPECT_EQ(rig.connection.close_reason(), CloseReason::none);
}

TEST(TcpConnection, SmallBuffersAreEnough) {
    Storage storage;
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    Server server(units);
    BufferedTcpConnection<12, wire::kMaxAsciiFrame> connection({}, server);
    connection.on_link({}, true);
    const auto requests =
        bytes(tcp(1, 1, "03 0000 007D") + tcp(2, 1, "03 0001 0001") + tcp(3, 1, "03 0002 0001"));
    std::string sent;
    for (Bytes rest = requests; !rest.empty();) {
        const std::size_t size = std::min(connection.wants_bytes(), rest.size());
        ASSERT_GT(size, 0u);
        connection.on_bytes({}, rest.first(size));
        rest = rest.subspan(size);
        for (Bytes out = connection.transmit({}); !out.empty(); out = connection.transmit({}))
            sent += hex(out);
    }
    EXPECT_EQ(bytes(sent).size(), 259u + 2 * 11);
    EXPECT_EQ(connection.counters().answers, 3u);
}

TEST(TcpConnection, MoreThanWantedEndsIt) {
    Rig rig;
    const std::vector<std::uint8_t> flood(kTcpBuffer + 1);
    rig.connection.on_bytes(rig.now, flood);
    EXPECT_EQ(rig.connection.close_reason(), CloseReason::too_much);
}

// 8, 9, 13
TEST(TcpConnection, Deadlines) {
    TcpConfig config;
    config.frame_deadline = 2s;
    config.idle_deadline = 30s;
    {
        Rig rig(config);
        const auto request = bytes(tcp(1, 1, "03 0000 0001"));
        for (int i = 0; i < 5; ++i) {
            EXPECT_EQ(rig.connection.close_reason(), CloseReason::none) << i;
            rig.connection.on_bytes(rig.now, Bytes(request).subspan(static_cast<std::size_t>(i), 1));
            rig.run(400ms);
        }
        EXPECT_EQ(rig.connection.close_reason(), CloseReason::frame_deadline) << "one byte every 400 ms";
    }
    {
        Rig rig(config);
        rig.receive("0001 0000");
        rig.run(1999ms);
        EXPECT_EQ(rig.connection.close_reason(), CloseReason::none);
        rig.run(1ms);
        EXPECT_EQ(rig.connection.close_reason(), CloseReason::frame_deadline) << "half a header";
    }
    {
        Rig rig(config);
        rig.run(29s);
        EXPECT_EQ(rig.exchange(tcp(1, 1, "03 0001 0001")), tcp(1, 1, "03 02 0001"));
        rig.run(29s);
        EXPECT_EQ(rig.connection.close_reason(), CloseReason::none)
            << "a frame begun after the last is a new one";
        rig.run(1s);
        EXPECT_EQ(rig.connection.close_reason(), CloseReason::idle_deadline);
    }
    {
        config.frame_deadline = config.idle_deadline = {};
        Rig rig(config);
        rig.receive("0001 0000");
        EXPECT_EQ(rig.connection.next_wakeup(), kNever);
    }
}

TEST(TcpConnection, LateAnswersKeepTheOrder) {
    Scripted scripted;
    TcpConfig config;
    config.peer = "[::1]:5000";
    config.role = "viewer";
    Rig rig(config, &scripted);
    const auto answer = bytes("03 02 0042");

    scripted.next = Answer::pending(3);
    rig.receive(tcp(1, 1, "03 0000 0001") + tcp(2, 1, "03 0000 0001"));
    EXPECT_EQ(scripted.calls, 1) << "the second waits";
    EXPECT_EQ(scripted.peer, "[::1]:5000/viewer");
    rig.run(10s);
    EXPECT_EQ(rig.connection.close_reason(), CloseReason::none) << "it is not the peer that is slow";
    EXPECT_FALSE(rig.connection.complete(rig.now, 4, answer));
    scripted.next = Answer::response({0x03, 0x02, 0x00, 0x43}, 5ms);
    EXPECT_TRUE(rig.connection.complete(rig.now, 3, answer));
    rig.collect();
    EXPECT_EQ(rig.sent, tcp(1, 1, "03 02 0042"));
    EXPECT_EQ(scripted.calls, 2);
    rig.sent.clear();
    rig.run(4999us);
    EXPECT_EQ(rig.sent, "");
    rig.run(1us);
    EXPECT_EQ(rig.sent, tcp(2, 1, "03 02 0043"));
    scripted.next = {};
    EXPECT_EQ(rig.exchange(tcp(3, 1, "03 0000 0001")), "");
    EXPECT_EQ(rig.connection.counters().unanswered, 1u);
}

TEST(TcpConnection, ANewLinkStartsAfresh) {
    Scripted scripted;
    scripted.next = Answer::pending(1);
    Rig rig({}, &scripted);
    rig.receive(tcp(1, 1, "03 0000 0001") + "00 02 00");
    rig.connection.on_link(rig.now, false);
    EXPECT_EQ(rig.connection.wants_bytes(), 0u);
    EXPECT_EQ(rig.connection.next_wakeup(), kNever);
    rig.connection.on_link(rig.now, true);
    EXPECT_FALSE(rig.connection.complete(rig.now, 1, bytes("03 02 0042")));
    scripted.next = Answer::response({0x03, 0x02, 0x00, 0x43});
    EXPECT_EQ(rig.exchange(tcp(9, 1, "03 0000 0001")), tcp(9, 1, "03 02 0043"));
}

TEST(TcpConnection, RtuOverTheStream) {
    TcpConfig config;
    config.framing = wire::Framing::rtu;
    Rig rig(config);
    const std::string request = rtu(1, "03 0001 0001"), answer = rtu(1, "03 02 0001");
    EXPECT_EQ(rig.exchange(request, 1), answer);
    EXPECT_EQ(rig.exchange(request + " " + request), answer + " " + answer) << "no silences in a stream";
    EXPECT_EQ(rig.exchange(rtu(0, "03 0001 0001")), rtu(0, "03 02 0001")) << "unit 0 is the server itself";
    EXPECT_EQ(rig.exchange("01 03 00 01 00 01 00 00"), "");
    rig.run(1s);
    EXPECT_EQ(rig.exchange(request), answer) << "after a bad checksum and a pause";
    EXPECT_EQ(rig.connection.counters().of(wire::FrameFault::checksum), 1u);
}

/// One set of buffers, overwritten when it is released.
class SharedBuffers final : public TcpBufferPool {
public:
    TcpBuffers& acquire() override {
        EXPECT_FALSE(lent) << "it has one user";
        lent = true;
        return buffers;
    }
    void release(TcpBuffers& given) override {
        EXPECT_EQ(&given, &buffers);
        lent = false;
        std::ranges::fill(buffers.input, 0xA5);
        std::ranges::fill(buffers.output, 0x5A);
    }
    StoredTcpBuffers<> buffers;
    bool lent = false;
};

struct Lodger {
    Lodger(Server& server, SharedBuffers& shared) : connection({}, server, shared, framer_storage) {
        connection.on_link({}, true);
    }
    std::string exchange(const std::string& text) {
        connection.on_bytes({}, bytes(text));
        const std::string sent = hex(connection.transmit({}));
        EXPECT_TRUE(connection.transmit({}).empty());
        return sent;
    }
    std::array<std::uint8_t, wire::kMaxTcpFrame> framer_storage{};
    TcpConnectionCore connection;
};

TEST(TcpConnection, HasARoomOnlyWhileItIsBusy) {
    Storage storage;
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    Server server(units);
    SharedBuffers shared;
    Lodger one(server, shared);
    Lodger other(server, shared);
    for (std::uint16_t i = 0; i < 3; ++i) {
        EXPECT_EQ(one.exchange(tcp(1, 1, "03 0001 0001") + "00 02 00"), tcp(1, 1, "03 02 0001"));
        EXPECT_FALSE(shared.lent) << "half a frame needs none";
        EXPECT_EQ(other.exchange(tcp(7, 1, "03 0002 0001")), tcp(7, 1, "03 02 0002"));
        EXPECT_EQ(one.exchange("00 00 06 01 03 00 03 00 01"), tcp(2, 1, "03 02 0003"));
    }
    one.connection.on_bytes({}, bytes(tcp(1, 1, "03 0001 0001")));
    EXPECT_TRUE(shared.lent) << "an answer waits";
    one.connection.on_link({}, false);
    EXPECT_FALSE(shared.lent) << "it is lost with the link";
    {
        Lodger third(server, shared);
        third.connection.on_bytes({}, bytes(tcp(1, 1, "03 0001 0001")));
    }
    EXPECT_FALSE(shared.lent) << "given back at the end";
}

// 26 and fuzz: two connections share nothing but the units.
RC_GTEST_PROP(TcpConnection, AnyBytesInAnyChunksAreBoundedAndNeverCrossTalk, ()) {
    Rig noisy, quiet;
    const auto data = *rc::gen::container<std::vector<std::uint8_t>>(
        rc::gen::weightedOneOf<std::uint8_t>({{3, rc::gen::element<std::uint8_t>(0, 0, 0, 1, 3, 6, 16)},
                                              {1, rc::gen::arbitrary<std::uint8_t>()}}));
    noisy.receive(tcp(1, 1, "03 0001 0001").substr(0, 20) + hex(data), *rc::gen::inRange<std::size_t>(1, 40));
    RC_ASSERT(quiet.exchange(tcp(1, 1, "03 0002 0001")) == tcp(1, 1, "03 02 0002"));
    noisy.run(11min);
    RC_ASSERT(noisy.connection.close_reason() != CloseReason::none);
}

}  // namespace tcp_connection_test
}  // namespace takt::serve
