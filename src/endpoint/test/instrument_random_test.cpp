// An instrument that fails at random: nothing is lost or mixed up.
#include <rapidcheck/gtest.h>

#include <cstdint>
#include <functional>

#include "instrument_bench.hpp"

namespace takt::endpoint {
namespace instrument_random_test {

using namespace test;

/// Answers as the settings of scale() say. Forgets everything when it restarts.
struct Fake {
    bool initialised = false;
    std::string tare = "none";
    std::string executed;  // values of tare, in order, without those of a repetition
    std::string in;

    /// The answer to a byte, if it ends a request.
    std::string take(char c) {
        if (c != '\r') {
            in += c;
            return {};
        }
        const auto request = std::exchange(in, {});
        if (request == "W") return "W1\r";
        if (request == "MODE") return {};
        if (request == "INIT") {
            initialised = true;
            return "OK\r";
        }
        if (request[0] != 'T') return {};
        if (!initialised) return "ERR\r";
        tare = request.substr(1);
        return "OK\r";
    }
    void restart() { *this = {}; }
};

RC_GTEST_PROP(InstrumentCommands, NothingIsLostOrMixedUp, (const std::vector<std::uint8_t>& script)) {
    auto settings = scale();
    settings.commands[0].expires = 3s;
    InstrumentEngine engine(settings);
    Fake fake;
    Instant now{std::chrono::hours(1)};
    std::vector<WriteResult> results;
    std::string confirmed = "none";  // the value of the last confirmed write
    bool unknown = false;            // a later write had no clear result
    std::size_t written = 0;
    std::size_t expected_results = 0;
    bool answers = true;
    std::string reply;
    const auto serve = [&] {
        for (auto sent = engine.transmit(now); !sent.empty(); sent = engine.transmit(now))
            for (const auto byte : sent) reply += fake.take(static_cast<char>(byte));
    };
    const auto pass = [&](Duration time) {
        const Instant end = after(now, time);
        for (int i = 0; i < 10000; ++i) {
            if (!reply.empty() && answers) {
                const auto bytes = std::exchange(reply, {});
                engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
            } else if (engine.next_wakeup() <= end) {
                now = std::max(now, engine.next_wakeup());
                engine.on_tick(now);
            } else {
                break;
            }
            reply = answers ? reply : std::string();
            serve();
        }
        now = end;
    };
    engine.on_link(now, true);
    serve();
    for (const auto step : script) switch (step % 8) {
            case 0:
            case 1:
            case 2: {
                const auto value = std::to_string(++written);
                const auto taken = engine.submit(now, 0, value, [&, value](WriteResult result) {
                    results.push_back(result);
                    if (result == WriteResult::done) {
                        RC_ASSERT(fake.tare == value);
                        confirmed = value;
                        unknown = false;
                    } else if (result != WriteResult::refused) {
                        unknown = true;
                    }
                });
                if (taken) ++expected_results;
                serve();
                break;
            }
            case 3: {  // a restart with its line
                fake.restart();
                reply.clear();
                const std::string_view text = "READY\r";
                engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
                serve();
                break;
            }
            case 4:  // a restart of the connection
                fake.restart();
                reply.clear();
                engine.on_link(now, false);
                engine.on_link(now, true);
                serve();
                break;
            case 5: answers = !answers; break;
            case 6: pass(std::chrono::milliseconds(step)); break;
            default: pass(std::chrono::milliseconds(10 * step));
        }
    answers = true;
    pass(60s);
    RC_ASSERT(results.size() == expected_results);
    RC_ASSERT(engine.state() == InstrumentState::ready);
    RC_ASSERT(fake.initialised || confirmed == "none");
    if (!unknown) RC_ASSERT(fake.tare == confirmed || fake.tare == "none");
    if (!unknown && fake.initialised) RC_ASSERT(fake.tare == confirmed);
}

}  // namespace instrument_random_test
}  // namespace takt::endpoint
