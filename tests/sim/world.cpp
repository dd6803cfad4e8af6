#include "world.hpp"

#include <malloc.h>

#include <algorithm>
#include <utility>

#include "blueprint.hpp"
#include "hash.hpp"
#include "judge/frames.hpp"
#include "judge/limits.hpp"
#include "sim/faults/line_faults.hpp"
#include "takt/plan/guarantee.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/proof.hpp"
#include "trace.hpp"
#include "troubles.hpp"

namespace takt::simtest {
namespace {

using namespace std::chrono_literals;

constexpr std::uint16_t kRelayedStart = 60'000;  // of relayed reads; no device of a case has it

constexpr std::size_t kFrames = 40;
constexpr Duration kBacklog = 120s;  // a full queue of commands, one each command_interval

#if defined(__SANITIZE_ADDRESS__)
std::size_t heap_in_use() {
    return 0;
}
#else
std::size_t heap_in_use() {
    return mallinfo2().uordblks;
}
#endif

/// The guarantees of a plan, which gets the proved ages.
std::vector<plan::LineGuarantee> prove(const model::Project& project, plan::Plan& plan) {
    auto guarantees = plan::guarantee(project, plan);
    plan::put_ages(plan, guarantees);
    return guarantees;
}

class World;

/// The master's port on one line: all bytes pass through it and are reported to the judge.
class Port final : public Engine, public sim::DeviceObserver, public sim::FaultObserver {
public:
    Port(World& world, std::size_t line) : world_(world), line_(line) {}

    void on_link(Instant t, bool up) override;
    void on_close(Instant t) override;
    [[nodiscard]] std::optional<Instant> opens_at() const override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    void on_read(const sim::DeviceItems& items) override;
    void on_write(const sim::DeviceItems& items) override;
    void on_change(const sim::DeviceItems&) override {}
    void on_fault(const sim::FaultEvent& event) override;

private:
    World& world_;
    std::size_t line_;
};

class World final : public poll::PollObserver {
public:
    World(const model::Project& project, const Run& settings);
    Result run();

    // Called by the ports.
    void look(std::size_t line, Instant t);
    void note_frame(std::size_t line, Instant t, bool sent, Bytes bytes);
    [[nodiscard]] poll::LinePoller& poller(std::size_t line) { return master_.line(line); }
    [[nodiscard]] judge::LineJudge& judge(std::size_t line) { return *judges_[line]; }
    void note_fault(std::size_t line, const sim::FaultEvent& event);
    void note_link(std::size_t line, Instant t, std::string_view state) { trace_.link(t, line, state); }
    void relay(std::size_t line, Instant t);
    void take_relayed(std::size_t line);
    [[nodiscard]] bool relays(std::size_t line) const { return relayed_[line]; }
    [[nodiscard]] bool is_relayed(std::size_t line, Bytes frame) const {
        const auto asked = judge::parse_request(project_.lines[line].framing, frame);
        return asked && asked->read_start == kRelayedStart;
    }
    void look_at_plan(std::size_t line, Instant t);
    [[nodiscard]] std::optional<judge::Claim> take_claim(std::size_t line) {
        return std::exchange(claims_[line], std::nullopt);
    }

    void on_sending(Instant t, std::size_t line, const poll::Sending& sending) override;
    void on_device_state(Instant, std::size_t, std::size_t, poll::DeviceState, value::Reason) override {}
    void on_overrun(Instant, std::size_t, std::size_t, Duration, Duration, bool) override {}
    void on_write_waiting(Instant, std::size_t, std::size_t, std::size_t) override {}

private:
    [[nodiscard]] poll::Master::Options master_options();
    void add_line(std::size_t index);
    void act(Instant t);
    void perform(Instant t, const Action& action);
    void take_outcomes(std::size_t line, Instant t);
    [[nodiscard]] bool prolong(Instant next);
    void finish();

    const model::Project& project_;
    const Run& settings_;
    Instant end_;
    Instant quiet_from_;
    Instant latest_end_;
    Instant last_outcome_;
    plan::Plan plan_;
    std::vector<plan::LineGuarantee> guarantees_;
    std::vector<const plan::Request*> plans_;          // by line: which one is judged
    std::vector<std::optional<judge::Claim>> claims_;  // by line: the claim about the next transaction
    poll::Master master_;
    judge::Complaints complaints_;
    judge::Case case_;
    Plant plant_;
    Users users_;
    std::vector<std::unique_ptr<judge::LineJudge>> judges_;
    std::vector<std::unique_ptr<Port>> ports_;
    std::vector<std::unique_ptr<sim::SimulatedLine>> lines_;
    std::vector<std::uint32_t> first_slots_;
    std::vector<std::uint64_t> ended_;  // scratch
    std::vector<sim::Random> clients_;  // by line: of what is relayed to it
    std::vector<bool> relayed_;         // by line: a relayed request is with the master
    std::vector<Instant> asked_at_;     // by line: of the last relayed request
    value::EventCursor cursor_;
    Hash hash_;
    Result result_;
    std::deque<Frame> frames_;
    judge::Limits limits_{complaints_};
    Trace trace_;
    std::size_t heap_then_ = 0;
};

// In some runs the gaps are learnt, and the plan follows; else exactly one plan is judged.
poll::Master::Options World::master_options() {
    poll::Master::Options options;
    options.learn = gaps_are_learnt(settings_.seed);
    options.observer = this;
    return options;
}

void World::look_at_plan(std::size_t line, Instant t) {
    const auto& plan = master_.line(line).plan();
    if (!master_.line(line).learns() || plans_[line] == plan.requests.data()) return;
    plans_[line] = plan.requests.data();
    judges_[line]->on_plan(t, plan);
}

World::World(const model::Project& project, const Run& settings)
    : project_(project),
      settings_(settings),
      end_(Instant{} + settings.length),
      quiet_from_(end_ - std::min(quiet_time(project), settings.length)),
      latest_end_(end_ + kBacklog),
      plan_(plan::make_plan(project)),
      guarantees_(prove(project, plan_)),
      plans_(project.lines.size()),
      claims_(project.lines.size()),
      master_(project, plan_, master_options()),
      case_{project_, plan_, guarantees_},
      plant_(settings.seed, 50ms),
      users_(settings.seed, project, master_.slots(), quiet_from_),
      trace_(settings.trace) {
    result_.seed = settings.seed;
    relayed_.resize(project.lines.size());
    asked_at_.resize(project.lines.size(), Instant::min());
    for (std::size_t i = 0; i < project.lines.size(); ++i)
        clients_.push_back(sim::Random(settings.seed).fork(0xC11E + i));
    for (std::size_t i = 0; i < project.lines.size(); ++i) add_line(i);
}

void World::add_line(std::size_t index) {
    const model::Line& line = project_.lines[index];
    const Adapter adapter = adapter_of(line, settings_.seed, index);
    judges_.push_back(std::make_unique<judge::LineJudge>(case_, index, complaints_,
                                                         judge::Adapter{adapter.echoes, adapter.chunk > 0}));
    look_at_plan(index, Instant{});
    ports_.push_back(std::make_unique<Port>(*this, index));
    first_slots_.push_back(line.devices.empty() || line.devices[0].variables.empty()
                               ? 0
                               : master_.slots().variable({index, 0, 0}).value);
    sim::SimulatedLine::Options options;
    options.chunk = adapter.chunk;
    options.receives_echo = adapter.echoes;
    if (adapter.echoes) ++result_.recoveries["line_with_echo"];
    if (adapter.chunk > 0) ++result_.recoveries["line_in_lumps"];
    options.devices.source = &plant_;
    options.faults = sim::faults_of(fault_plan(project_, settings_, index, quiet_from_), ports_.back().get());
    options.device_observer = ports_.back().get();
    options.must_reconnect = [this, index] { return master_.line(index).must_reconnect(); };
    lines_.push_back(std::make_unique<sim::SimulatedLine>(line, *ports_.back(), options));
}

void World::perform(Instant t, const Action& action) {
    trace_.action(t, action, master_.store().info(action.slot).name, result_.commands + 1);
    const auto owner = master_.slots().owner(action.slot);
    hash_.add(action.value);
    if (const auto* local = std::get_if<model::LocalIndex>(&owner)) {
        const auto* before = std::get_if<bool>(&master_.store()[action.slot].value);
        for (auto& judge : judges_)
            judge->on_local(t, *local, before && *before, std::get<bool>(action.value));
        (void)master_.set(t, action.slot, action.value);
        for (std::size_t line = 0; line < lines_.size(); ++line) look(line, t);
        return;
    }
    const auto index = std::get<value::VariableIndex>(owner);
    auto& judge = *judges_[index.line];
    const auto variable = judge.number_of(index.device, index.variable);
    if (action.kind == Action::Kind::set) {
        if (master_.set(t, action.slot, action.value)) judge.on_set(t, variable, action.value);
        take_outcomes(index.line, t);
        return;
    }
    const value::WriteCommand command{++result_.commands, action.slot, action.value, action.expires};
    if (master_.write(t, command))
        judge.on_command(t, command, variable);
    else
        ++result_.recoveries["command_queue_full"];
    take_outcomes(index.line, t);
}

void World::act(Instant t) {
    for (const Action& action : users_.act()) perform(t, action);
    for (auto& line : lines_) line->advance(t);
}

void World::take_outcomes(std::size_t line, Instant t) {
    while (const auto outcome = master_.line(line).take_outcome()) {
        last_outcome_ = t;
        hash_.add(outcome->id * 8 + static_cast<std::uint64_t>(outcome->result));
        ++result_.recoveries["command_" + std::string(name(outcome->result))];
        trace_.outcome(t, line, *outcome);
        judges_[line]->on_outcome(t, *outcome);
    }
}

void World::look(std::size_t line, Instant t) {
    take_outcomes(line, t);
    take_relayed(line);
    ended_.clear();
    for (std::size_t d = 0; d < project_.lines[line].devices.size(); ++d)
        ended_.push_back(master_.line(line).device(d).counters.sent);
    judges_[line]->look(t, master_.store(), first_slots_[line], ended_);
    while (const auto* event = master_.store().next_event(cursor_)) {
        for (std::size_t i = 0; i < judges_.size(); ++i) judges_[i]->on_event(t, *event, first_slots_[i]);
        hash_.add(event->t);
        hash_.add(event->value);
        hash_.add(std::uint64_t{event->slot.value} << 16U | static_cast<std::uint64_t>(event->reason));
    }
}

// Clients that never pause: at each instant there is a further request, most of them to units that are not
// there. (A second one at the same instant would go on for ever where requests are refused at once.)
void World::relay(std::size_t line, Instant t) {
    const auto& shared = project_.lines[line].relayed;
    if (!shared || t >= quiet_from_ || t == asked_at_[line] || !master_.line(line).can_relay()) return;
    asked_at_[line] = t;
    auto& random = clients_[line];
    constexpr std::uint8_t kAbsent = 200;
    const auto& devices = project_.lines[line].devices;
    UnitId unit{static_cast<std::uint8_t>(kAbsent + random.below(20))};
    if (random.below(4) == 0 && !devices.empty())
        unit = devices[random.below(static_cast<std::uint32_t>(devices.size()))].address;
    if (unit.value == 0) unit = UnitId{kAbsent};
    const wire::ReadRequest read{wire::Function::read_holding_registers, DataAddress{kRelayedStart},
                                 static_cast<std::uint16_t>(1 + random.below(125))};
    const auto prepared = wire::prepare(read);
    if (master_.line(line).relay(
            t, {.id = 1, .unit = unit, .request = *prepared, .wait = shared->response_timeout}))
        relayed_[line] = true;
}

void World::take_relayed(std::size_t line) {
    const auto outcome = master_.line(line).take_relayed();
    if (!outcome) return;
    relayed_[line] = false;
    if (outcome->sent) judges_[line]->on_relayed_end(*outcome);
    ++result_.recoveries["relayed_" + std::string(bus::name(outcome->status))];
}

void World::note_frame(std::size_t line, Instant t, bool sent, Bytes bytes) {
    hash_.add(t);
    hash_.add(bytes);
    ++result_.frames;
    if (complaints_.any()) return;
    if (frames_.size() == kFrames) {
        frames_.push_back(std::move(frames_.front()));  // its buffer is used again
        frames_.pop_front();
    } else {
        frames_.emplace_back();
    }
    Frame& frame = frames_.back();
    frame.t = t;
    frame.line = line;
    frame.sent = sent;
    frame.bytes.assign(bytes.begin(), bytes.end());
    trace_.frame(t, line, sent, bytes);
}

void World::on_sending(Instant t, std::size_t line, const poll::Sending& sending) {
    if (claims_[line]) judges_[line]->on_unsent(*claims_[line]);
    claims_[line] = judge::Claim{t, sending};
    trace_.sending(t, line, sending);
}

void World::note_fault(std::size_t line, const sim::FaultEvent& event) {
    judges_[line]->on_fault(event);
    trace_.fault(line, event);
}

void World::finish() {
    for (std::size_t line = 0; line < lines_.size(); ++line) {
        look(line, end_);
        judges_[line]->finish(end_, master_.store(), first_slots_[line]);
    }
    limits_.end(end_, heap_then_, heap_in_use());
}

// Commands that users gave before the quiet time are finished first.
bool World::prolong(Instant next) {
    end_ = std::max(end_, std::min(last_outcome_ + quiet_time(project_), latest_end_));
    return next <= end_;
}

Result World::run() {
    for (auto& line : lines_) line->start(Instant{});
    while (!complaints_.any()) {
        Instant next = users_.next();
        for (const auto& line : lines_) next = std::min(next, line->next_wakeup());
        if (next > end_ && !prolong(next)) break;
        for (auto& line : lines_)
            if (line->next_wakeup() <= next) line->advance(next);
        if (users_.next() <= next) act(next);
        ++result_.steps;
        if (limits_.step(next)) heap_then_ = heap_in_use();
    }
    if (!complaints_.any()) finish();
    for (const auto& line : lines_) result_.faults += sim::fault_counts(*line);
    for (const auto& judge : judges_)
        for (const auto& [kind, count] : judge->recoveries()) result_.recoveries[std::string(kind)] += count;
    for (std::size_t line = 0; line < lines_.size(); ++line) {
        const auto counters = master_.line(line).statistics(end_).counters;
        for (std::size_t d = 0; d < project_.lines[line].devices.size(); ++d) {
            const auto& device = master_.line(line).device(d);
            result_.recoveries["verify_equal"] += device.verified;
            result_.recoveries["verify_differed"] += device.differed;
        }
        result_.recoveries["late_recognised"] += counters.late_answers;
        result_.recoveries["foreign_dropped"] += counters.foreign_frames;
    }
    result_.violations = complaints_.all();
    result_.last_frames.assign(frames_.begin(), frames_.end());
    hash_.add(result_.frames);
    result_.hash = hash_.value();
    return std::move(result_);
}

void Port::on_link(Instant t, bool up) {
    world_.note_link(line_, t, up ? "up" : "lost");
    world_.judge(line_).on_link(t, up);
    world_.poller(line_).on_link(t, up);
    world_.look(line_, t);
}

void Port::on_close(Instant t) {
    world_.note_link(line_, t, "closed");
    world_.judge(line_).on_close(t);
    world_.poller(line_).on_close(t);
    world_.look(line_, t);
}

std::optional<Instant> Port::opens_at() const {
    return world_.poller(line_).opens_at();
}

void Port::on_bytes(Instant t, Bytes bytes) {
    world_.note_frame(line_, t, false, bytes);
    world_.judge(line_).on_heard(t, bytes);
    world_.poller(line_).on_bytes(t, bytes);
    world_.look(line_, t);
}

void Port::on_tick(Instant t) {
    world_.poller(line_).on_tick(t);
    world_.look(line_, t);
}

Bytes Port::transmit(Instant t) {
    world_.relay(line_, t);
    const Bytes bytes = world_.poller(line_).transmit(t);
    world_.look_at_plan(line_, t);
    if (bytes.empty()) return bytes;
    world_.note_frame(line_, t, true, bytes);
    const auto claim = world_.take_claim(line_);
    const bool relayed = world_.relays(line_) && (!claim || world_.is_relayed(line_, bytes));
    if (!relayed) {
        world_.judge(line_).on_sent(t, bytes, claim);
        return bytes;
    }
    // The claim of a transaction that ended without being sent.
    if (claim) world_.judge(line_).on_unsent(*claim);
    world_.judge(line_).on_relayed(t, bytes);
    return bytes;
}

Instant Port::next_wakeup() const {
    return world_.poller(line_).next_wakeup();
}

void Port::on_read(const sim::DeviceItems& items) {
    world_.judge(line_).on_read(items);
}

void Port::on_write(const sim::DeviceItems& items) {
    world_.judge(line_).on_write(items);
}

void Port::on_fault(const sim::FaultEvent& event) {
    world_.note_fault(line_, event);
}

}  // namespace

Duration quiet_time(const model::Project& project) {
    constexpr Duration kBusy = 11s;  // the longest patience with a busy device
    Duration longest = project.backoff.limit;
    Duration period{};
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) {
            if (device.backoff) longest = std::max(longest, device.backoff->limit);
            for (const auto& variable : device.variables) period = std::max(period, variable.period);
        }
    return longest + kBusy + 2 * period + 3s;
}

Result run(const model::Project& project, const Run& settings) {
    return World(project, settings).run();
}

}  // namespace takt::simtest
