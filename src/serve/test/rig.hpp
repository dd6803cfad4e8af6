// A gateway whose line is played by the test, in hand-moved time.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hex.hpp"
#include "takt/serve/gateway.hpp"

namespace takt::serve::test {

using namespace std::chrono_literals;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

/// "03 00 00 00 01"
inline wire::Pdu pdu(std::string_view hex) {
    wire::Pdu made;
    for (const std::uint8_t byte : takt::test::from_hex(hex)) made.push_back(byte);
    return made;
}

inline std::string hex(Bytes bytes) {
    return takt::test::to_hex(bytes);
}

/// Requests by token, which is also their number; the line has a transaction at a time.
struct Rig {
    explicit Rig(const GatewayConfig& config = {}) : gateway(config) { gateway.on_link(true); }

    /// @returns the token
    serve::Token ask(std::uint64_t client, std::uint8_t unit, std::string_view request) {
        const serve::Token token = ++last_token;
        if (const auto answer =
                gateway.ask(now, {1, client, token, peer}, policy, UnitId{unit}, pdu(request)))
            take(token, answer->span());
        collect();
        return token;
    }

    /// The next transaction begins. @returns "17: 03 00 00 00 01"; "": there is none
    std::string begin() {
        sent = gateway.next(now);
        collect();
        return sent ? std::to_string(sent->unit.value) + ": " + hex(sent->request.pdu()) : "";
    }

    void end(bus::Status status, std::string_view response = {}, bool was_sent = true) {
        bus::Outcome outcome{.id = sent->id, .unit = sent->unit, .status = status, .sent = was_sent};
        const wire::Pdu bytes = pdu(response);
        outcome.response = wire::ResponseView(bytes.span());
        if (status == bus::Status::exception) outcome.exception = bytes[1];
        outcome.sent_at = outcome.request_end = outcome.ended_at = now;
        sent.reset();
        gateway.on_outcome(outcome);
        collect();
    }

    /// The answer to a request; "": none yet.
    std::string answer(serve::Token token) { return answers.contains(token) ? answers[token] : ""; }

    void collect() {
        while (const auto reply = gateway.take_reply()) {
            fates[reply->token] = reply->fate;
            take(reply->token, reply->pdu.span());
        }
    }

    Gateway gateway;
    RequestPolicy policy;
    std::uint64_t peer = 0;  ///< of the next requests
    Instant now = at(1s);
    std::optional<bus::Transaction> sent;
    std::map<serve::Token, std::string> answers;
    std::map<serve::Token, Fate> fates;  // of those that were not answered at once
    serve::Token last_token = 0;
    int answered_twice = 0;

private:
    void take(serve::Token token, Bytes answer) {
        if (!answers.emplace(token, hex(answer)).second) ++answered_twice;
    }
};

}  // namespace takt::serve::test
