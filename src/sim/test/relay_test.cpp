// Many clients behind one line whose devices are late, wrong or dead, while it is polled: each gets the
// answer to its own request, or an exception.
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "sim/faults/line_faults.hpp"
#include "support.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/master.hpp"
#include "takt/serve/route_table.hpp"
#include "takt/serve/tcp_connection.hpp"
#include "takt/sim/random.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::sim {
namespace relay_test {

using namespace std::chrono_literals;

constexpr std::uint16_t kRegisters = 20;
constexpr std::uint8_t kDevices = 3;
constexpr std::uint8_t kAbsent = 9;

/// Every register of every unit holds a number of its own.
struct Numbers final : ValueSource {
    [[nodiscard]] std::uint16_t item(UnitId unit, wire::Area, std::uint16_t address, Instant) const override {
        return value(unit.value, address);
    }
    static std::uint16_t value(unsigned unit, unsigned address) {
        return static_cast<std::uint16_t>(1000 * unit + address);
    }
};

model::Project project(wire::Framing framing) {
    model::Line line;
    line.name = "line";
    line.transport = model::Transport::simulated;
    line.framing = framing;
    line.format = {115200, framing == wire::Framing::ascii ? std::uint8_t{7} : std::uint8_t{8},
                   wire::Parity::even, 1};
    line.relayed = model::SharedLine{60ms};
    for (std::uint8_t address = 1; address <= kDevices; ++address) {
        model::Device device;
        device.name = "d" + std::to_string(address);
        device.address = UnitId{address};
        device.response_timeout = 60ms;
        device.backoff = model::Backoff{500ms, 2s};
        for (std::uint16_t number = 0; number < kRegisters; ++number) {
            model::Variable variable;
            variable.name = device.name + "." + std::to_string(number);
            variable.type = DataType::uint16;
            variable.register_number = number;
            variable.read = wire::Function::read_holding_registers;
            variable.period = 2s;
            device.variables.push_back(variable);
        }
        line.devices.push_back(device);
    }
    model::Project made;
    made.lines.push_back(line);
    return made;
}

/// Asks for one register after another, whenever the last answer came.
class Client {
public:
    /// @param units  that it asks, in turn; none: the devices, and sometimes a unit that does not exist
    Client(serve::Responder& responder, int number, std::vector<std::uint8_t> units = {})
        : random_(static_cast<std::uint64_t>(number) + 1),
          units_(std::move(units)),
          connection_(config(number), responder) {
        connection_.on_link(Instant{}, true);
    }

    void work(Instant t) {
        const Bytes answer = connection_.transmit(t);
        if (!answer.empty()) judge(answer);
        if (waiting_) return;
        unit_ = !units_.empty()          ? units_[static_cast<std::size_t>(asked()) % units_.size()]
                : random_.below(10) == 0 ? kAbsent
                                         : static_cast<std::uint8_t>(1 + random_.below(kDevices));
        address_ = static_cast<std::uint8_t>(random_.below(kRegisters));
        waiting_ = true;
        ++transaction_;
        const std::uint8_t request[] = {transaction_, 7, 0, 0, 0, 6, unit_, 3, 0, address_, 0, 1};
        connection_.on_bytes(t, request);
    }

    bool complete(Instant t, serve::Token token, Bytes pdu) { return connection_.complete(t, token, pdu); }

    [[nodiscard]] int asked() const { return answers + exceptions; }

    int answers = 0;
    int exceptions = 0;
    std::string wrong;

private:
    static serve::TcpConfig config(int number) {
        serve::TcpConfig made;
        made.idle_deadline = Duration::zero();
        made.peer.assign("192.0.2.1:" + std::to_string(number));
        return made;
    }

    void judge(Bytes answer) {
        waiting_ = false;
        const unsigned value = Numbers::value(unit_, address_);
        const bool mine =
            answer.size() >= 9 && answer[0] == transaction_ && answer[1] == 7 && answer[6] == unit_;
        if (mine && answer.size() == 9 && answer[7] == 0x83)
            ++exceptions;
        else if (mine && answer.size() == 11 && answer[7] == 3 && (answer[9] << 8 | answer[10]) == int(value))
            ++answers;
        else
            wrong += "unit " + std::to_string(unit_) + " register " + std::to_string(address_) + "; ";
    }

    Random random_;
    std::vector<std::uint8_t> units_;
    serve::TcpConnection connection_;
    std::uint8_t transaction_ = 0;
    std::uint8_t unit_ = 0;
    std::uint8_t address_ = 0;
    bool waiting_ = false;
};

/// A server without units of its own: every request is relayed, and its answer is pending.
class RelayingServer final : public serve::Responder {
public:
    explicit RelayingServer(serve::RouteTable routes) : routes_(std::move(routes)) {}
    [[nodiscard]] bool serves(UnitId unit) const override { return routes_.has(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override {
        const auto token = tokens_.next();
        const auto answer = routes_.ask(context, request, token);
        return answer ? serve::Answer::response(*answer) : serve::Answer::pending(token);
    }
    void forget(serve::Token token) override { routes_.forget(token); }

private:
    serve::Tokens tokens_;
    serve::RouteTable routes_;
};

/// The poller with the gateway at it, as a driver sees them.
class Shared final : public Engine {
public:
    Shared(poll::LinePoller& poller, serve::Gateway& gateway) : poller_(poller), gateway_(gateway) {}

    void on_link(Instant t, bool up) override {
        poller_.on_link(t, up);
        exchange(t);
        gateway_.on_link(up);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        poller_.on_bytes(t, bytes);
        exchange(t);
    }
    void on_tick(Instant t) override {
        poller_.on_tick(t);
        exchange(t);
    }
    Bytes transmit(Instant t) override { return poller_.transmit(t); }
    [[nodiscard]] Instant next_wakeup() const override { return poller_.next_wakeup(); }

    void exchange(Instant t) {
        while (const auto outcome = poller_.take_relayed()) gateway_.on_outcome(*outcome);
        const auto may_start = [&](UnitId unit, const bus::AnswerShape& shape) {
            return poller_.may_start_relayed(t, unit, shape);
        };
        if (gateway_.should_withdraw(may_start) && poller_.withdraw_relayed()) gateway_.on_withdrawn();
        if (!poller_.can_relay()) return;
        if (const auto next = gateway_.next(t, may_start)) {
            EXPECT_TRUE(poller_.relay(t, *next));
        }
    }

private:
    poll::LinePoller& poller_;
    serve::Gateway& gateway_;
};

struct Plant {
    Plant(wire::Framing framing, const std::optional<FaultPlan>& faults, int count)
        : Plant(project(framing), faults) {
        for (int i = 0; i < count; ++i) clients.push_back(std::make_unique<Client>(responder, i));
    }
    Plant(model::Project with, const std::optional<FaultPlan>& faults)
        : described(std::move(with)),
          plan(plan::make_plan(described)),
          master(described, plan),
          shared(master.line(0), gateway),
          responder(
              serve::RouteTable(0, {{&gateway, {.attempts = 2, .response_timeout = 60ms}, {}}}, routes())),
          line(described.lines[0], shared, options(faults)) {
        line.start(Instant{});
    }

    static std::vector<serve::Route> routes() {
        std::vector<serve::Route> all;
        for (std::uint8_t unit = 1; unit < 100; ++unit) all.push_back({UnitId{unit}, UnitId{unit}, 0});
        return all;
    }
    SimulatedLine::Options options(const std::optional<FaultPlan>& faults) {
        SimulatedLine::Options made;
        made.devices.source = &numbers;
        if (faults) made.faults = faults_of(*faults);
        return made;
    }

    void run(Duration length) {
        for (Instant t; t < Instant{} + length; t += 1ms) {
            line.advance(t);
            gateway.on_tick(t);
            while (const auto reply = gateway.take_reply())
                for (auto& client : clients)
                    if (client->complete(t, reply->token, reply->pdu.span())) break;
            for (auto& client : clients) client->work(t);
            shared.exchange(t);
        }
    }

    Numbers numbers;
    model::Project described;
    plan::Plan plan;
    poll::Master master;
    serve::Gateway gateway;
    Shared shared;
    RelayingServer responder;
    SimulatedLine line;
    std::vector<std::unique_ptr<Client>> clients;
};

void expect_right_values(const Plant& plant) {
    for (std::uint32_t slot = 0; slot < plant.master.store().size(); ++slot) {
        const auto& value = plant.master.store()[value::SlotId{slot}];
        if (value.quality != value::Quality::good) continue;
        EXPECT_EQ(std::get<std::uint64_t>(value.value),
                  std::uint64_t{Numbers::value(1 + slot / kRegisters, slot % kRegisters)});
    }
}

TEST(RelayOnABus, EveryClientGetsItsAnswersBesidePolling) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii}) {
        Plant plant(framing, std::nullopt, 5);
        plant.run(10s);
        for (const auto& client : plant.clients) {
            EXPECT_EQ(client->wrong, "");
            EXPECT_GT(client->answers, 30);
            EXPECT_GT(client->exceptions, 0) << "the unit that is not there";
            EXPECT_LT(std::abs(client->asked() - plant.clients[0]->asked()), client->asked() / 5) << "fair";
        }
        EXPECT_EQ(plant.gateway.counters().no_path, 0u);
        expect_right_values(plant);
    }
}

/// Five clients for 40 s on a line where each kind of fault strikes one frame in a hundred.
/// @param late  responses of a million that are late
/// @returns the answers that the clients got
int answers_of_a_bad_line(wire::Framing framing, std::uint64_t seed, std::uint32_t late) {
    FaultPlan faults;
    faults.seed = seed;
    faults.rates = FaultRates::all(10'000, 20s);
    faults.rates.set(FaultKind::late_response, late);
    // Nothing in the frame shows that it is a copy.
    faults.rates.set(FaultKind::duplicate_response, 0).set(FaultKind::past_response, 0);
    faults.dead = {200ms, 2s};
    faults.unplugged = {100ms, 1s};
    faults.jump = {200ms, 500ms};
    Plant plant(framing, faults, 5);
    plant.run(40s);
    int answers = 0;
    for (const auto& client : plant.clients) {
        EXPECT_EQ(client->wrong, "");
        answers += client->answers;
    }
    EXPECT_EQ(fault_counts(plant.line).of(FaultKind::late_response) > 5u, late > 0);
    EXPECT_GT(plant.gateway.counters().no_answer, 0u);
    expect_right_values(plant);
    return answers;
}

// A response is late by up to 40 time-outs (2.4 s), and a device works on one request after the other. So the
// devices are silent, and back off, for half to two thirds of the time. For a sixth to a third of it requests
// are held: those of clients all look alike, and none may be altered. Without late responses the same line
// gives several times as many answers. One seed gives a tenth of the answers of another.
TEST(RelayOnABus, LateWrongAndDeadDevicesNeverLeadToAnothersAnswer) {
    int answers = 0;
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii})
        for (std::uint64_t seed = 1; seed <= 3; ++seed)
            answers += answers_of_a_bad_line(framing, seed, 60'000);
    EXPECT_GT(answers, 90);
}

TEST(RelayOnABus, WrongAndDeadDevicesWithoutLateResponsesLeaveTimeForAnswers) {
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii})
        EXPECT_GT(answers_of_a_bad_line(framing, 1, 0), 60);
}

// Clients that never pause leave the line to polling
// -------------------------------------------------------------------------------------------------

/// One device with one value.
model::Project small(std::uint32_t baud, Duration period, Duration interval) {
    auto made = project(wire::Framing::rtu);
    auto& line = made.lines[0];
    line.format = {baud, 8, wire::Parity::none, 1};
    line.relay_interval = interval;
    line.relayed = model::SharedLine{100ms};
    line.devices.resize(1);
    line.devices[0].response_timeout = 100ms;
    line.devices[0].variables.resize(1);
    line.devices[0].variables[0].period = period;
    return made;
}

std::uint64_t polls(const Plant& plant) {
    return plant.master.line(0).request(0).counters.sent;
}

TEST(PollingBesideClients, TwoThatAskAbsentUnits) {
    Plant plant(small(115200, 100ms, 1s), std::nullopt);
    for (int i = 0; i < 2; ++i)
        plant.clients.push_back(
            std::make_unique<Client>(plant.responder, i, std::vector<std::uint8_t>{50, 51, 52}));
    plant.run(45s);
    RecordProperty("polls", static_cast<int>(polls(plant)));
    EXPECT_GE(polls(plant), 430u) << "of 450";
    EXPECT_EQ(plant.master.store()[value::SlotId{0}].quality, value::Quality::good);
    for (const auto& client : plant.clients)
        EXPECT_GT(client->exceptions, 1000) << "most are answered at once";
    EXPECT_LT(plant.gateway.counters().sent, 40u) << "the back-off";
}

TEST(PollingBesideClients, AHealthyUnitOnASlowLineAndAShortInterval) {
    Plant plant(small(9600, 1s, 20ms), std::nullopt);
    for (int i = 0; i < 3; ++i)
        plant.clients.push_back(std::make_unique<Client>(plant.responder, i, std::vector<std::uint8_t>{1}));
    plant.run(40s);
    RecordProperty("polls", static_cast<int>(polls(plant)));
    EXPECT_GE(polls(plant), 39u) << "of 40";
    for (const auto& client : plant.clients) EXPECT_GT(client->asked(), 200);
    EXPECT_EQ(plant.gateway.counters().no_answer, 0u);
}

TEST(PollingBesideClients, OnALineThatPollingFills) {
    Plant plant(small(9600, 20ms, 20ms), std::nullopt);
    for (int i = 0; i < 3; ++i)
        plant.clients.push_back(std::make_unique<Client>(plant.responder, i, std::vector<std::uint8_t>{1}));
    plant.run(40s);
    const auto sent = plant.gateway.counters().sent;
    EXPECT_GE(polls(plant), sent) << "at least one between two of theirs";
    EXPECT_GT(sent, 400u) << "they have their share";
}

}  // namespace relay_test
}  // namespace takt::sim
