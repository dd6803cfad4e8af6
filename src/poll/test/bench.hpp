// A master on one RTU line at 115200 bit/s with devices played by the test, in hand-moved time.
#pragma once

#include <cstdio>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "takt/poll/master.hpp"

namespace takt::poll::test {

using namespace std::chrono_literals;
using wire::Function;

constexpr Instant at(Duration since_start) {
    return Instant{} + since_start;
}

/// "10 03 00 00"
inline std::string hex(Bytes bytes) {
    std::string text;
    for (const auto byte : bytes) {
        char digits[4];
        std::snprintf(digits, sizeof digits, "%02X ", byte);
        text += digits;
    }
    if (!text.empty()) text.pop_back();
    return text;
}

/// A variable as a test writes it: `real("a", 0).read(3).write(0x10).on_change()`.
struct Item : model::Variable {
    Item with(auto change) const {
        Item made = *this;
        change(made);
        return made;
    }
    Item read(int code) const {
        return with([=](Item& item) {
            item.model::Variable::read = Function(code);
            item.area = code == 1   ? wire::Area::coil
                        : code == 2 ? wire::Area::discrete_input
                        : code == 4 ? wire::Area::input_register
                                    : wire::Area::holding_register;
        });
    }
    Item write(int code) const {
        return with([=](Item& item) {
            item.model::Variable::write = Function(code);
            item.area = code == 0x05 || code == 0x0F ? wire::Area::coil : wire::Area::holding_register;
        });
    }
    Item every(Duration time) const {
        return with([=](Item& item) { item.period = time; });
    }
    Item on_change() const {
        return with([](Item& item) { item.write_on_change = true; });
    }
    Item read_on(model::LocalIndex local) const {
        return with([=](Item& item) { item.read_trigger = local; });
    }
    Item write_on(model::LocalIndex local) const {
        return with([=](Item& item) { item.write_trigger = local; });
    }
    Item reports_to(model::LocalIndex local) const {
        return with([=](Item& item) { item.status = local; });
    }
    Item defaults_to(double number) const {
        return with([=](Item& item) {
            item.default_value =
                model::Constant{.number = number, .integer = static_cast<std::int64_t>(number)};
        });
    }
    Item admitted(Duration min_interval, int burst) const {
        return with([=](Item& item) {
            item.admission = model::RateLimit{min_interval, static_cast<std::uint16_t>(burst)};
        });
    }
    Item repeatable() const {
        return with([](Item& item) { item.safe_to_repeat = true; });
    }
    Item verified() const {
        return with([](Item& item) { item.verify = true; });
    }
    Item holding() const {
        return with([](Item& item) { item.hold_last = true; });
    }
};

inline Item item(std::string name, DataType type, int number) {
    Item made;
    made.name = std::move(name);
    made.type = type;
    made.register_number = static_cast<std::uint16_t>(number);
    made.registers = static_cast<std::uint16_t>(register_count(type));
    made.period = 100ms;
    return made;
}
inline Item int16(std::string name, int number) {
    return item(std::move(name), DataType::int16, number);
}
inline Item real(std::string name, int number) {
    return item(std::move(name), DataType::float32, number);
}
inline Item boolean(std::string name, int number, int bit) {
    return item(std::move(name), DataType::boolean, number).with([=](Item& made) {
        made.bit = static_cast<std::uint8_t>(bit);
    });
}

inline model::Device device(int address, const std::vector<Item>& items) {
    model::Device made;
    made.poll_period = made.response_timeout = std::chrono::milliseconds(100);
    made.name = "Device" + std::to_string(address);
    made.address = UnitId{static_cast<std::uint8_t>(address)};
    made.group_requests = true;
    made.registers_per_request = 125;
    made.strategy = model::Strategy::classic;
    made.variables.assign(items.begin(), items.end());
    return made;
}

inline model::Project project(std::vector<model::Device> devices, std::vector<model::Local> locals = {}) {
    model::Project made;
    model::Line line;
    line.name = "line";
    line.format = {115200, 8, wire::Parity::none, 1};
    line.devices = std::move(devices);
    made.lines.push_back(std::move(line));
    made.locals = std::move(locals);
    return made;
}

inline model::Local local(std::string name, DataType type = DataType::boolean) {
    model::Local made;
    made.name = std::move(name);
    made.type = type;
    return made;
}

/// One device of the test: registers and coils it holds, and how it behaves.
struct Player {
    std::map<std::uint16_t, std::uint16_t> registers;
    std::map<std::uint16_t, bool> coils;
    bool dead = false;
    bool ignores_writes = false;                          ///< executes them, and does not answer
    std::optional<std::uint8_t> exception;                ///< to everything
    std::map<std::uint16_t, std::uint8_t> refuses;        ///< by start
    std::vector<std::uint16_t> silent_about;              ///< starts it never answers
    std::function<bool(const wire::Request&)> silent_to;  ///< requests that it does not receive
    std::function<std::uint16_t(std::uint16_t written)>
        keeps;                                ///< what a register becomes; empty: as written
    std::vector<model::ItemRange> lacks;      ///< reads that touch them are refused
    std::vector<model::ItemRange> chokes_on;  ///< reads that touch them are not answered
    std::size_t most_items = 2000;            ///< longer reads are refused
    std::function<bool()> refuses_now;        ///< a read, for no reason
    std::uint8_t refusal = 2;
    Duration turnaround = 3ms;
    std::vector<std::uint8_t> noise;         ///< before each answer
    std::optional<std::uint8_t> answers_as;  ///< another unit

    std::optional<wire::Response> answer(const wire::Request& request);
};

struct Sent {
    Instant t;
    std::uint8_t unit = 0;
    std::uint8_t function = 0;
    std::uint16_t start = 0;
    std::string bytes;
    std::uint16_t quantity = 0;  ///< of reads
};

struct RecordingObserver : PollObserver {
    std::vector<std::pair<Instant, DeviceState>> states;
    std::vector<std::pair<Duration, Duration>> overruns;
    std::vector<bool> overrun_flags;  ///< of `overruns`
    struct Settled {
        std::vector<std::size_t> variables;
        value::CommandResult result{};
        value::Reason reason{};
        friend bool operator==(const Settled&, const Settled&) = default;
    };
    std::vector<Settled> settled;
    std::vector<std::optional<model::LocalIndex>> triggers;  ///< of `settled`
    std::vector<std::size_t> waiting;
    std::vector<std::pair<value::Value, value::Value>> differing;  // written, read
    std::vector<GapEvent> gap_events;
    std::vector<Sending> sendings;
    std::vector<DelayFinding> delays;
    std::vector<NoiseFinding> noise;
    int surplus = 0;

    void on_verify_failed(Instant, std::size_t, std::size_t, std::size_t, const value::Value& written,
                          const value::Value& read) override {
        differing.emplace_back(written, read);
    }
    void on_device_state(Instant t, std::size_t, std::size_t, DeviceState state, value::Reason) override {
        states.emplace_back(t, state);
    }
    void on_overrun(Instant, std::size_t, std::size_t, Duration period, Duration real,
                    bool overrun) override {
        overruns.emplace_back(period, real);
        overrun_flags.push_back(overrun);
    }
    void on_group_settled(Instant, const SettledGroup& group) override {
        settled.push_back({{group.variables.begin(), group.variables.end()}, group.result, group.reason});
        triggers.push_back(group.trigger);
    }
    void on_write_waiting(Instant, std::size_t, std::size_t, std::size_t variable) override {
        waiting.push_back(variable);
    }
    void on_delays(Instant, std::size_t, std::size_t, const DelayFinding& finding) override {
        delays.push_back(finding);
    }
    void on_noise(Instant, std::size_t, std::size_t, const NoiseFinding& finding) override {
        noise.push_back(finding);
    }
    void on_surplus(Instant, std::size_t, std::size_t) override { ++surplus; }
    void on_learnt(Instant, std::size_t, const GapEvent& event) override { gap_events.push_back(event); }
    void on_sending(Instant, std::size_t, const Sending& sending) override { sendings.push_back(sending); }
};

class Bench {
public:
    explicit Bench(model::Project project);
    /// @param plan  of that project
    Bench(model::Project project, plan::Plan plan);

    /// Lets time pass up to `end`, as a driver and the devices do.
    void run_until(Duration end);
    void link(bool up);

    [[nodiscard]] const value::Slot& slot(const std::string& name) const;
    [[nodiscard]] value::SlotId id(const std::string& name) const { return *master.store().find(name); }
    Result<bool> set(const std::string& name, const value::Value& value);
    Result<bool> write(value::CommandId command, const std::string& name, const value::Value& value,
                       Duration expires = 24h * 365);
    [[nodiscard]] std::int64_t status(const std::string& name) const {
        return std::get<std::int64_t>(slot(name).value);
    }
    /// The requests sent since the last call.
    std::vector<Sent> news();

    model::Project project;
    plan::Plan plan;
    RecordingObserver observed;
    Master master;
    std::map<std::uint8_t, Player> players;
    Instant now{};
    std::vector<Sent> sent;
    std::vector<value::CommandOutcome> outcomes;
    std::vector<bus::Outcome> relayed;
    std::function<void()> after_each;  ///< called after everything that happens

private:
    Master::Options options();
    void transmit();
    void deliver();
    void collect();

    std::multimap<Instant, std::vector<std::uint8_t>> coming_;
    std::size_t seen_ = 0;
};

}  // namespace takt::poll::test
