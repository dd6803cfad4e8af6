// Arbitrary bytes in any pieces and with any pauses on the line of a slave. The input is a script (see
// Script).
#pragma once

#include "slave.hpp"
#include "takt/serve/serial_slave.hpp"

namespace takt::fuzz {

class SerialSlaveScript {
public:
    SerialSlaveScript(wire::Framing framing, Input input)
        : framing_(framing), input_(input), slave_(config(framing, input_), plant_.server) {
        slave_.on_link(now_, true);
    }

    void play() {
        while (!input_.empty()) step();
        ask_at_the_end();
    }

private:
    static serve::SerialConfig config(wire::Framing framing, Input& input) {
        const std::uint8_t choice = input.byte();
        serve::SerialConfig config;
        config.framing = framing;
        config.format = format_of(choice);
        config.strict = (choice & 2) != 0;
        config.finish_first = (choice & 4) != 0;
        config.untimed = (choice & 8) != 0;
        if ((choice & 16) != 0) config.turnaround = std::chrono::milliseconds(20);
        return config;
    }

    void step() {
        const std::uint8_t what = input_.byte();
        switch (what % 8) {
            case 0:
            case 1: receive(take_noise(input_)); break;
            case 2:
            case 3:
            case 4: hear_frame(what); break;
            case 5: pass(std::chrono::microseconds(input_.word() * 8)); break;
            case 6: receive(Exact(last_sent_.span()).span()); break;  // own echo, or a repetition
            default:
                if (what > 0xF0) slave_.on_link(now_, up_ = !up_);
                pass(std::chrono::microseconds(input_.byte() * 100));
        }
    }

    // A valid frame, in one or two pieces, sometimes with surplus bytes behind it.
    void hear_frame(std::uint8_t what) {
        const Bytes pdu = take_pdu(input_);
        if (pdu.empty()) return;
        const auto frame = wire::encode_frame(framing_, unit_of(what), 0, pdu);
        const std::size_t cut = (what & 0x40) != 0 ? input_.byte() % frame.size() : 0;
        receive(frame.span().first(cut));
        if ((what & 0x80) != 0) pass(std::chrono::microseconds(input_.word()));
        receive(frame.span().subspan(cut));
    }

    void receive(Bytes bytes) {
        const Exact exact(bytes);
        slave_.on_bytes(now_, exact.span());
        collect();
    }

    void pass(Duration length) {
        run_until(slave_, now_, now_ + length, [this](Instant t) {
            slave_.on_tick(t);
            collect();
        });
    }

    void collect() {
        for (;;) {
            const Bytes sent = slave_.transmit(now_);
            if (sent.empty()) return;
            require(up_ && sent.size() <= wire::kMaxAsciiFrame);
            last_sent_.assign(sent);
        }
    }

    void ask_at_the_end() {
        constexpr Duration kLongPause = std::chrono::seconds(3);  // longer than any answer may wait
        if (!up_) slave_.on_link(now_, up_ = true);
        pass(kLongPause);
        last_sent_.clear();
        receive(wire::encode_frame(framing_, UnitId{1}, 0, kQuestion).span());
        pass(kLongPause);
        const auto right = wire::encode_frame(framing_, UnitId{1}, 0, plant_.right_answer());
        require(std::ranges::equal(last_sent_.span(), right.span()));
    }

    wire::Framing framing_;
    Input input_;
    Plant plant_;
    serve::SerialSlave slave_;
    Instant now_{};
    bool up_ = true;
    wire::FrameBytes last_sent_;
};

}  // namespace takt::fuzz
