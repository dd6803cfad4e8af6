// Shared by the bus tests: frames as hex, and an engine whose time is moved by hand.
#pragma once

#include <string_view>
#include <vector>

#include "takt/bus/transaction_engine.hpp"

namespace takt::bus::test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

inline std::vector<std::uint8_t> hex(std::string_view text) {
    std::vector<std::uint8_t> bytes;
    int digits = 0;
    unsigned value = 0;
    for (const char c : text) {
        if (c == ' ') continue;
        value = value * 16 + static_cast<unsigned>(c <= '9' ? c - '0' : c - 'A' + 10);
        if (++digits % 2 == 0) {
            bytes.push_back(static_cast<std::uint8_t>(value));
            value = 0;
        }
    }
    return bytes;
}

/// A PDU given as hex, framed as RTU.
inline std::vector<std::uint8_t> rtu(std::uint8_t unit, std::string_view pdu) {
    const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{unit}, 0, hex(pdu));
    return {frame.begin(), frame.end()};
}

/// A frame of Modbus TCP. @param rest  what follows protocol id 0, as hex
inline std::vector<std::uint8_t> frame(std::uint16_t id, std::string_view rest) {
    std::vector<std::uint8_t> made{static_cast<std::uint8_t>(id >> 8U), static_cast<std::uint8_t>(id), 0, 0};
    const auto bytes = hex(rest);
    made.insert(made.end(), bytes.begin(), bytes.end());
    return made;
}

/// The frame of the n-th request of an engine, n from 1, or that of its response. While no id was skipped.
inline std::vector<std::uint8_t> mbap(unsigned n, std::string_view rest) {
    TransactionIds ids(LineConfig().first_transaction);
    std::uint16_t id = 0;
    while (n-- > 0) id = ids.next([](std::uint16_t) { return false; });
    return frame(id, rest);
}

inline Transaction transaction(TransactionId id, std::uint8_t unit, std::string_view pdu,
                               Duration wait = 100ms) {
    return {.id = id, .unit = UnitId{unit}, .request = wire::PreparedRequest(hex(pdu)), .wait = wait};
}

/// 19200 8N1: a character takes 520833.3 ns, t3.5 1822917 ns, a request of 8 bytes 4166667 ns.
constexpr LineConfig kLine{
    .framing = wire::Framing::rtu,
    .format = {.baud = 19200, .data_bits = 8, .parity = wire::Parity::none, .stop_bits = 1},
    .margin = 2ms};
constexpr Duration kT35 = 1822917ns;
constexpr Duration kRequest = 4166667ns;

/// An engine with its link up at 0, and the outcomes it gave so far.
struct Rig {
    explicit Rig(const LineConfig& config = kLine, wire::TrafficObserver* observer = nullptr)
        : engine(config, observer) {
        engine.on_link(at(0ms), true);
    }

    void submit(Instant t, const Transaction& transaction) {
        if (!engine.submit(t, transaction)) refused.push_back(transaction.id);
    }
    void receive(Instant t, std::string_view text) { receive(t, hex(text)); }
    void receive(Instant t, const std::vector<std::uint8_t>& bytes) {
        engine.on_bytes(t, bytes);
        collect();
    }
    /// Lets time pass up to `end` as a driver does, ticking whenever the engine asks for it.
    void run_until(Instant end) {
        transmit(now);
        while (engine.next_wakeup() <= end) {
            now = std::max(now, engine.next_wakeup());
            engine.on_tick(now);
            collect();
            transmit(now);
        }
        now = end;
    }
    void transmit(Instant t) {
        for (Bytes bytes = engine.transmit(t); !bytes.empty(); bytes = engine.transmit(t)) {
            sent.emplace_back(bytes.begin(), bytes.end());
            sent_at.push_back(t);
        }
    }
    void collect() {
        while (auto outcome = engine.take_outcome()) outcomes.push_back(*outcome);
    }
    [[nodiscard]] const Outcome& last() const { return outcomes.back(); }

    TransactionEngine engine;
    Instant now = at(0ms);
    std::vector<std::vector<std::uint8_t>> sent;
    std::vector<Instant> sent_at;
    std::vector<Outcome> outcomes;
    std::vector<TransactionId> refused;
};

}  // namespace takt::bus::test
