#include "takt/app/running.hpp"

#include <utility>

#include "takt/line/real_line.hpp"
#include "takt/value/text.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kTellAfter = 5ms;
constexpr Duration kRefreshEvery = 200ms;
constexpr Duration kCommandExpires = 10s;

}  // namespace

/// Between a driver and its poller: notices that something may have happened.
class Running::Tap final : public Engine {
public:
    Tap(Running& running, Engine& engine) : running_(running), engine_(engine) {}

    void on_link(Instant t, bool up) override {
        engine_.on_link(t, up);
        running_.tell_soon(t);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        engine_.on_bytes(t, bytes);
        running_.tell_soon(t);
    }
    void on_tick(Instant t) override {
        engine_.on_tick(t);
        running_.tell_soon(t);
    }
    Bytes transmit(Instant t) override { return engine_.transmit(t); }
    Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    Running& running_;
    Engine& engine_;
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
    if (learner_)
        learner_->follow(*master_, [this](std::size_t line) {
            if (lines_[line].driver) lines_[line].driver->poke();
        });
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
    line.tap = std::make_unique<Tap>(*this, master_->line(index));
    line::DriverOptions options;
    options.gate = &gate_;
    options.on_link = [this, index](Instant t, bool up, const std::optional<Error>& why) {
        log_(up ? LogLevel::info : LogLevel::warning,
             up ? "link up" : name(why ? why->code : Code::connection_lost), project_.lines[index].name,
             why ? why->numbers[0] : 0);
        // An attempt that failed leaves the engine as it was; its variables are to say that there is no link.
        if (!up) lines_[index].tap->on_link(t, false);
        later([this, t, index, up, why] { reporter_->on_link(t, index, up, why); });
    };
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

void Running::execute(const ControlCommand& command, Reply reply) {
    if (command.verb == ControlCommand::Verb::quit) {
        reply({.kind = Answer::Kind::ok, .command = "quit"});
        loop_.stop();
        return;
    }
    const auto slot = master_->store().find(command.name);
    if (!slot) return reply(error_answer(command, fail(Code::not_found, command.name).error()));
    if (command.verb == ControlCommand::Verb::get) return get(command, *slot, reply);
    const auto& info = master_->store().info(*slot);
    const auto value = value::parse(info.type, info.scaled, command.value);
    if (!value) return reply(error_answer(command, value.error()));
    if (retention_ && retention_->retains(*slot) && retention_->full())
        return reply(error_answer(command, fail(Code::queue_full, Retention::kMostWaiting).error()));
    if (command.verb == ControlCommand::Verb::set) return set(command, *slot, *value, reply);
    write(command, *slot, *value, std::move(reply));
}

void Running::set(const ControlCommand& command, value::SlotId slot, const value::Value& value,
                  const Reply& reply) {
    const auto done = master_->set(line::now(), slot, value);
    if (!done) return reply(error_answer(command, done.error()));
    const auto& info = master_->store().info(slot);
    Answer answer{.kind = Answer::Kind::ok, .command = "set", .name = command.name};
    answer.value = value::format(info.type, info.scaled, value);
    answer.rounded = *done;
    answer_when_kept(slot, std::move(answer), reply);
    poke(slot);
}

void Running::write(const ControlCommand& command, value::SlotId slot, const value::Value& value,
                    Reply reply) {
    const Instant t = line::now();
    const auto id = next_command_++;
    const auto accepted = master_->write(t, {id, slot, value, after(t, kCommandExpires)});
    if (!accepted) return reply(error_answer(command, accepted.error()));
    pending_.emplace(id, Pending{command, std::move(reply)});
    poke(slot);
}

void Running::get(const ControlCommand& command, value::SlotId id, const Reply& reply) const {
    const auto& info = master_->store().info(id);
    const auto& slot = master_->store()[id];
    Answer answer{.kind = Answer::Kind::ok, .command = "get", .name = command.name};
    answer.value = value::format(info.type, info.scaled, slot.value);
    if (slot.quality != value::Quality::good) answer.quality = value::name(slot.quality);
    reply(answer);
}

void Running::tell() {
    take_outcomes();
    for (auto& news : std::exchange(news_, {})) news();
    const auto missed = cursor_.missed;
    while (const auto* event = master_->store().next_event(cursor_)) reporter_->on_value(*event);
    if (cursor_.missed > missed) reporter_->on_missed(cursor_.missed - missed);
}

void Running::take_outcomes() {
    while (const auto outcome = master_->take_outcome()) {
        auto node = pending_.extract(outcome->id);
        if (node.empty()) continue;
        auto& [command, reply] = node.mapped();
        Answer answer{.kind = Answer::Kind::outcome, .command = "write", .name = command.name};
        answer.outcome = value::name(outcome->result);
        answer.reason = reason_text(outcome->reason);
        const auto& info = master_->store().info(outcome->slot);
        answer.written = value::format(info.type, info.scaled, outcome->written);
        answer.read_back = value::format(info.type, info.scaled, outcome->read_back);
        answer.rounded = outcome->rounded;
        log_(LogLevel::info, "write " + answer.outcome, command.name, value::status_code(outcome->reason));
        answer_when_kept(outcome->slot, std::move(answer), reply);
    }
}

// What is answered is to be there after the end of the run, however it ends.
void Running::answer_when_kept(value::SlotId slot, Answer answer, const Reply& reply) {
    if (!retention_ || !retention_->retains(slot)) return reply(answer);
    retention_->keep(slot, [answer = std::move(answer), reply](bool kept) mutable {
        answer.not_retained = !kept;
        reply(answer);
    });
}

void Running::finish() {
    tell();
    if (learner_) learner_->finish();
    if (retention_) retention_->finish();
}

void Running::poke(value::SlotId changed) {
    for (const auto line : master_->concerned(changed))
        if (lines_[line].driver) lines_[line].driver->poke();
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
    later([=, this] { reporter_->on_device(t, line, device, state); });
}

void Running::on_overrun(Instant t, std::size_t line, std::size_t request, Duration period, Duration real) {
    const plan::Request planned = master_->line(line).plan().requests[request];
    log_(LogLevel::warning, real > period ? "period overrun, real us" : "period held, real us",
         project_.lines[line].devices[planned.device].name, real / std::chrono::microseconds(1));
    later([=, this] { reporter_->on_overrun(t, line, planned, period, real); });
}

void Running::on_write_waiting(Instant t, std::size_t line, std::size_t request, std::size_t variable) {
    const plan::Request planned = master_->line(line).plan().requests[request];
    later([=, this] { reporter_->on_write_waiting(t, line, planned, variable); });
}

void Running::on_learnt(Instant t, std::size_t line, const poll::Lesson& lesson) {
    log_(LogLevel::info, "learnt: " + std::string(poll::name(lesson.kind)),
         project_.lines[line].devices[lesson.device].name, lesson.items.first);
    if (learner_) learner_->note();
    later([=, this] { reporter_->on_learnt(t, line, lesson); });
}

void Running::on_verify_failed(Instant t, std::size_t line, std::size_t device, std::size_t variable,
                               const value::Value& written, const value::Value& read) {
    const auto slot = master_->slots().variable({line, device, variable});
    log_(LogLevel::warning, "read back differs", master_->store().info(slot).name);
    later([=, this] { reporter_->on_verify_failed(t, slot, written, read); });
}

Answer Running::error_answer(const ControlCommand& command, const Error& error) const {
    constexpr const char* kWords[] = {"set", "write", "get", "quit"};
    Answer answer{
        .kind = Answer::Kind::error, .command = kWords[static_cast<int>(command.verb)], .name = command.name};
    answer.code = name(error.code);
    answer.text = texts_.describe(error);
    return answer;
}

}  // namespace takt::app
