// An instrument with start commands and settings, and an engine whose time is moved by hand.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/endpoint/instrument_engine.hpp"

namespace takt::endpoint::test {

using namespace std::chrono_literals;
using Kind = InstrumentEvent::Kind;

inline model::AnswerFormat line(const char* pattern) {
    model::AnswerFormat made;
    made.until = "\r";
    made.pattern = *model::parse_template(pattern);
    return made;
}

inline model::StartCommand start(const char* request, const char* answer) {
    model::StartCommand made{.request = request};
    if (answer != nullptr) made.confirmation.answer = line(answer);
    made.confirmation.refused = line("ERR{*}");
    made.confirmation.timeout = 100ms;
    made.confirmation.attempts = 2;
    return made;
}

inline model::InstrumentCommand command(const char* name, const char* request, const char* answer) {
    model::InstrumentCommand made{.name = name};
    made.request = *model::parse_template(request);
    if (answer != nullptr) made.confirmation.answer = line(answer);
    made.confirmation.refused = line("ERR{*}");
    made.confirmation.timeout = 100ms;
    made.expires = 1s;
    return made;
}

/// Asks W each second; tare is a setting, `zero` an action, `unit` is read back.
inline model::Instrument scale() {
    model::Instrument made{.name = "scale"};
    made.every = 1s;
    made.timeout = 100ms;
    made.exchanges.push_back({.request = "W\r", .answer = line("W{weight}")});
    made.start = {start("INIT\r", "OK"), start("MODE\r", nullptr)};
    made.start_retry = 2s;
    made.reset = line("READY{*}");
    made.commands = {command("tare", "T{value}\\r", "OK"), command("zero", "Z{value}\\r", "OK"),
                     command("unit", "U{value}\\r", nullptr)};
    made.commands[1].restore = false;
    made.commands[2].confirmation.refused.reset();
    made.commands[2].read_back = model::Exchange{.request = "U?\r", .answer = line("U={value}")};
    return made;
}

inline std::string_view word(WriteResult result) {
    constexpr std::string_view kWords[] = {"done", "refused", "differs", "no_answer", "expired"};
    return kWords[static_cast<std::size_t>(result)];
}

/// An engine and its time, moved by hand. `said` lists what it sends; `results` those of the commands.
struct Bench {
    explicit Bench(model::Instrument of = scale(), bool started = true)
        : settings(std::move(of)), engine(settings) {
        engine.set_observer([this](Instant, const InstrumentEvent& event) { events.push_back(event.kind); });
        if (!started) return;
        engine.on_link(now, true);
        run();
    }

    /// Takes what is to be sent now.
    void run() {
        for (auto sent = engine.transmit(now); !sent.empty(); sent = engine.transmit(now))
            said.append(reinterpret_cast<const char*>(sent.data()), sent.size() - 1).append(" ");
    }
    void pass(Duration time) {
        const Instant end = after(now, time);
        for (int i = 0; engine.next_wakeup() <= end; ++i) {
            ASSERT_LT(i, 1000) << "it does not come to rest";
            now = std::max(now, engine.next_wakeup());
            engine.on_tick(now);
            run();
        }
        now = end;
    }
    void receive(std::string_view text) {
        engine.on_bytes(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        run();
    }
    bool write(std::size_t command, const char* text) {
        const std::string name = settings.commands[command].name + text;
        const auto taken = engine.submit(now, command, text, [this, name](WriteResult result) {
            results.append(name).append(" ").append(word(result)).append("; ");
        });
        run();
        return taken.has_value();
    }
    void link(bool up) {
        engine.on_link(now, up);
        run();
    }
    std::string take() { return std::exchange(said, {}); }
    std::string take_results() { return std::exchange(results, {}); }
    /// Answers the start, and the first request.
    void make_ready() {
        receive("OK\r");
        receive("W1\r");
        EXPECT_EQ(engine.state(), InstrumentState::ready);
        take();
    }

    model::Instrument settings;
    InstrumentEngine engine;
    Instant now{std::chrono::hours(1)};
    std::string said;
    std::string results;
    std::vector<Kind> events;
};

}  // namespace takt::endpoint::test
