// Arbitrary bytes on a connection to a slave: Modbus TCP, or RTU and ASCII over the stream. Answers are in
// order and, over Modbus TCP, have the transactions and units of the requests. The slave closes the
// connection or answers the final request.
#include "slave.hpp"
#include "takt/serve/tcp_connection.hpp"

namespace takt::fuzz {
namespace {

class Script {
public:
    explicit Script(Input input)
        : input_(input), config_(config(input_)), connection_(config_, plant_.server) {
        connection_.on_link(now_, true);
    }

    void play() {
        while (!input_.empty() && !closed()) step();
        collect(true);
        if (!closed()) ask_at_the_end();
    }

private:
    static serve::TcpConfig config(Input& input) {
        serve::TcpConfig config;
        const std::uint8_t choice = input.byte();
        config.framing = choice < 0xC0       ? wire::Framing::tcp
                         : (choice & 1) != 0 ? wire::Framing::rtu
                                             : wire::Framing::ascii;
        return config;
    }

    void step() {
        const std::uint8_t what = input_.byte();
        switch (what % 8) {
            case 0: receive(take_noise(input_)); break;
            case 1:
            case 2:
            case 3: hear_frame(what); break;
            case 4: hear_many(what); break;
            case 5: pass(std::chrono::milliseconds(input_.byte() * 4)); break;
            case 6: reads_ = !reads_; break;
            default: pass(std::chrono::microseconds(input_.byte()));
        }
    }

    wire::FrameBytes frame(std::uint8_t what, Bytes pdu) {
        return wire::encode_frame(config_.framing, unit_of(what), ++transaction_, pdu);
    }

    void hear_frame(std::uint8_t what) {
        const Bytes pdu = take_pdu(input_);
        if (pdu.empty()) return;
        const auto whole = frame(what, pdu);
        const std::size_t cut = (what & 0x40) != 0 ? input_.byte() % whole.size() : 0;
        receive(whole.span().first(cut));
        if ((what & 0x80) != 0) pass(std::chrono::milliseconds(input_.byte()));
        receive(whole.span().subspan(cut));
    }

    void hear_many(std::uint8_t what) {
        const Bytes pdu = input_.bytes(input_.byte() % 16 + 1U);
        if (pdu.empty()) return;
        for (int i = input_.byte() % 40; i >= 0; --i) receive(frame(what, pdu).span());
    }

    // Like a driver: never more than wanted bytes; the peer keeps the rest.
    void receive(Bytes bytes) {
        while (!bytes.empty() && connection_.wants_bytes() > 0) {
            const Exact piece(bytes.first(std::min(bytes.size(), connection_.wants_bytes())));
            connection_.on_bytes(now_, piece.span());
            bytes = bytes.subspan(piece.span().size());
            collect(reads_);
        }
    }

    void pass(Duration length) {
        const Instant end = now_ + length;
        if (!reads_) {
            now_ = end;
            return connection_.on_tick(now_);
        }
        run_until(connection_, now_, end, [this](Instant t) {
            connection_.on_tick(t);
            collect(true);
        });
    }

    void collect(bool may_send) {
        while (may_send) {
            const Bytes sent = connection_.transmit(now_);
            if (sent.empty()) return;
            require(sent.size() <= serve::kTcpBuffer);
            last_.assign(sent.begin(), sent.end());
            if (config_.framing == wire::Framing::tcp) check(sent);
        }
    }

    void check(Bytes sent) {
        while (!sent.empty()) {
            const auto step = answers_.push(now_, sent);
            require(step.fault == wire::FrameFault::none && step.consumed > 0);
            sent = sent.subspan(step.consumed);
        }
    }

    [[nodiscard]] bool closed() const { return connection_.close_reason() != serve::CloseReason::none; }

    void ask_at_the_end() {
        reads_ = true;
        pass(std::chrono::seconds(3));  // longer than a frame may take
        collect(true);
        if (closed()) return;
        last_.clear();
        const auto question = wire::encode_frame(config_.framing, UnitId{1}, kQuestionId, kQuestion);
        receive(question.span());
        pass(std::chrono::seconds(1));
        const auto right = wire::encode_frame(config_.framing, UnitId{1}, kQuestionId, plant_.right_answer());
        require(std::ranges::equal(last_, right.span()));
    }

    Input input_;
    serve::TcpConfig config_;
    Plant plant_;
    serve::TcpConnection connection_;
    wire::StandaloneFramer answers_{{.framing = wire::Framing::tcp, .side = wire::Side::master}, true};
    Instant now_{};
    bool reads_ = true;
    std::uint16_t transaction_ = 0;
    std::vector<std::uint8_t> last_;
};

}  // namespace
}  // namespace takt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    takt::fuzz::Script(takt::fuzz::Input({data, size})).play();
    return 0;
}
