#include "takt/app/running.hpp"

#include <utility>

#include "takt/line/real_line.hpp"
#include "waiting_set.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTellAfter = 5ms;
constexpr Duration kRefreshEvery = 200ms;

}  // namespace

/// Between a driver and its poller: notices that something may have happened.
class Running::Tap final : public Engine {
public:
    Tap(Running& running, std::size_t line)
        : running_(running), engine_(running.master_->line(line)), line_(line) {}

    void on_link(Instant t, bool up) override {
        engine_.on_link(t, up);
        told(t);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        engine_.on_bytes(t, bytes);
        told(t);
    }
    void on_tick(Instant t) override {
        engine_.on_tick(t);
        told(t);
    }
    Bytes transmit(Instant t) override { return engine_.transmit(t); }
    Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    void told(Instant t) {
        if (running_.watcher_) running_.watcher_(t, line_);
        running_.tell_soon(t);
    }

    Running& running_;
    Engine& engine_;
    std::size_t line_;
};

Running::Running(line::Loop& loop, const model::Project& project, const plan::Plan& plan, const Texts& texts,
                 TrafficLog* traffic, Keepers keepers)
    : loop_(loop),
      gate_(loop),
      project_(project),
      plan_(plan),
      texts_(texts),
      traffic_(traffic),
      log_(log("run")),
      start_(line::now()),
      lines_(project.lines.size()),
      retention_(std::move(keepers.retention)),
      learner_(std::move(keepers.learner)),
      tell_timer_(loop, [this](Instant) { tell(); }),
      refresh_timer_(loop, [this](Instant t) {
          give_up_sets([t](value::SlotId, const WaitingSet& set) { return set.until <= t; });
          // A driver whose line is not open has no wake-ups; commands expire all the same.
          for (auto& line : lines_)
              if (line.tap && !line.up) line.tap->on_tick(t);
          reporter_->refresh(t);
          refresh_timer_.set(after(t, kRefreshEvery));
      }) {
    poll::Master::Options options;
    options.observer = this;
    for (std::size_t i = 0; i < lines_.size() && traffic_; ++i) {
        lines_[i].traffic =
            std::make_unique<LineTraffic>(*traffic_, project_.lines[i], LineTraffic::Side::master);
        options.line_traffic.push_back(lines_[i].traffic.get());
    }
    for (const auto& line : project_.lines)
        options.line_bus.emplace_back(line::fit_to_real_line(poll::line_config(project_, line), line));
    if (retention_) options.restored = retention_->restored();
    options.restored_at = start_;
    options.learn = learner_ != nullptr;
    options.plan_maker = learner_.get();
    master_ = std::make_unique<poll::Master>(project_, plan_, options);
    if (learner_) learner_->follow(*master_, [this](std::size_t line) { poke_line(line); });
    if (retention_) retention_->follow(master_->store());
}

Running::~Running() = default;

Result<void> Running::begin(Reporter& reporter, const Prepare& prepare) {
    reporter_ = &reporter;
    for (std::size_t i = 0; i < lines_.size(); ++i) TAKT_CHECK(open(i, prepare));
    refresh_timer_.set(line::now());
    tell_soon(line::now());
    return {};
}

Result<void> Running::open(std::size_t index, const Prepare& prepare) {
    const auto& project_line = project_.lines[index];
    Line& line = lines_[index];
    line.tap = std::make_unique<Tap>(*this, index);
    line::DriverOptions options;
    options.gate = &gate_;
    options.on_link = [this, index](Instant t, bool up, const std::optional<Error>& why) {
        log_(up ? LogLevel::info : LogLevel::warning,
             up ? "link up" : name(why ? why->code : Code::connection_lost), project_.lines[index].name,
             why ? why->numbers[0] : 0);
        // An attempt that failed leaves the engine as it was; its variables are to say that there is no link.
        if (!up) lines_[index].tap->on_link(t, false);
        lines_[index].up = up;
        later([this, t, index, up, why] { reporter_->on_link(t, index, up, why); });
    };
    // An adapter that is not plugged in ends no run that has other lines to poll.
    options.wait_for_port = lines_.size() > 1;
    options.must_reconnect = [this, index] { return master_->line(index).must_reconnect(); };
    if (project_line.transport == model::Transport::simulated) {
        line.simulated = std::make_unique<sim::SimulatedLine>(project_line, *line.tap);
        if (prepare) prepare(index, line.simulated->devices());
        line.driver = line::run_simulated(loop_, *line.simulated, project_line.name, options);
        return {};
    }
    TAKT_TRY(line.driver, line::open_line(loop_, project_line, *line.tap, options));
    return {};
}

void Running::tell() {
    take_outcomes();
    for (auto& news : std::exchange(news_, {})) news();
    const auto missed = cursor_.missed;
    while (const auto* event = master_->store().next_event(cursor_)) reporter_->on_value(*event);
    if (cursor_.missed > missed) reporter_->on_missed(cursor_.missed - missed);
}

void Running::finish() {
    tell();
    give_up_sets([](value::SlotId, const WaitingSet&) { return true; });
    if (learner_) learner_->finish();
    if (retention_) retention_->finish();
}

void Running::poke(value::SlotId changed) {
    for (const auto line : master_->concerned(changed)) poke_line(line);
    tell_soon(line::now());
}

void Running::tell_soon(Instant t) {
    if (tell_timer_.when() == kNever) tell_timer_.set(after(t, kTellAfter));
}

void Running::later(std::function<void()> news) {
    news_.push_back(std::move(news));
    tell_soon(line::now());
}

void Running::on_device_state(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) {
    log_(state == poll::DeviceState::not_answering ? LogLevel::warning : LogLevel::info, poll::name(state),
         project_.lines[line].devices[device].name);
    if (state == poll::DeviceState::unknown) return;  // it will be asked at once: no news
    later([=, this] {
        reporter_->on_device(t, line, device, state);
        if (state != poll::DeviceState::answering) give_up_sets_of(line, device);
    });
}

void Running::on_overrun(Instant t, std::size_t line, std::size_t request, Duration period, Duration real,
                         bool overrun) {
    const plan::Request planned = master_->line(line).plan().requests[request];
    log_(LogLevel::warning, overrun ? "period overrun, real us" : "period held, real us",
         project_.lines[line].devices[planned.device].name, real / std::chrono::microseconds(1));
    later([=, this] { reporter_->on_overrun(t, line, planned, {period, real, overrun}); });
}

void Running::on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) {
    const plan::Request planned = master_->line(line).plan().requests[request];
    later([=, this] {
        reporter_->on_write_waiting(t, line, planned, variable);
        give_up_sets_of(line, planned.device);
    });
}

void Running::on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) {
    log_(LogLevel::info, "learnt: " + std::string(poll::name(lesson.kind)),
         project_.lines[line].devices[lesson.device].name, lesson.items.first);
    if (learner_) learner_->note();
    later([=, this] { reporter_->on_learnt(t, line, lesson); });
}

void Running::on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                               const value::Value& written, const value::Value& read) {
    const auto slot = master_->slots().variable({line, device, variable});
    differing_[slot] = {.slot = slot, .t = t, .written = written, .read_back = read};
    log_(LogLevel::warning, "read back differs", master_->store().info(slot).name);
    later([=, this] { reporter_->on_verify_failed(t, slot, written, read); });
}

}  // namespace takt::app
