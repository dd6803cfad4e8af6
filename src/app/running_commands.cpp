// The commands of a running project, and what becomes of them.
#include <utility>

#include "takt/app/running.hpp"
#include "takt/line/real_line.hpp"
#include "takt/value/text.hpp"
#include "waiting_set.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;
using value::CommandResult;

constexpr Duration kCommandExpires = 10s;
constexpr Duration kLongestSet = 10s;
constexpr Duration kPassedOnExpires = 5s;  // who waits for a slave's answer waits no longer

}  // namespace

void Running::execute(const ControlCommand& command, const Reply& reply, Hearer hearer) {
    if (command.verb == ControlCommand::Verb::quit) {
        reply({.kind = Answer::Kind::ok, .command = "quit"});
        loop_.stop();
        return;
    }
    const auto slot = master_->store().find(command.name);
    if (!slot) return reply(error_answer(command, fail(Code::not_found, command.name).error()));
    Asked asked{command, reply, hearer};
    if (command.verb == ControlCommand::Verb::get) return get(asked, *slot);
    const auto& info = master_->store().info(*slot);
    const auto value = value::parse(info.type, info.scaled, command.value);
    if (!value) return reply(error_answer(command, value.error()));
    if (retention_ && retention_->retains(*slot) && retention_->full())
        return reply(error_answer(command, fail(Code::queue_full, Retention::kMostWaiting).error()));
    asked.id = next_command_++;
    if (command.verb == ControlCommand::Verb::set) return set(std::move(asked), *slot, *value);
    write(std::move(asked), *slot, *value);
}

void Running::set(Asked asked, value::SlotId slot, const value::Value& value) {
    const Instant t = line::now();
    const auto done = master_->set(t, slot, value);
    if (!done) return asked.reply(error_answer(asked.command, done.error()));
    const auto& info = master_->store().info(slot);
    const auto waiting = std::make_shared<WaitingSet>();
    waiting->answer = {
        .kind = Answer::Kind::ok, .command = "set", .id = asked.id, .name = asked.command.name};
    waiting->answer.value = value::format(info.type, info.scaled, value);
    waiting->answer.rounded = *done;
    waiting->reply = std::move(asked.reply);
    waiting->hearer = asked.hearer;
    if (const auto earlier = sets_.extract(slot); !earlier.empty()) {
        earlier.mapped()->answer.waiting = "superseded";
        earlier.mapped()->part_done();
    }
    if (is_written_soon(slot)) {
        ++waiting->parts;
        waiting->until = after(t, kLongestSet);
        sets_.emplace(slot, waiting);
    } else if (is_written_on_change(slot)) {
        waiting->answer.waiting = "waiting";
    }
    if (retention_ && retention_->retains(slot)) {
        ++waiting->parts;
        retention_->keep(slot, [waiting](bool kept) {
            waiting->answer.not_retained = !kept;
            waiting->part_done();
        });
    }
    waiting->part_done();
    poke(slot);
}

bool Running::is_written_on_change(value::SlotId slot) const {
    const auto owner = master_->slots().owner(slot);
    const auto* index = std::get_if<poll::VariableIndex>(&owner);
    return index &&
           project_.lines[index->line].devices[index->device].variables[index->variable].write_on_change;
}

bool Running::is_written_soon(value::SlotId slot) const {
    if (!is_written_on_change(slot)) return false;
    const auto index = std::get<poll::VariableIndex>(master_->slots().owner(slot));
    const auto state = master_->line(index.line).device(index.device).state;
    return state == poll::DeviceState::answering || state == poll::DeviceState::unknown;
}

void Running::write(Asked asked, value::SlotId slot, const value::Value& value) {
    const Instant t = line::now();
    const auto accepted = master_->write(t, {asked.id, slot, value, after(t, kCommandExpires)});
    if (!accepted) return asked.reply(error_answer(asked.command, accepted.error()));
    pending_.emplace(asked.id, std::move(asked));
    poke(slot);
}

Result<bool> Running::set_local(value::SlotId slot, const value::Value& value) {
    const auto done = master_->set(line::now(), slot, value);
    if (done) poke(slot);
    return done;
}

Result<bool> Running::write_value(value::SlotId slot, const value::Value& value, Written written) {
    const Instant t = line::now();
    const auto owner = master_->slots().owner(slot);
    const auto* const index = std::get_if<poll::VariableIndex>(&owner);
    if (index && !lines_[index->line].up)
        return fail(Code::connection_lost, project_.lines[index->line].name);
    const auto id = next_command_++;
    const auto accepted = master_->write(t, {id, slot, value, after(t, kPassedOnExpires)});
    if (!accepted) return accepted;
    passed_on_.emplace(id, std::move(written));
    poke(slot);
    return accepted;
}

void Running::get(const Asked& asked, value::SlotId id) const {
    const auto& info = master_->store().info(id);
    const auto& slot = master_->store()[id];
    Answer answer{.kind = Answer::Kind::ok, .command = "get", .name = asked.command.name};
    answer.value = value::format(info.type, info.scaled, slot.value);
    if (slot.quality != value::Quality::good) answer.quality = value::name(slot.quality);
    asked.reply(answer);
}

void Running::take_outcomes() {
    while (const auto outcome = master_->take_outcome()) {
        if (auto passed = passed_on_.extract(outcome->id); !passed.empty()) {
            passed.mapped()(*outcome);
            continue;
        }
        auto node = pending_.extract(outcome->id);
        if (node.empty()) continue;
        const auto& asked = node.mapped();
        Answer answer = outcome_answer(*outcome);
        answer.command = "write";
        const auto& info = master_->store().info(outcome->slot);
        if (const auto wanted = value::parse(info.type, info.scaled, asked.command.value))
            answer.wanted = value::format(info.type, info.scaled, *wanted);
        log_(LogLevel::info, "write " + answer.outcome, answer.name, value::status_code(outcome->reason));
        if (asked.hearer == Hearer::asker) tell_unwritten(outcome->t, *outcome, answer);
        answer_when_kept(outcome->slot, std::move(answer), asked.reply);
    }
}

Answer Running::outcome_answer(const value::CommandOutcome& outcome) const {
    const auto& info = master_->store().info(outcome.slot);
    Answer answer{.kind = Answer::Kind::outcome, .id = outcome.id};
    answer.line = line_name(scene(), outcome.slot);
    answer.device = device_name(scene(), outcome.slot);
    answer.name = info.name;
    answer.outcome = value::name(outcome.result);
    answer.reason = reason_text(outcome.reason);
    answer.written = value::format(info.type, info.scaled, outcome.written);
    answer.read_back = value::format(info.type, info.scaled, outcome.read_back);
    answer.rounded = outcome.rounded;
    return answer;
}

void Running::tell_unwritten(Instant t, const value::CommandOutcome& outcome, const Answer& answer) {
    if (outcome.result == CommandResult::done) return;
    reporter_->on_unwritten(t, {outcome.slot, outcome.result, outcome.reason, answer.wanted}, answer);
}

// Of a group that differs somewhere, what does not is written.
void Running::on_group_settled(Instant t, std::size_t line, std::size_t device,
                               std::span<const std::size_t> variables, CommandResult result,
                               value::Reason reason) {
    for (const auto variable : variables) {
        value::CommandOutcome outcome{.slot = master_->slots().variable({line, device, variable}),
                                      .result = result,
                                      .reason = reason,
                                      .t = t};
        const auto differing = differing_.extract(outcome.slot);
        if (reason == value::Reason::differs) {
            const bool differs = !differing.empty() && differing.mapped().t == t;
            if (differs) outcome.written = differing.mapped().written;
            if (differs) outcome.read_back = differing.mapped().read_back;
            if (!differs) outcome.result = CommandResult::done;
        }
        settle_set(outcome);
    }
}

void Running::settle_set(const value::CommandOutcome& outcome) {
    const auto found = sets_.extract(outcome.slot);
    const auto set = found.empty() ? nullptr : found.mapped();
    if (outcome.result == CommandResult::done) {
        if (set) later([set] { set->part_done(); });
        return;
    }
    Answer answer = outcome_answer(outcome);
    const auto& slot = master_->store()[outcome.slot];
    const auto& info = master_->store().info(outcome.slot);
    const auto& wanted = value::is_empty(slot.wanted) ? slot.value : slot.wanted;
    answer.command = "set";
    answer.wanted = value::format(info.type, info.scaled, wanted);
    if (set) answer.id = set->answer.id;
    log_(LogLevel::warning, "set " + answer.outcome, answer.name, value::status_code(outcome.reason));
    const bool to_tell = !set || set->hearer == Hearer::asker;
    later([this, set, outcome, answer, to_tell] {
        if (to_tell) tell_unwritten(outcome.t, outcome, answer);
        if (!set) return;
        const bool not_retained = set->answer.not_retained;
        set->answer = answer;
        set->answer.not_retained = not_retained;
        set->part_done();
    });
}

// It stays set, and is written when it can be.
void Running::give_up_sets(const std::function<bool(value::SlotId, const WaitingSet&)>& which) {
    std::vector<std::shared_ptr<WaitingSet>> given_up;
    for (const auto& [slot, set] : sets_)
        if (which(slot, *set)) given_up.push_back(set);
    std::erase_if(sets_, [&](const auto& entry) { return which(entry.first, *entry.second); });
    for (const auto& set : given_up) {
        set->answer.waiting = "waiting";
        set->part_done();
    }
}

void Running::give_up_sets_of(std::size_t line, std::size_t device) {
    give_up_sets([&](value::SlotId slot, const WaitingSet&) {
        const auto index = std::get<poll::VariableIndex>(master_->slots().owner(slot));
        return index.line == line && index.device == device;
    });
}

// What is answered is to be there after the end of the run, however it ends.
void Running::answer_when_kept(value::SlotId slot, Answer answer, const Reply& reply) {
    if (!retention_ || !retention_->retains(slot)) return reply(answer);
    retention_->keep(slot, [answer = std::move(answer), reply](bool kept) mutable {
        answer.not_retained = !kept;
        reply(answer);
    });
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
