// One slave engine of a serial line, on a line whose time the test moves.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "support.hpp"
#include "takt/serve/serial_slave.hpp"

namespace takt::serve {

using namespace std::chrono_literals;

constexpr wire::CharacterFormat kFast{115200, 8, wire::Parity::none, 1};
constexpr Duration kSilence = 1750us;

/// The frames as "received 03 ..." or "sent ..."; faults as their names.
class Log final : public wire::TrafficObserver {
public:
    void on_frame(Instant, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override {
        EXPECT_EQ(raw.size(), pdu.size() + 3);
        EXPECT_EQ(raw[0], unit.value);
        lines.push_back((direction == wire::Direction::sent ? "sent " : "received ") + hex(pdu));
    }
    void on_fault(Instant, wire::FrameFault fault, Bytes) override { lines.emplace_back(wire::name(fault)); }
    std::vector<std::string> lines;
};

/// A responder that answers as the test wants, for one unit.
class Scripted final : public Responder {
public:
    [[nodiscard]] bool serves(UnitId unit) const override { return unit == UnitId{9} || unit == UnitId{10}; }
    [[nodiscard]] Answer handle(const Context& context, const wire::RequestView&) override {
        last_time = context.time;
        ++calls;
        return next;
    }
    Answer next;
    Instant last_time;
    int calls = 0;
};

/// One slave engine on a line whose time the test moves. Units 1 and 2 are served unless another responder is
/// given.
class Rig {
public:
    explicit Rig(SerialConfig config = {}, Responder* responder = nullptr,
                 wire::TrafficObserver* observer = nullptr)
        : units{Unit{UnitId{1}, first.banks(), nullptr}, Unit{UnitId{2}, second.banks(), nullptr}},
          server(units),
          format(config.format),
          slave(config, responder ? *responder : server, observer) {
        slave.on_link(now, true);
        run(10ms);
    }

    /// The bytes come over the line from now on, `chunk` at a time.
    void receive(const std::string& text, std::size_t chunk = 1) {
        const auto data = bytes(text);
        const Instant start = now;
        for (std::size_t done = 0; done < data.size();) {
            const std::size_t count = std::min(chunk, data.size() - done);
            run_until(start + wire::transmission_time(format, done + count));
            slave.on_bytes(now, Bytes(data).subspan(done, count));
            done += count;
            collect();
        }
    }
    void run(Duration length) { run_until(now + length); }

    /// Receives the bytes, waits, and returns the bytes sent meanwhile.
    std::string exchange(const std::string& text, Duration wait = 20ms) {
        sent.clear();
        receive(text);
        run(wait);
        return sent;
    }

    void run_until(Instant end) {
        while (slave.next_wakeup() <= end) {
            now = std::max(now, slave.next_wakeup());
            slave.on_tick(now);
            collect();
        }
        now = end;
    }
    void collect() {
        for (Bytes out = slave.transmit(now); !out.empty(); out = slave.transmit(now)) {
            if (!sent.empty()) sent += " | ";
            sent += hex(out);
            sent_at = now;
        }
    }

    Storage first, second;
    std::array<Unit, 2> units;
    Server server;
    wire::CharacterFormat format;
    SerialSlave slave;
    Instant now{};
    std::string sent;
    Instant sent_at{};
};

inline SerialConfig rtu_config() {
    return {.format = kFast};
}
inline SerialConfig ascii_config() {
    return {.framing = wire::Framing::ascii, .format = {9600, 7, wire::Parity::even, 1}};
}

inline const std::string kRead = rtu(1, "03 0010 0002");
inline const std::string kReadAnswer = rtu(1, "03 04 0010 0011");

}  // namespace takt::serve
