// A measuring instrument that sleeps between characters (docs/firmware.md). A command starts a measurement;
// its value can be read until it is too old. At rest no interrupt wakes the core.
//
// Its sensor is TIMER2 of `microbit`: after the time of a conversion it delivers the clock in milliseconds,
// so that nothing has to be connected. Afterwards the timer waits until the value is too old: an age computed
// from the clock would look fresh again after each turn of the clock.
#include <array>
#include <cstdint>
#include <optional>

#include "takt/firmware/cortex_m.hpp"
#include "takt/firmware/main_loop.hpp"
#include "takt/firmware/serial_device.hpp"
#include "takt/firmware/slave_frame.hpp"

namespace {

namespace firmware = takt::firmware;
namespace serve = takt::serve;
using takt::firmware::reg;
using takt::wire::Area;
using takt::wire::ExceptionCode;

// Microseconds, of the build (firmware/images.cmake)
constexpr std::uint32_t kConversion = TAKT_CONVERSION;
constexpr std::uint32_t kMostAge = TAKT_MOST_AGE;
constexpr std::uint32_t kMillisecond = 1000;

// Input registers: state, number of the measurement, value (two registers, high one first), age in
// milliseconds; the further ones are 0. Those of the measurement are refused without a valid one: with
// exception 6 while a conversion runs, else with 0x0B, as the servers of takt refuse stale values.
constexpr std::size_t kInputs = 24;
constexpr std::size_t kFirstMeasured = 2;
constexpr std::size_t kLastMeasured = 4;

// Holding register 0: the command. It is read as 0.
enum Command : std::uint16_t { start = 1, reset = 2 };

enum class State : std::uint8_t { none, measuring, valid, stale };

firmware::BankStorage<0, 0, kInputs, 1> g_banks;

class Sensor {
public:
    void execute(std::uint16_t command) {
        const firmware::InterruptLock lock;
        if (command == Command::start) {
            state_ = State::measuring;
            restart(kConversion);
        } else {
            reg(kTimer + 0x004) = 1;
            reg(kTimer + 0x140) = 0;
            state_ = State::none;
            count_ = 0;
        }
    }
    void on_timer() {
        if (reg(kTimer + 0x140) == 0) return;  // stopped meanwhile
        reg(kTimer + 0x140) = 0;
        if (state_ == State::measuring) {
            taken_ = firmware::board::clock();
            ++count_;
            state_ = State::valid;
            restart(kMostAge);
        } else {
            state_ = State::stale;
        }
    }
    /// Writes the input registers. @returns why there is no measurement to be read
    std::optional<ExceptionCode> show() const {
        const firmware::InterruptLock lock;
        const std::uint32_t value = taken_ / kMillisecond;
        g_banks.input_registers = {
            static_cast<std::uint16_t>(state_), count_, static_cast<std::uint16_t>(value >> 16U),
            static_cast<std::uint16_t>(value),
            static_cast<std::uint16_t>((firmware::board::clock() - taken_) / kMillisecond)};
        if (state_ == State::valid) return std::nullopt;
        return state_ == State::measuring ? ExceptionCode::server_device_busy
                                          : ExceptionCode::gateway_target_failed_to_respond;
    }

private:
    static constexpr std::uint32_t kTimer = 0x4000A000;  // TIMER2
    static constexpr unsigned kTimerInterrupt = 10;

    static void restart(std::uint32_t microseconds) {
        reg(kTimer + 0x004) = 1;
        reg(kTimer + 0x00C) = 1;
        reg(kTimer + 0x140) = 0;
        reg(kTimer + 0x508) = 3;          // 32 bits
        reg(kTimer + 0x510) = 4;          // 1 MHz
        reg(kTimer + 0x200) = 1U << 8U;   // stops at CC[0]
        reg(kTimer + 0x304) = 1U << 16U;  // interrupt at CC[0]
        reg(kTimer + 0x540) = microseconds;
        firmware::enable_interrupt(kTimerInterrupt);
        reg(kTimer + 0x000) = 1;
    }

    State state_ = State::none;
    std::uint16_t count_ = 0;
    std::uint32_t taken_ = 0;  // when the last conversion ended
};
Sensor g_sensor;

class Hooks final : public serve::UnitHooks {
public:
    std::optional<ExceptionCode> before(const serve::Context&, const serve::Access& access) override {
        if (access.write) {
            const unsigned command = access.values[0] << 8U | access.values[1];
            if (command == Command::start || command == Command::reset) return std::nullopt;
            return ExceptionCode::illegal_data_value;
        }
        const bool computed = access.area == Area::input_register && access.start <= kLastMeasured;
        if (!computed) return std::nullopt;
        const auto refusal = g_sensor.show();
        return access.start + access.count > kFirstMeasured ? refusal : std::nullopt;
    }
    void written(const serve::Context&, const serve::Access&) override {
        g_sensor.execute(g_banks.holding_registers[0]);
        g_banks.holding_registers[0] = 0;
    }
};

}  // namespace

extern "C" void timer2_interrupt() {
    g_sensor.on_timer();
}

int main() {
    static Hooks hooks;
    static std::array units{serve::Unit{takt::UnitId{1}, g_banks.banks(), &hooks, {}}};
    static serve::Server server(units);
    static firmware::SerialDevice device({.framing = takt::wire::Framing::rtu,
                                          .format = {.baud = 9600, .parity = takt::wire::Parity::none},
                                          .frame_silence = TAKT_SILENCE},
                                         server);
    if (!device.start()) return 1;
    firmware::run(device);
}
