#include "story.hpp"

#include "takt/plan/plan.hpp"
#include "takt/wire/frame.hpp"

namespace takt::simtest {
namespace {

constexpr auto kProject = R"(takt: 1
backoff: {first: 1s, limit: 4s}
lines:
  - name: line
    port: /dev/ttySim
    baud: 19200
    devices:
      - name: one
        address: 1
        turnaround: 10ms
        response_timeout: 50ms
        attempts: 2
        poll_period: 1s
        strategy: classic
        variables:
          - {name: v, type: uint16, register: 0, read: 0x03, write: 0x10, write_on_change: true}
          - {name: w, type: uint16, register: 1, read: 0x03, write: 0x10, write_on_change: true}
          - {name: x, type: uint16, register: 10, read: 0x04, period: 2s}
          - {name: s, type: uint16, register: 20, read: none, write: 0x06}
          - {name: p, type: uint16, register: 30, read: none, write: 0x06, verify: true}
          - {name: q, type: uint16, register: 31, read: none, write: 0x06, verify: true}
      - name: two
        address: 2
        turnaround: 10ms
        response_timeout: 50ms
        attempts: 2
        poll_period: 4s
        poll_enable: on
        variables:
          - {name: y, type: uint16, register: 0, read: 0x04}
          - {name: z, type: uint16, register: 50, read: none, write: 0x06, verify: true}
      - name: three
        address: 3
        turnaround: 10ms
        response_timeout: 50ms
        attempts: 2
        read_modify_write: true
        variables:
          - {name: a, type: bool, register: 40, bit: 0, read: none, write: 0x06, write_on_change: true,
             verify: true, safe_to_repeat: true}
          - {name: b, type: bool, register: 40, bit: 1, read: none, write: 0x06, write_on_change: true,
             verify: true}
locals:
  - {name: on, type: bool, default: true}
)";

constexpr Duration kCharacter = Duration(572'917);

}  // namespace

Story::Story() {
    project_ = read_text(kProject).project;
    plan_ = plan::make_plan(project_);
    guarantees_ = plan::guarantee(project_, plan_);
    store_ = value::Store(value::slot_infos(project_));
    first_slot_ = slot("v").value;
    judge_ = std::make_unique<judge::LineJudge>(case_, 0, complaints_);
    link(0ms, true);
}

std::optional<std::size_t> Story::request_of(std::uint8_t unit, const std::vector<std::uint8_t>& pdu,
                                             poll::Purpose purpose) const {
    const bool for_write = purpose == poll::Purpose::before_write || purpose == poll::Purpose::read_back;
    const auto& requests = plan_.lines[0].requests;
    for (std::size_t r = 0; r < requests.size(); ++r) {
        const auto function = pdu[0] < 5 && !for_write ? requests[r].read : requests[r].write;
        if (requests[r].device + 1 == unit && requests[r].start == pdu[1] * 256 + pdu[2] && function &&
            (for_write || static_cast<std::uint8_t>(*function) == pdu[0]))
            return r;
    }
    return std::nullopt;
}

void Story::ask(Duration when, std::uint8_t unit, std::vector<std::uint8_t> pdu, poll::Purpose purpose,
                std::optional<value::CommandId> command, bool early) {
    const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{unit}, 0, pdu);
    unit_ = unit;
    now_ = at(when);
    end_ = now_ + static_cast<std::int64_t>(frame.size()) * kCharacter;
    ++sent_[unit - 1U];
    poll::Sending sending{.purpose = pdu[0] < 5 ? purpose : poll::Purpose::write,
                          .early = early,
                          .device = std::size_t{unit} - 1,
                          .command = command};
    if (!command) sending.request = request_of(unit, pdu, sending.purpose);
    judge_->on_sent(now_, frame.span(), judge::Claim{now_, sending});
}

void Story::probe_early(Duration when, std::uint8_t unit, std::vector<std::uint8_t> pdu) {
    ask(when, unit, std::move(pdu), poll::Purpose::probe, {}, true);
}

void Story::serve(wire::Area area, std::uint16_t start, std::vector<std::uint16_t> values) {
    judge_->on_read({end_, UnitId{unit_}, area, start, values});
}

void Story::execute(std::uint16_t start, std::vector<std::uint16_t> values) {
    judge_->on_write({end_, UnitId{unit_}, wire::Area::holding_register, start, values});
}

void Story::ignore() {
    judge_->on_fault({end_, sim::FaultKind::ignored_write, std::size_t{unit_} - 1, {}});
}

void Story::answer(std::vector<std::uint8_t> pdu) {
    const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{unit_}, 0, pdu);
    now_ = end_ + 5ms + static_cast<std::int64_t>(frame.size()) * kCharacter;
    judge_->on_heard(now_, frame.span());
}

void Story::show(const std::string& name, std::int64_t value, value::Quality quality) {
    const value::Update update{slot(name), static_cast<std::uint64_t>(value), quality};
    store_.apply(now_, {&update, 1});
    look(now_ - Instant{});
}

void Story::show_held(Duration when, Duration read, const std::string& name, std::int64_t value) {
    const value::Update update{slot(name), static_cast<std::uint64_t>(value)};
    store_.apply(at(read), {&update, 1});
    look(when);
}

void Story::look(Duration when) {
    judge_->look(at(when), store_, first_slot_,
                 engine_ends ? sent_ : std::vector<std::uint64_t>(sent_.size()));
}

void Story::read(Duration when, std::uint8_t unit, std::uint8_t function, std::uint16_t start,
                 const std::string& name, std::uint16_t value) {
    ask(when, unit, {function, 0, static_cast<std::uint8_t>(start), 0, 1});
    serve(function == 3 ? wire::Area::holding_register : wire::Area::input_register, start, {value});
    answer({function, 2, static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)});
    show(name, value);
}

void Story::set(Duration when, const std::string& name, std::int64_t value) {
    judge_->on_set(at(when), number(name), static_cast<std::uint64_t>(value));
}

void Story::command(Duration when, value::CommandId id, const std::string& name, std::int64_t value,
                    std::optional<Duration> expires) {
    value::WriteCommand command{id, slot(name), static_cast<std::uint64_t>(value)};
    if (expires) command.expires = at(*expires);
    judge_->on_command(at(when), command, number(name));
}

void Story::outcome(Duration when, value::CommandId id, value::CommandResult result, value::Reason reason) {
    judge_->on_outcome(at(when), {.id = id, .result = result, .reason = reason});
}

std::string Story::complaint() const {
    return complaints_.any() ? std::string(complaints_.all().front().invariant) : "";
}

std::string Story::text() const {
    std::string made;
    for (const auto& violation : complaints_.all())
        made += std::string(violation.invariant) + ": expected " + violation.expected + "; seen " +
                violation.seen + "\n";
    return made;
}

}  // namespace takt::simtest
