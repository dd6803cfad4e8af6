// Arbitrary bytes from the devices at any time, for the engine of a master. Every transaction has exactly one
// outcome, an accepted answer matches its request, and on an idle line every transaction ends.
#pragma once

#include <map>
#include <vector>

#include "script.hpp"
#include "takt/bus/transaction_engine.hpp"

namespace takt::fuzz {

class MasterScript {
public:
    MasterScript(wire::Framing framing, Input input)
        : input_(input), config_(config(framing, input_)), engine_(config_) {
        engine_.on_link(now_, true);
    }

    void play() {
        while (!input_.empty()) step();
        pass(std::chrono::minutes(10));
        require(engine_.idle() && asked_.empty());
    }

private:
    static bus::LineConfig config(wire::Framing framing, Input& input) {
        const std::uint8_t choice = input.byte();
        bus::LineConfig config;
        config.framing = framing;
        config.format = format_of(choice);
        if (framing != wire::Framing::tcp && (choice & 2) != 0) config.format.baud = 0;
        config.in_flight = framing == wire::Framing::tcp ? choice % bus::kMaxInFlight + 1U : 1;
        config.echo = bus::Echo{static_cast<std::uint8_t>((choice >> 4) % 3)};
        if (!config.is_serial()) config.echo = bus::Echo::absent;
        return config;
    }

    void step() {
        const std::uint8_t what = input_.byte();
        switch (what % 8) {
            case 0: receive(take_noise(input_)); break;
            case 1:
            case 2: submit(what); break;
            case 3:
            case 4: answer(what); break;
            case 5: pass(std::chrono::microseconds(input_.word() * 8)); break;
            case 6: receive(last_sent_.span()); break;
            default:
                if (what > 0xF0) {
                    engine_.on_link(now_, up_ = !up_);
                    take_outcomes();
                } else if (what > 0xE0) {
                    engine_.cancel_all(now_);
                    take_outcomes();
                } else {
                    pass(std::chrono::microseconds(input_.byte() * 100));
                }
        }
    }

    void submit(std::uint8_t what) {
        bus::Transaction transaction;
        transaction.id = ++last_id_;
        transaction.unit = unit_of(what);
        transaction.wait = std::chrono::milliseconds(input_.byte());
        if ((what & 0x80) != 0) {  // a read, else anything
            transaction.request = wire::Pdu{static_cast<std::uint8_t>(what / 32 % 4 + 1), 0, input_.byte(), 0,
                                            static_cast<std::uint8_t>(input_.byte() % 125 + 1)};
        } else {
            const Bytes any = take_pdu(input_);
            if (any.empty()) return;
            transaction.request = wire::PreparedRequest(any);
        }
        if (engine_.submit(now_, transaction)) asked_[transaction.id] = transaction;
        collect();
    }

    // A plausible answer: unit and transaction of the last request or their neighbours, with any PDU.
    void answer(std::uint8_t what) {
        if (last_sent_.empty()) return;
        wire::Pdu pdu;
        if ((what & 0x80) != 0) {
            pdu.push_back(last_pdu_[0]);
            if ((what & 0x20) != 0) pdu[0] = static_cast<std::uint8_t>(pdu[0] | 0x80);
        }
        const Bytes any = input_.bytes(std::min<std::size_t>(input_.byte(), wire::kMaxPdu - 1));
        for (const std::uint8_t byte : any) pdu.push_back(byte);
        if (pdu.empty()) return;
        const UnitId unit = (what & 0x40) != 0 ? unit_of(what) : last_unit_;
        const auto id = static_cast<std::uint16_t>(last_transaction_ - (what & 0x10) / 16);
        receive(wire::encode_frame(config_.framing, unit, id, pdu.span()).span());
    }

    void receive(Bytes bytes) {
        const Exact exact(bytes);
        engine_.on_bytes(now_, exact.span());
        collect();
        if (!engine_.must_reconnect()) return;
        engine_.on_link(now_, false);
        take_outcomes();
        engine_.on_link(now_, up_ = true);
    }

    void pass(Duration length) {
        run_until(engine_, now_, now_ + length, [this](Instant t) {
            engine_.on_tick(t);
            collect();
        });
    }

    void collect() {
        take_outcomes();
        for (;;) {
            const Bytes sent = engine_.transmit(now_);
            if (sent.empty()) return;
            require(up_ && sent.size() <= wire::kMaxAsciiFrame);
            last_sent_.assign(sent);
            note(sent);
        }
    }

    void note(Bytes sent) {
        wire::FramerConfig reading;
        reading.framing = config_.framing;
        reading.side = wire::Side::slave;
        reading.silence = std::chrono::seconds(1);
        wire::StandaloneFramer framer(reading);
        auto step = framer.push(now_, sent);
        if (!step.complete) step = framer.on_tick(now_ + std::chrono::seconds(2));
        require(step.complete);
        const auto frame = framer.frame();
        last_pdu_.assign(frame.pdu);
        last_unit_ = frame.unit;
        last_transaction_ = frame.transaction;
    }

    void take_outcomes() {
        while (const auto outcome = engine_.take_outcome()) {
            const auto asked = asked_.find(outcome->id);
            require(asked != asked_.end() && asked->second.unit == outcome->unit);
            if (outcome->status == bus::Status::ok && !outcome->response.empty()) {
                require(outcome->response.pdu()[0] == asked->second.request.function());
                if (const auto request = wire::decode_request(asked->second.request.pdu()))
                    require(wire::decode_response(*request, outcome->response.pdu()).has_value());
            }
            asked_.erase(asked);
        }
    }

    Input input_;
    bus::LineConfig config_;
    bus::TransactionEngine engine_;
    Instant now_{};
    bool up_ = true;
    bus::TransactionId last_id_ = 0;
    std::map<bus::TransactionId, bus::Transaction> asked_;
    wire::FrameBytes last_sent_;
    wire::Pdu last_pdu_;
    UnitId last_unit_;
    std::uint16_t last_transaction_ = 0;
};

}  // namespace takt::fuzz
