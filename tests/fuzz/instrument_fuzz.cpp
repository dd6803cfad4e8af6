// An instrument that sends arbitrary bytes, on request or by itself, with any template or binary format. Only
// numbers are measured, no request is early, and the engine always has a next wake-up. With a start and
// commands: each command has one result, and the engine comes to rest.
//
// Script: what it is (bit 0 it talks, bit 1 binary, above it the check sum, bit 4 with a start and commands),
// for text the template's length and its bytes; then steps: length of what comes (0..127; with bit 4 126 is a
// new link and 127 a command), in bit 7 whether time passes before it, in milliseconds.
#include <chrono>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "input.hpp"
#include "takt/endpoint/instrument_engine.hpp"

namespace {

using namespace takt;

model::AnswerFormat format_of(unsigned what, fuzz::Input& input) {
    model::AnswerFormat format;
    if ((what & 2U) != 0) {
        format.checksum = model::Checksum{static_cast<std::uint8_t>(what >> 2 & 3)};
        format.length = 8;
        format.begins = "\x02";
        format.fields.push_back({.name = "flow", .offset = 1, .bytes = 4, .type = DataType::float32});
        return format;
    }
    const Bytes text = input.bytes(input.byte());
    const auto pattern = model::parse_template({reinterpret_cast<const char*>(text.data()), text.size()});
    format.until = "\r";
    format.pattern = pattern ? *pattern : *model::parse_template("{weight} kg");
    return format;
}

void judge(const endpoint::InstrumentEngine& engine, const model::AnswerFormat& format, Instant t) {
    for (const auto name : format.names()) {
        const auto& reading = engine.reading(name);
        if (const auto* const real = std::get_if<double>(&reading.value)) fuzz::require(std::isfinite(*real));
        fuzz::require(!reading.at || *reading.at <= t);
    }
}

model::AnswerFormat line(const char* pattern) {
    return {.until = "\r", .pattern = *model::parse_template(pattern)};
}

void add_commands(model::Instrument& settings) {
    settings.start.push_back({.request = "S"});
    settings.start[0].confirmation = {.answer = line("OK"), .refused = line("E{*}"), .attempts = 2};
    settings.start.push_back({.request = "M"});
    settings.reset = line("R{*}");
    auto& command = settings.commands.emplace_back();
    command.request = *model::parse_template("T{value}");
    command.confirmation = {.answer = line("OK"), .refused = line("E{*}")};
    command.read_back = model::Exchange{.request = "?", .answer = line("T{value}")};
    settings.commands.push_back(command);
    settings.commands[1].restore = false;
}

/// Sends all that is due. Nothing is due afterwards.
void drain(endpoint::InstrumentEngine& engine, Instant t) {
    for (int i = 0; !engine.transmit(t).empty(); ++i) fuzz::require(i < 100);
    fuzz::require(engine.next_wakeup() > t);
}

void run_commands(const model::Instrument& settings, fuzz::Input& input) {
    constexpr unsigned kLink = 126;
    constexpr unsigned kCommand = 127;
    endpoint::InstrumentEngine engine(settings);
    Instant t = Instant{} + std::chrono::seconds(1);
    std::vector<int> results;
    engine.on_link(t, true);
    while (!input.empty()) {
        const unsigned step = input.byte();
        if ((step & 0x80U) != 0) t += std::chrono::milliseconds(input.word());
        engine.on_tick(t);
        drain(engine, t);
        const unsigned length = step & 0x7FU;
        if (length == kLink) {
            engine.on_link(t, false);
            engine.on_link(t, true);
        } else if (length == kCommand) {
            const std::size_t index = results.size();
            results.push_back(0);
            const auto taken =
                engine.submit(t, input.byte() % 2U, "5", [&results, index](auto) { ++results[index]; });
            if (!taken) results.pop_back();
        } else {
            const fuzz::Exact bytes(input.bytes(length));
            engine.on_bytes(t, bytes.span());
        }
        drain(engine, t);
    }
    engine.on_tick(after(t, settings.commands[0].expires));
    for (const int count : results) fuzz::require(count == 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    const unsigned what = input.byte();
    model::Instrument settings;
    settings.timeout = std::chrono::milliseconds(100);
    auto& exchange = settings.exchanges.emplace_back();
    if ((what & 1U) == 0) exchange.request = "?";
    exchange.answer = format_of(what, input);
    if ((what & 16U) != 0) {
        add_commands(settings);
        run_commands(settings, input);
        return 0;
    }
    endpoint::InstrumentEngine engine(settings);
    Instant t = Instant{} + std::chrono::seconds(1);
    engine.on_link(t, true);
    while (!input.empty()) {
        const unsigned step = input.byte();
        if ((step & 0x80U) != 0) t += std::chrono::milliseconds(input.word());
        engine.on_tick(t);
        const bool due = engine.next_wakeup() <= t;
        const Bytes asked = engine.transmit(t);
        fuzz::require(asked.empty() || (due && asked.size() == 1));
        const fuzz::Exact bytes(input.bytes(step & 0x7FU));
        engine.on_bytes(t, bytes.span());
        judge(engine, exchange.answer, t);
        fuzz::require(!settings.is_asked() || engine.next_wakeup() != kNever);
    }
    const auto& counters = engine.counters();
    fuzz::require(counters.answers + counters.timeouts <= counters.requests || !settings.is_asked());
    return 0;
}
