// Units are visited one by one. A visit asks (Step::ask) until the unit answers, then reads its
// identification: 43/14 basic, then regular objects, else function 17, else the first request again. A unit
// counts as found only after a second good response (`proven`), because the first may be a late one of the
// unit before.
//
// A unit that was silent is visited a second time, with a longer wait, when there is a sign of it: a frame or
// damaged bytes after its time-out, or a first response that no second one followed.
//
// An adapted wait is checked (Step::check) by a request to a unit that is known to answer.
#include "takt/bus/line_scan.hpp"

#include <algorithm>

#include "takt/bus/expected_wait.hpp"

namespace takt::bus {
namespace {

using namespace std::chrono_literals;
using bus::Status;

constexpr int kTries = 3;      // responses that do not check
constexpr int kBusyLimit = 3;  // seconds without a silence
constexpr int kMaxPages = 16;  // responses to 43/14
// For the response of a second device. USB adapters deliver bytes in blocks of up to 16 ms.
constexpr Duration kListen = 30ms;

constexpr std::uint8_t kBasic = 1;
constexpr std::uint8_t kRegular = 2;
constexpr std::uint8_t kFirstRegularObject = 3;

// The requests that find a unit; all but the first only with `thorough`.
const std::array<wire::Request, 4>& questions() {
    using wire::Function;
    static const std::array<wire::Request, 4> kQuestions{
        wire::ReadRequest{Function::read_holding_registers, DataAddress{0}, 1},
        wire::ReadRequest{Function::read_input_registers, DataAddress{0}, 1},
        wire::ReadRequest{Function::read_coils, DataAddress{0}, 1}, wire::ReadDeviceIdRequest{kBasic, 0}};
    return kQuestions;
}

bool no_such_unit(std::uint8_t exception) {
    return exception == static_cast<std::uint8_t>(wire::ExceptionCode::gateway_path_unavailable) ||
           exception == static_cast<std::uint8_t>(wire::ExceptionCode::gateway_target_failed_to_respond);
}

}  // namespace

const std::string* UnitIdentity::find(std::uint8_t id) const {
    const auto at = std::ranges::find(objects, id, &Object::id);
    return at == objects.end() ? nullptr : &at->text;
}

LineScan::LineScan(const ScanConfig& config, wire::TrafficObserver* observer)
    : config_(config), observer_(observer), engine_(config.line, this) {
    for (const auto unit : config_.units) states_[unit.value] = State::asked;
    finished_ = config_.units.empty();
}

void LineScan::on_link(Instant t, bool up) {
    engine_.on_link(t, up);
    work(t);
}

void LineScan::on_bytes(Instant t, Bytes bytes) {
    engine_.on_bytes(t, bytes);
    work(t);
}

void LineScan::on_tick(Instant t) {
    engine_.on_tick(t);
    work(t);
}

Bytes LineScan::transmit(Instant t) {
    return engine_.transmit(t);
}

Instant LineScan::next_wakeup() const {
    if (finished_) return kNever;
    const bool listening = visited_ >= total();
    const bool waiting = listening || (engine_.link_up() && engine_.idle());
    return waiting ? std::min(engine_.next_wakeup(), not_before_) : engine_.next_wakeup();
}

void LineScan::on_frame(Instant t, wire::Direction direction, UnitId from, Bytes pdu, Bytes raw) {
    if (observer_) observer_->on_frame(t, direction, from, pdu, raw);
    if (direction == wire::Direction::sent || finished_) return;
    const State state = states_[from.value];
    if (state == State::silent) {
        learn_late();
        revisit(from);
    }
    if (state == State::unknown) ++foreign_frames_;
}

// Bytes that do not check may be the late response of the previous unit, broken by the request to this one.
void LineScan::on_fault(Instant t, wire::FrameFault fault, Bytes raw) {
    if (observer_) observer_->on_fault(t, fault, raw);
    if (before_ && visit_.step == Step::ask) revisit(*before_);
}

void LineScan::revisit(UnitId unit) {
    if (states_[unit.value] != State::silent) return;
    states_[unit.value] = State::again;
    second_.push_back(unit);
}

UnitId LineScan::unit() const {
    return second_visit() ? second_[visited_ - config_.units.size()] : config_.units[visited_];
}

LineScan::Unsolicited LineScan::unsolicited() const {
    const auto& counters = engine_.counters();
    return {.frames = counters.foreign_frames + counters.late_answers, .bytes = counters.unsolicited_bytes};
}

// A few stray bytes are noise of a line driver, not a second device.
bool LineScan::responded_twice() const {
    constexpr std::uint64_t kLeastResponse = 5;
    const Unsolicited now = unsolicited();
    return now.frames > unsolicited_before_.frames || now.bytes >= unsolicited_before_.bytes + kLeastResponse;
}

void LineScan::work(Instant t) {
    while (const auto outcome = engine_.take_outcome()) on_outcome(t, *outcome);
    if (finished_ || t < not_before_) return;
    if (visited_ >= total())
        finished_ = true;
    else if (engine_.can_submit() && engine_.idle())
        submit(t);
}

void LineScan::submit(Instant t) {
    if (visit_.answered && !visit_.proven && config_.line.is_serial())
        visit_.found.doubled = visit_.found.doubled || responded_twice();
    bus::Transaction transaction;
    transaction.unit = visit_.step == Step::check ? found_.front().unit : unit();
    transaction.wait = wait();
    const auto prepared = wire::prepare(request());
    if (prepared) transaction.request = *prepared;
    if (!prepared || !engine_.submit(t, transaction)) leave(t);
}

bool LineScan::adapted() const {
    return config_.adaptive && !found_.empty() && !second_visit();
}

// The identification of a unit may take longer than a read.
Duration LineScan::wait() const {
    if (second_visit()) return config_.retry_wait;
    const bool reads = visit_.step == Step::ask || visit_.step == Step::check;
    return reads && adapted() ? expected_wait(slowest_, config_.wait) : config_.wait;
}

wire::Request LineScan::request() const {
    switch (visit_.step) {
        case Step::basic: return wire::ReadDeviceIdRequest{kBasic, visit_.object};
        case Step::regular: return wire::ReadDeviceIdRequest{kRegular, visit_.object};
        case Step::server_id: return wire::ReportServerIdRequest{};
        case Step::check: {
            const auto asked =
                std::ranges::find(questions(), static_cast<wire::Function>(found_.front().function),
                                  [](const auto& question) { return wire::function_of(question); });
            return *asked;
        }
        case Step::ask:
        case Step::again: break;
    }
    return questions()[visit_.question];
}

void LineScan::on_outcome(Instant t, const bus::Outcome& outcome) {
    learn(outcome);
    if (visit_.step == Step::check && outcome.status != Status::line_busy) return checked(t, outcome);
    switch (outcome.status) {
        case Status::ok: return answered(t, outcome);
        case Status::exception:
            if (!no_such_unit(outcome.exception)) return answered(t, outcome);
            gateway_ = true;
            return unanswered(t);
        case Status::timeout: visit_.timed_out = true; return unanswered(t);
        case Status::bad_checksum:
        case Status::ambiguous:
        case Status::unexpected_reply: return repeat(t, outcome, true);
        case Status::link_lost:
        case Status::closed:
        case Status::cancelled: return repeat(t, outcome, false);
        case Status::line_busy:
            if (++busy_ < kBusyLimit) return;
            finished_ = true;
            end_ = ScanEnd::line_busy;
            return;
    }
}

void LineScan::learn(const bus::Outcome& outcome) {
    if (outcome.status != Status::ok && outcome.status != Status::exception) return;
    slowest_ = std::max(slowest_, outcome.ended_at - outcome.request_end);
}

// A response took longer than the adapted wait.
void LineScan::learn_late() {
    slowest_ = std::max(slowest_, expected_wait(slowest_, config_.wait));
}

void LineScan::checked(Instant t, const bus::Outcome& outcome) {
    visit_.blocking = outcome.status != Status::ok && outcome.status != Status::exception;
    if (visit_.blocking) learn_late();
    leave(t);
}

void LineScan::repeat(Instant t, const bus::Outcome& outcome, bool garbled) {
    visit_.found.garbled = visit_.found.garbled || garbled;
    if (++visit_.tries < (garbled ? kTries : 2)) return;
    if (garbled && visit_.step == Step::ask &&
        std::ranges::find(garbled_, unit(), &GarbledUnit::unit) == garbled_.end())
        garbled_.push_back({unit(), outcome.instead});
    unanswered(t);
}

void LineScan::answered(Instant t, const bus::Outcome& outcome) {
    busy_ = 0;
    if (!visit_.answered) return first_answer(t, outcome);
    visit_.proven = true;
    const bool refused = outcome.status == Status::exception;
    switch (visit_.step) {
        case Step::basic:
        case Step::regular:
            if (!refused) return take_device_id(t, outcome);
            return visit_.step == Step::basic ? next_step(Step::server_id) : leave(t);
        case Step::server_id:
            if (!refused)
                visit_.found.identity.server_id.assign(outcome.response.pdu().begin() + 2,
                                                       outcome.response.pdu().end());
            return leave(t);
        case Step::ask:
        case Step::check:
        case Step::again: return leave(t);
    }
}

void LineScan::first_answer(Instant t, const bus::Outcome& outcome) {
    visit_.answered = true;
    auto& found = visit_.found;
    found.unit = unit();
    found.function = static_cast<std::uint8_t>(wire::function_of(questions()[visit_.question]));
    found.exception = outcome.exception;
    found.response_time = std::max(Duration::zero(), outcome.ended_at - outcome.request_end);
    found.late = second_visit();
    unsolicited_before_ = unsolicited();
    if (config_.line.is_serial()) not_before_ = after(t, kListen);
    next_step(config_.identify ? Step::basic : Step::again);
}

void LineScan::take_device_id(Instant t, const bus::Outcome& outcome) {
    const auto page = outcome.response.device_id();
    if (!page) return next_step(Step::server_id);
    auto& objects = visit_.found.identity.objects;
    for (auto texts = page->objects(); !texts.empty();) {
        const wire::DeviceIdText object = texts.take();
        const bool known = visit_.found.identity.find(object.id) != nullptr;
        if (!known && objects.size() < UnitIdentity::kMaxObjects)
            objects.push_back({object.id, std::string(object.text.begin(), object.text.end())});
    }
    if (page->more_follows() && page->next_object() > visit_.object && ++visit_.pages < kMaxPages) {
        visit_.object = page->next_object();
        return;
    }
    const bool has_regular = (page->conformity() & 0x7FU) >= kRegular;
    if (visit_.step == Step::regular || !has_regular) return leave(t);
    next_step(Step::regular);
    visit_.object = kFirstRegularObject;
}

void LineScan::unanswered(Instant t) {
    switch (visit_.step) {
        case Step::ask:
            if (!config_.thorough || visit_.question + 1 >= questions().size())
                return visit_.timed_out && wait() < config_.wait ? next_step(Step::check) : leave(t);
            ++visit_.question;
            return next_step(Step::ask);
        case Step::basic: return next_step(Step::server_id);
        case Step::server_id: return visit_.proven ? leave(t) : next_step(Step::again);
        case Step::regular:
        case Step::check: return leave(t);
        case Step::again:
            if (++visit_.tries >= kTries) leave(t);
            return;
    }
}

void LineScan::next_step(Step step) {
    visit_.step = step;
    visit_.tries = 0;
    visit_.object = 0;
}

void LineScan::leave(Instant t) {
    const UnitId left = unit();
    auto& state = states_[left.value];
    before_.reset();
    if (visit_.proven) {
        std::erase_if(garbled_, [left](const GarbledUnit& its) { return its.unit == left; });
        found_.push_back(std::move(visit_.found));
    } else if (!second_visit() && state == State::asked) {
        state = State::silent;
        if (visit_.answered || visit_.blocking) revisit(left);
        if (visit_.timed_out) before_ = left;
    }
    const bool checked = visit_.step == Step::check && !visit_.blocking;
    visit_ = {};
    ++visited_;
    // The response of the last unit may be a late one too.
    if (visited_ == total() && before_)
        not_before_ = after(t, checked ? config_.wait : config_.retry_wait - config_.wait);
}

}  // namespace takt::bus
