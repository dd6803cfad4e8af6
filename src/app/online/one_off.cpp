#include "online/one_off.hpp"

#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "output.hpp"
#include "takt/line/target.hpp"
#include "takt/report/drawing/formatting.hpp"

namespace takt::app {
namespace {

constexpr Duration kLeastLateWait = std::chrono::seconds(1);
constexpr Duration kLongestLateWait = std::chrono::seconds(5);
constexpr std::uint32_t kBitsPerRegister = 16;
constexpr int kMostQuestions = 3;

}  // namespace

void report_lengths_off(const Texts& texts, const client::Client& device) {
    if (const auto count = device.lengths_off())
        print_status(texts("app.lengths_off", {{"count", std::to_string(count)}}) + '\n');
}

Result<std::unique_ptr<OneOff>> OneOff::open(const Texts& texts, const ClientOptions& options) {
    TAKT_CHECK(line::parse_target(options.target));  // a bad target makes no traffic log
    auto one_off = std::make_unique<OneOff>(texts);
    TAKT_CHECK(one_off->loop_.begin(options.traffic, {}, texts));
    auto& loop = one_off->loop_;
    client::Options patient = options;
    if (!options.reconnect) patient.late_wait = std::clamp(options.timeout, kLeastLateWait, kLongestLateWait);
    TAKT_TRY(one_off->client_, client::Client::open(loop.loop(), patient,
                                                    console::traffic_factory(
                                                        loop.traffic(), console::LineTraffic::Side::master)));
    return one_off;
}

report::ClientRun run_of(const ClientOptions& options) {
    return {.target = options.target, .unit = options.unit};
}

ExitCode exit_code(const report::ClientRun& run, const Error& error) {
    return run.interrupted ? ExitCode::timed_out : exit_code(error);
}

namespace {

/// As start_meant(), with `--type bool`.
std::optional<std::uint16_t> coil_meant(const Texts& texts, wire::Area area, std::uint16_t start) {
    const auto word = std::string(report::area_word(area));
    if (!is_bit_area(area)) {
        print_error(texts("app.bool.registers", {{"area", word}, {"start", std::to_string(start)}}));
        return std::nullopt;
    }
    const std::uint32_t coil = start * kBitsPerRegister;
    if (coil == start || coil > UINT16_MAX) return start;
    const Texts::Arguments both{
        {"area", word}, {"start", std::to_string(start)}, {"coil", std::to_string(coil)}};
    if (::isatty(STDIN_FILENO) == 0 || ::isatty(STDERR_FILENO) == 0) {
        print_error(texts("app.bool.open", both));
        return std::nullopt;
    }
    for (int left = kMostQuestions; left > 0; --left) {
        print_status(texts("app.bool.question", both));
        std::string answer;
        if (!std::getline(std::cin, answer)) break;
        if (answer == "1") return start;
        if (answer == "2") return static_cast<std::uint16_t>(coil);
    }
    print_error(texts("app.bool.open", both));
    return std::nullopt;
}

}  // namespace

std::optional<std::uint16_t> start_meant(const Texts& texts, wire::Area area, std::uint16_t start,
                                         const ItemOptions& options) {
    if (options.as_bool) return coil_meant(texts, area, start);
    if (!options.registers_only || !is_bit_area(area)) return start;
    print_error(texts("app.registers_only", {{"area", std::string(report::area_word(area))}}));
    return std::nullopt;
}

bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items) {
    if (start + items <= 65536) return false;
    print_error(
        texts("app.beyond_area", {{"start", std::to_string(start)}, {"items", std::to_string(items)}}));
    return true;
}

}  // namespace takt::app
