#include "takt/plan/firmware_estimate.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>

namespace takt::plan {
namespace {

using model::Firmware;

// Instructions of the image `microbit_instrument` (GCC 12, -Oz), as docs/firmware.md lists them.
constexpr std::uint32_t kPerCharacter = 173;  // received
constexpr std::uint32_t kPerFrame = 287;      // its end, and the check of its address
constexpr std::uint32_t kPerRequest = 1125;
constexpr std::uint32_t kPerRegister = 200;  // read and sent

// Characters of a request and of a response without its registers.
constexpr std::uint32_t kRequest = 8;
constexpr std::uint32_t kResponse = 5;

constexpr double kPpm = 1e-6;

double seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

std::uint32_t response_characters(std::uint32_t registers) {
    return kResponse + 2 * registers;
}

void estimate_rate(const Firmware& firmware, FirmwareEstimate& made) {
    const double clock = firmware.uart_clock;
    const double baud = firmware.format.baud;
    const double steps = firmware.divider_steps;
    const auto rate = [&](double divider) { return clock / (firmware.oversampling * divider / steps); };
    const double exact = clock * steps / (baud * firmware.oversampling);
    const double below = std::max(std::floor(exact), steps);
    const bool above = std::abs(rate(below + 1) - baud) < std::abs(rate(below) - baud);
    const double divider = above ? below + 1 : below;
    made.divider = divider / steps;
    made.bit_rate = rate(divider);
    made.divider_error = made.bit_rate / baud - 1;
    // Without oversampling the undivided clock finds the edge of the start bit.
    const double samples = firmware.oversampling > 1 ? firmware.oversampling : clock / baud;
    const double last_middle = firmware.format.bits() - 0.5;
    made.rate = {std::abs(made.divider_error) + firmware.uart_clock_ppm * kPpm,
                 std::max((0.5 - 1 / samples) / last_middle / 2, 0.0)};
}

MeasuredSilence measured(const Firmware& firmware, Duration silence) {
    const double character = seconds(wire::transmission_time(firmware.format, 1));
    const double time = seconds(silence) + character;
    return {
        .time = silence + wire::transmission_time(firmware.format, 1),
        .ticks = static_cast<std::uint64_t>(std::ceil(time * firmware.timer_clock)),
        .deviation = {1.0 / firmware.timer_clock + time * firmware.timer_clock_ppm * kPpm, character / 2}};
}

double active_time(const Firmware& firmware, const ExchangeCost& cost) {
    const double cycles =
        1.0 * cost.interrupts * kInterruptCycles + 1.0 * cost.instructions * firmware.cycles_per_instruction;
    return cost.interrupts * seconds(firmware.wakeup_time) + cycles / firmware.core_clock;
}

void estimate_load(const Firmware& firmware, FirmwareEstimate& made) {
    const double character = seconds(wire::transmission_time(firmware.format, 1));
    const double period = seconds(firmware.request_period);
    made.character = {active_time(firmware, {1, kPerCharacter}), character};
    const std::uint32_t sent = response_characters(firmware.registers);
    const double exchange = (kRequest + sent) * character + 2 * seconds(wire::t3_5(firmware.format));
    made.line = {exchange * (1 + firmware.other_exchanges), period};
    made.own = own_exchange(firmware.registers);
    made.foreign = foreign_exchange(firmware.registers);
    made.wakeups = (made.own.interrupts + 1.0 * firmware.other_exchanges * made.foreign.interrupts) / period;
    made.active =
        (active_time(firmware, made.own) + firmware.other_exchanges * active_time(firmware, made.foreign)) /
        period;
    made.sending = sent * character / period;
}

void estimate_current(const Firmware& firmware, FirmwareEstimate& made) {
    constexpr double kNano = 1e-3;  // microamperes
    constexpr double kMega = 1e6;
    made.asleep_ua = firmware.sleep_na * kNano * (1 - std::min(made.active, 1.0));
    made.active_ua = firmware.active_ua_per_mhz * (firmware.core_clock / kMega) * std::min(made.active, 1.0);
    made.uart_ua = firmware.uart_na * kNano;
    made.transceiver_ua = firmware.transceiver_ua + firmware.driver_ua * std::min(made.sending, 1.0);
    if (firmware.battery_mah && made.current_ua() > 0)
        made.battery_days = *firmware.battery_mah * 1000.0 / made.current_ua() / 24;
}

}  // namespace

ExchangeCost own_exchange(std::uint32_t registers) {
    return {kRequest + 1 + response_characters(registers),
            kRequest * kPerCharacter + kPerFrame + kPerRequest + registers * kPerRegister};
}

ExchangeCost foreign_exchange(std::uint32_t registers) {
    const std::uint32_t characters = kRequest + response_characters(registers);
    return {characters + 2, characters * kPerCharacter + 2 * kPerFrame};
}

FirmwareEstimate estimate(const Firmware& firmware) {
    FirmwareEstimate made;
    estimate_rate(firmware, made);
    made.t1_5 = measured(firmware, wire::t1_5(firmware.format));
    made.t3_5 = measured(firmware, wire::t3_5(firmware.format));
    made.most_ticks = firmware.timer_bits < 64 ? (std::uint64_t{1} << firmware.timer_bits) - 1 : UINT64_MAX;
    estimate_load(firmware, made);
    estimate_current(firmware, made);
    return made;
}

}  // namespace takt::plan
