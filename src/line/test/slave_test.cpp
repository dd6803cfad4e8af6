// The slave engines of serve on real and simulated lines.
#include <gtest/gtest.h>

#include "support.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/serial_answers.hpp"
#include "takt/line/slave_session.hpp"
#include "takt/line/target.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::line {
namespace slave_test {

std::string bytes(std::initializer_list<int> values) {
    return {values.begin(), values.end()};
}

// docs/specification.md, section 8: two input registers of unit 1; with the blank device's ramp registers 2
// and 3 hold 2 and 3.
const std::string kRtuRequest = bytes({0x01, 0x04, 0x00, 0x02, 0x00, 0x02, 0xD0, 0x0B});
const std::string kRtuResponse = bytes({0x01, 0x04, 0x04, 0x00, 0x02, 0x00, 0x03, 0x1A, 0x45});
const std::string kTcpRequest = bytes({0, 7, 0, 0, 0, 6, 0x01, 0x04, 0x00, 0x02, 0x00, 0x02});
const std::string kTcpResponse = bytes({0, 7, 0, 0, 0, 7, 0x01, 0x04, 0x04, 0x00, 0x02, 0x00, 0x03});

TEST(Slave, AnswersOnASerialPort) {
    const auto loop = make_loop();
    const Pty pty;
    sim::Devices devices(UnitId{1}, sim::Fill::ramp);
    serve::SerialConfig config;
    config.format = {115200, 8, wire::Parity::even, 1};
    serve::SerialSlave slave(config, devices);
    const auto target = parse_target("rtu://" + pty.path + "?baud=115200").value();
    const auto driver = open_line(*loop, target.as_line(), slave);
    ASSERT_TRUE(driver);
    ASSERT_TRUE(loop->run_until([&] { return (*driver)->up(); }, kDeadline));
    pty.write(kRtuRequest);
    EXPECT_EQ(read_until(*loop, pty, kRtuResponse.size()), kRtuResponse);
}

struct TcpSlave {
    explicit TcpSlave(Loop& loop) {
        const auto factory = [this](Instant, const Peer&) {
            return std::make_unique<SlaveSession>(serve::TcpConfig{}, devices, sessions);
        };
        server = std::move(TcpServer::listen(loop, {"127.0.0.1", 0}, factory)).value();
    }
    sim::Devices devices{UnitId{1}, sim::Fill::ramp};
    SlaveSessions sessions;
    std::unique_ptr<TcpServer> server;
};

TEST(Slave, AnswersOnTcpHoweverManyRequestsComeAtOnce) {
    constexpr int kRequests = 2000;  // more than the engine and the kernel hold
    const auto loop = make_loop();
    const TcpSlave slave(*loop);
    ScriptEngine client;
    std::string requests;
    std::string responses;
    for (int i = 0; i < kRequests; ++i) {
        requests += kTcpRequest;
        responses += kTcpResponse;
    }
    client.output = {requests};
    const auto driver = connect_tcp(*loop, "127.0.0.1", slave.server->port(), client);
    EXPECT_TRUE(loop->run_until([&] { return client.input.size() >= responses.size(); }, kDeadline));
    EXPECT_EQ(client.input, responses);
}

TEST(Slave, ClosesAConnectionThatSpeaksSomethingElse) {
    const auto loop = make_loop();
    const TcpSlave slave(*loop);
    ScriptEngine client;
    client.output = {"GET / HTTP/1.1\r\n\r\n"};
    std::optional<Error> why;
    DriverOptions options;
    options.on_link = [&](Instant, bool up, const std::optional<Error>& error) {
        if (!up) why = error;
    };
    const auto driver = connect_tcp(*loop, "127.0.0.1", slave.server->port(), client, options);
    ASSERT_TRUE(loop->run_until([&] { return why.has_value(); }, kDeadline));
    EXPECT_EQ(why->code, Code::connection_lost);
    EXPECT_EQ(client.input, "");
    EXPECT_TRUE(loop->run_until([&] { return slave.server->connections() == 0; }, kDeadline));
    EXPECT_EQ(slave.sessions.closed(serve::CloseReason::bad_header), 1u);
    EXPECT_EQ(slave.sessions.counters().of(wire::FrameFault::bad_header), 1u);
}

TEST(Driver, ReconnectsWhenItsEngineIsOutOfStep) {
    const auto loop = make_loop();
    const TcpSlave slave(*loop);
    ScriptEngine client;
    client.output = {kTcpRequest};
    DriverOptions options;
    options.must_reconnect = [&] { return client.links.size() == 1 && !client.input.empty(); };
    const auto driver = connect_tcp(*loop, "127.0.0.1", slave.server->port(), client, options);
    EXPECT_TRUE(loop->run_until([&] { return client.links.size() == 3; }, kDeadline));
    EXPECT_EQ(client.links, (std::vector{true, false, true}));
}

// A peer that is not Modbus does not end the back-off by its bytes.
TEST(Driver, NamesAPeerThatIsNotModbusAndAsksItLessAndLessOften) {
    const auto loop = make_loop();
    const TcpSlave slave(*loop);
    ScriptEngine client;
    std::optional<Error> why;
    DriverOptions options;
    client.reason = fail(Code::not_modbus, 0x0007'0000'0007'0104, 8).error();
    options.must_reconnect = [&] { return client.up() && !client.input.empty(); };
    options.on_link = [&](Instant, bool up, const std::optional<Error>& error) {
        client.input.clear();
        client.output = {kTcpRequest};
        if (!up) why = error;
    };
    const auto driver = connect_tcp(*loop, "127.0.0.1", slave.server->port(), client, options);
    ASSERT_TRUE(loop->run_until([&] { return why.has_value(); }, kDeadline));
    const Instant first = now();
    EXPECT_EQ(why->code, Code::not_modbus);
    EXPECT_EQ(why->subject.view(), driver->name());
    EXPECT_EQ(why->numbers[0], 0x0007'0000'0007'0104);
    EXPECT_EQ(why->numbers[1], 8);
    ASSERT_TRUE(loop->run_until([&] { return client.links.size() == 6; }, kDeadline));
    EXPECT_GE(now() - first, (250ms + 500ms) * 3 / 4);
}

TEST(Driver, NamesAPeerThatSendsNothing) {
    const auto loop = make_loop();
    const TcpSlave slave(*loop);
    ScriptEngine client;
    std::optional<Error> why;
    DriverOptions options;
    options.must_reconnect = [&] { return client.up(); };
    options.on_link = [&](Instant, bool, const std::optional<Error>& error) { why = error; };
    const auto driver = connect_tcp(*loop, "127.0.0.1", slave.server->port(), client, options);
    ASSERT_TRUE(loop->run_until([&] { return why.has_value(); }, kDeadline));
    EXPECT_EQ(why->code, Code::timed_out);
    EXPECT_EQ(why->subject.view(), driver->name());
}

/// Answers reads at once with their own bytes, and writes on request of the test.
struct SlowWriter final : serve::Responder {
    [[nodiscard]] bool serves(UnitId unit) const override { return unit == UnitId{1}; }
    [[nodiscard]] serve::Answer handle(const serve::Context&, const wire::RequestView& request) override {
        wire::Pdu same;
        same.assign(request.pdu());
        if (request.pdu()[0] != 6) return serve::Answer::response(same);
        written.push_back(same);
        return serve::Answer::pending(static_cast<serve::Token>(written.size()));
    }
    std::vector<wire::Pdu> written;
};

std::string tcp_frame(int transaction, std::initializer_list<int> pdu) {
    const int length = static_cast<int>(pdu.size()) + 1;
    return bytes({0, transaction, 0, 0, 0, length, 1}) + bytes(pdu);
}

TEST(PendingAnswers, HoldUpTheirOwnConnectionAlone) {
    const auto loop = make_loop();
    SlowWriter slow;
    SlaveSessions sessions;
    const auto server = std::move(TcpServer::listen(*loop, {"127.0.0.1", 0}, [&](Instant, const Peer&) {
                            return std::make_unique<SlaveSession>(serve::TcpConfig{}, slow, sessions);
                        })).value();
    const std::string write = tcp_frame(1, {6, 0, 9, 0, 1});
    const std::string read = tcp_frame(2, {3, 0, 0, 0, 1});
    ScriptEngine writer;
    writer.output = {write + read};
    const auto writing = connect_tcp(*loop, "127.0.0.1", server->port(), writer);
    ASSERT_TRUE(loop->run_until([&] { return slow.written.size() == 1; }, kDeadline));
    ScriptEngine other;
    other.output = {read};
    const auto reading = connect_tcp(*loop, "127.0.0.1", server->port(), other);
    ASSERT_TRUE(loop->run_until([&] { return other.input == read; }, kDeadline));
    EXPECT_EQ(writer.input, "");
    EXPECT_FALSE(sessions.complete(7, slow.written[0].span()));
    EXPECT_TRUE(sessions.complete(1, slow.written[0].span()));
    EXPECT_FALSE(sessions.complete(1, slow.written[0].span()));
    ASSERT_TRUE(
        loop->run_until([&] { return writer.input.size() == write.size() + read.size(); }, kDeadline));
    EXPECT_EQ(writer.input, write + read);
    writer.output = {write};
    writing->poke();
    ASSERT_TRUE(loop->run_until([&] { return slow.written.size() == 2; }, kDeadline));
    EXPECT_TRUE(sessions.complete(2, slow.written[1].span()));
    EXPECT_TRUE(loop->run_until([&] { return writer.input == write + read + write; }, kDeadline));
}

TEST(PendingAnswers, AreSentToAPeerThatClosedItsSideBeforeTheConnectionEnds) {
    const auto loop = make_loop();
    SlowWriter slow;
    SlaveSessions sessions;
    const auto server = std::move(TcpServer::listen(*loop, {"127.0.0.1", 0}, [&](Instant, const Peer&) {
                            return std::make_unique<SlaveSession>(serve::TcpConfig{}, slow, sessions);
                        })).value();
    ScriptEngine writer;
    writer.output = {tcp_frame(1, {6, 0, 9, 0, 1})};
    auto writing = connect_tcp(*loop, "127.0.0.1", server->port(), writer);
    ASSERT_TRUE(loop->run_until([&] { return slow.written.size() == 1; }, kDeadline));
    writing.reset();
    loop->run_until([] { return false; }, 20ms);
    EXPECT_EQ(server->connections(), 1u);
    EXPECT_TRUE(sessions.complete(1, slow.written[0].span()));
    EXPECT_TRUE(loop->run_until([&] { return server->connections() == 0; }, kDeadline));
    EXPECT_FALSE(sessions.complete(1, slow.written[0].span()));
}

TEST(PendingAnswers, ComeOnASerialPortToo) {
    const auto loop = make_loop();
    const Pty pty;
    SlowWriter slow;
    serve::SerialConfig config;
    config.format = {115200, 8, wire::Parity::even, 1};
    serve::SerialSlave slave(config, slow);
    const auto target = parse_target("rtu://" + pty.path + "?baud=115200").value();
    const auto driver = open_line(*loop, target.as_line(), slave);
    ASSERT_TRUE(driver);
    SerialAnswers answers(slave, **driver);
    ASSERT_TRUE(loop->run_until([&] { return (*driver)->up(); }, kDeadline));
    const std::string write = bytes({0x01, 0x06, 0x00, 0x09, 0x00, 0x01, 0x98, 0x08});
    pty.write(write);
    ASSERT_TRUE(loop->run_until([&] { return slow.written.size() == 1; }, kDeadline));
    EXPECT_TRUE(answers.complete(1, slow.written[0].span()));
    EXPECT_EQ(read_until(*loop, pty, write.size()), write);
}

model::Line simulated(wire::Framing framing) {
    model::Variable variable;
    variable.name = "Level";
    variable.area = wire::Area::input_register;
    variable.read = wire::Function::read_input_registers;
    model::Device device;
    device.name = "Tank";
    device.variables = {variable};
    model::Line line;
    line.name = "simulated";
    line.transport = model::Transport::simulated;
    line.framing = framing;
    line.format = {9600, 8, wire::Parity::none, 1};
    line.devices = {device};
    return line;
}

TEST(Simulated, SpendsTheLinesByteTimes) {
    const auto loop = make_loop();
    const auto line = simulated(wire::Framing::rtu);
    ScriptEngine master;
    const std::string request = bytes({0x01, 0x04, 0x00, 0x00, 0x00, 0x01, 0x31, 0xCA});
    master.output = {request};
    const Instant start = now();
    const auto driver = open_line(*loop, line, master);
    ASSERT_TRUE(driver);
    EXPECT_EQ((*driver)->name(), "simulated");
    EXPECT_FALSE((*driver)->up());
    constexpr std::size_t kResponse = 7;
    ASSERT_TRUE(loop->run_until([&] { return master.input.size() == kResponse; }, kDeadline));
    EXPECT_EQ(master.input.substr(0, 3), bytes({0x01, 0x04, 0x02}));
    EXPECT_GE(now() - start,
              wire::transmission_time(line.format, request.size() + kResponse) + wire::t3_5(line.format));
    master.output = {request};
    (*driver)->poke();
    EXPECT_TRUE(loop->run_until([&] { return master.input.size() == 2 * kResponse; }, kDeadline));
}

}  // namespace slave_test
}  // namespace takt::line
