#include "world.hpp"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>

#include "bus.hpp"
#include "disk.hpp"
#include "gateway.hpp"
#include "judge/judge.hpp"
#include "network.hpp"
#include "scenario.hpp"
#include "senders.hpp"

namespace takt::gatewaysim {
namespace {

using namespace std::chrono_literals;

class World {
public:
    World(const Scenario& scenario, const Settings& settings);
    RunResult run();

private:
    enum class End : std::uint8_t { kill, power_cut, orderly };
    /// An event that repeats at random intervals until the quiet time.
    struct Timer {
        Duration mean;
        Instant next;
        std::function<void()> act;
    };
    /// Something that goes on for a while.
    struct Spell {
        Instant end = kNever;
        std::function<void()> over;
    };

    void add_timers();
    void add_disk_timers();
    void add_network_timers();
    void add(Duration mean, std::function<void()> act);
    void begin_spell(Duration length, std::function<void()> over) {
        spells_.push_back({clock_.now + length, std::move(over)});
    }

    /// A length, mostly a short one.
    [[nodiscard]] Duration spell_of(Duration most) {
        return random_.between(100ms, random_.below(3) == 0 ? most : most / 8);
    }

    [[nodiscard]] Instant next() const;
    void step();
    void step_program();
    void run_troubles();
    void begin_quiet();
    void start_program();
    void die(End end);
    void decay();
    void end_program(End end);
    void note(const char* what) {
        complaints_.count(what);
        complaints_.trace(clock_.now, [&] { return std::string("*** ") + what; });
    }

    const Scenario& scenario_;
    Clock clock_;
    Complaints complaints_;
    sim::Random random_;
    Judge judge_;
    Disk disk_;
    Network network_;
    Bus bus_;
    Senders senders_;
    std::unique_ptr<Gateway> gateway_;

    std::vector<Timer> timers_;
    std::vector<Spell> spells_;
    Instant restart_at_ = kNever;
    std::optional<End> armed_;  // the program ends at one of the next operations of the disk
    Instant armed_until_ = kNever;
    bool power_was_cut_ = false;
    bool quiet_ = false;
    bool progress_checked_ = false;
    int decays_ = 0;
    std::uint64_t failures_at_stop_ = 0;
    std::uint64_t steps_ = 0;
};

World::World(const Scenario& scenario, const Settings& settings)
    : scenario_(scenario),
      clock_{.now = scenario.begin},
      complaints_(settings.trace),
      random_(sim::Random(scenario.seed).fork(0x3A17)),
      judge_(scenario, clock_, complaints_),
      disk_(scenario.seed, judge_.disk(), complaints_),
      network_(scenario, clock_, judge_, complaints_),
      bus_(scenario,
           [this](std::uint32_t value, Instant ordered_at) { judge_.on_written(value, ordered_at); }),
      senders_(scenario, [this](const SentCommand& command) {
          judge_.on_sent(command);
          network_.publish_command(command.message);
      }) {
    network_.set_death([this] { return disk_.crashed(); });
    add_timers();
    add_disk_timers();
    add_network_timers();
    restart_at_ = clock_.now;
}

void World::add(Duration mean, std::function<void()> act) {
    if (mean > Duration{})
        timers_.push_back({mean, clock_.now + random_.between(0ms, 2 * mean), std::move(act)});
}

void World::add_timers() {
    const auto& means = scenario_.means;
    add(means.kill, [this] { die(End::kill); });
    add(means.power_cut, [this] { die(End::power_cut); });
    add(means.orderly_stop, [this] {
        if (!gateway_) return;
        note("orderly_stop");
        failures_at_stop_ = disk_.failures();
        judge_.on_stopping();
        gateway_->begin_stop();
    });
    add(means.clock_jump, [this] {
        note("clock_jump");
        const auto most = random_.below(3) == 0 ? Duration(2h) : Duration(5s);
        clock_.wall_offset_ns += random_.between(-most, most).count();
    });
    add(means.sampler_stalls, [this] {
        note("sampler_stalls");
        if (gateway_) gateway_->stall_sampler(clock_.now + spell_of(20s));
    });
    add(means.output_stalls, [this] {
        note("output_stalls");
        if (gateway_) gateway_->stall_output(clock_.now + spell_of(20s));
    });
}

void World::add_disk_timers() {
    const auto& means = scenario_.means;
    const auto mood = [this](Duration mean, Disk::Mood which, const char* what) {
        add(mean, [this, which, what] {
            note(what);
            disk_.set_mood(which);
            begin_spell(spell_of(40s), [this] { disk_.set_mood(Disk::Mood::good); });
        });
    };
    mood(means.disk_fails, Disk::Mood::fails, "disk_fails");
    mood(means.disk_full, Disk::Mood::full, "disk_fills_up");
    mood(means.disk_slow, Disk::Mood::slow, "disk_slow");
    add(means.single_failure, [this] { disk_.fail_once(); });
    if (scenario_.damage) add(300ms, [this] { decay(); });
}

void World::add_network_timers() {
    const auto& means = scenario_.means;
    const auto any = [this] { return random_.below(static_cast<std::uint32_t>(network_.brokers())); };
    const auto leave = [this](std::size_t broker, Duration length) {
        network_.set_away(broker, true);
        begin_spell(length, [this, broker] { network_.set_away(broker, false); });
    };
    add(means.broker_away, [this, any, leave] {
        note("broker_away");
        leave(any(), spell_of(60s));
    });
    add(means.broker_forgets, [this, any, leave] {
        note("broker_forgets");
        const auto broker = any();
        network_.forget(broker);
        leave(broker, random_.between(10ms, 3s));
    });
    add(means.half_open, [this] { network_.make_half_open(); });
    add(means.cut, [this] { network_.cut({publish::MqttFailureKind::lost, {}, {}}); });
    add(means.taken_over, [this] { network_.take_over(); });
}

// Damages a record of which the broker has a part. The program reads it again on the next connection.
void World::decay() {
    constexpr int kMost = 3;
    const auto* record = judge_.partly_delivered();
    if (!gateway_ || decays_ == kMost || record == nullptr) return;
    ++decays_;
    note("decayed");
    disk_.damage_record(record->segment, record->facts.sequence);
    judge_.on_decay(record->facts.sequence);
    network_.cut({publish::MqttFailureKind::lost, {}, {}});
}

// Half of the ends come at an operation of the disk, the others at any time.
void World::die(End end) {
    if (!gateway_ || armed_) return;
    if (random_.below(2) == 0) return end_program(end);
    armed_ = end;
    armed_until_ = clock_.now + 2s;
    disk_.arm_crash(static_cast<int>(random_.below(12)));
}

void World::end_program(End end) {
    note(end == End::orderly ? "stopped" : end == End::kill ? "killed" : "power_cut");
    if (end == End::orderly) judge_.on_status(gateway_->status());
    gateway_.reset();
    network_.on_process_ended();
    judge_.on_run_end(end == End::orderly && disk_.failures() == failures_at_stop_);
    power_was_cut_ = end == End::power_cut;
    if (power_was_cut_)
        disk_.cut_power();
    else
        disk_.kill();
    armed_.reset();
    armed_until_ = kNever;
    restart_at_ = clock_.now + (quiet_ ? Duration(10ms) : random_.between(10ms, 10s));
}

void World::start_program() {
    restart_at_ = kNever;
    bool damaged = false;
    if (scenario_.damage && power_was_cut_ && random_.below(2) == 0) {
        damaged = true;
        note("damaged");
        if (random_.below(3) == 0)
            disk_.damage_cursor("cloud", random_.below(2) == 0);
        else
            static_cast<void>(disk_.damage_segment());
    }
    judge_.on_run_begin(disk_, damaged);
    note("start");
    gateway_ = std::make_unique<Gateway>(scenario_, clock_, bus_, disk_, network_, judge_, random_.next());
}

Instant World::next() const {
    Instant next = std::min({restart_at_, armed_until_, senders_.next(), network_.next_event(),
                             bus_.next_wakeup(), quiet_ ? scenario_.end : scenario_.quiet_from});
    for (const auto& timer : timers_) next = std::min(next, timer.next);
    for (const auto& spell : spells_) next = std::min(next, spell.end);
    if (gateway_) next = std::min(next, gateway_->next_step());
    if (quiet_ && !progress_checked_) next = std::min(next, scenario_.quiet_from + kProgress);
    return next;
}

void World::step() {
    ++steps_;
    if (bus_.next_wakeup() <= clock_.now) {
        bus_.advance(clock_.now);
        if (gateway_) gateway_->after_lines();
    }
    if (network_.next_event() <= clock_.now) network_.advance();
    if (senders_.next() <= clock_.now) senders_.act(clock_.now, Clock{.now = clock_.now}.wall_ns());
    if (!quiet_) run_troubles();
    if (restart_at_ <= clock_.now) start_program();
    if (gateway_) step_program();
    if (quiet_ && !progress_checked_ && clock_.now >= scenario_.quiet_from + kProgress) {
        progress_checked_ = true;
        judge_.check_progress(scenario_.quiet_from);
    }
}

void World::step_program() {
    const bool stepped = gateway_->step();
    if (disk_.crashed() && armed_) {
        complaints_.count("crashed_at_operation");
        return end_program(*armed_);
    }
    if (armed_until_ <= clock_.now) return end_program(*armed_);
    if (stepped) judge_.on_status(gateway_->status());
    if (gateway_->is_stopped()) end_program(End::orderly);
}

void World::run_troubles() {
    for (auto& timer : timers_) {
        if (timer.next > clock_.now) continue;
        timer.next = clock_.now + random_.between(1ms, 2 * timer.mean);
        timer.act();
    }
    for (std::size_t i = 0; i < spells_.size();) {
        if (spells_[i].end > clock_.now) {
            ++i;
            continue;
        }
        auto over = std::move(spells_[i].over);
        spells_.erase(spells_.begin() + static_cast<std::ptrdiff_t>(i));
        over();
    }
    if (clock_.now >= scenario_.quiet_from) begin_quiet();
}

void World::begin_quiet() {
    quiet_ = true;
    timers_.clear();
    spells_.clear();
    disk_.set_mood(Disk::Mood::good);
    disk_.disarm_crash();
    armed_.reset();
    armed_until_ = kNever;
    network_.end_troubles();
    if (restart_at_ != kNever) restart_at_ = std::min(restart_at_, clock_.now + 10ms);
    if (gateway_) gateway_->stall_sampler(clock_.now);
    if (gateway_) gateway_->stall_output(clock_.now);
    complaints_.trace(clock_.now, [] { return "*** quiet"; });
}

RunResult World::run() {
    while (!complaints_.any()) {
        clock_.now = std::max(clock_.now, next());
        if (quiet_ && clock_.now >= scenario_.end) break;
        step();
    }
    if (!complaints_.any()) judge_.check_progress(scenario_.end - 5s);
    // A command may wait for its expiry, at most 20 s, where the interval of its variable is that long.
    if (!complaints_.any()) judge_.finish(scenario_.quiet_from + 15s, scenario_.end - 25s);
    RunResult result{.seed = scenario_.seed, .hash = judge_.hash(), .counts = complaints_.counts()};
    result.counts["steps"] = steps_;
    result.counts["frames"] = bus_.frames();
    result.violations = complaints_.all();
    return result;
}

}  // namespace

RunResult run(const Settings& settings) {
    const Scenario scenario = draw_scenario(settings.seed, settings.length);
    if (scenario.error.empty()) return World(scenario, settings).run();
    RunResult result{.seed = settings.seed};
    result.violations.push_back({"legal", scenario.begin, "a legal project", scenario.error});
    return result;
}

}  // namespace takt::gatewaysim
