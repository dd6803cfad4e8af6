// The event log of function 12 holds one byte per event, newest first (section 6.10): bit 7 set: a message
// was received; bit 6 set: an answer was sent; 0x04: listen-only mode entered; 0x00: restarted.
#include "takt/serve/diagnostics.hpp"

#include "pdu_bytes.hpp"

namespace takt::serve {
namespace {

using wire::ExceptionCode;
using wire::Function;

enum SubFunction : std::uint16_t {
    kReturnQueryData = 0,
    kRestart = 1,
    kReturnRegister = 2,
    kAsciiDelimiter = 3,
    kListenOnly = 4,
    kClearCounters = 10,
    kFirstCounter = 11,
    kLastCounter = 18,
    kClearOverruns = 20,
};

constexpr std::size_t kHead = 3;  // function and sub-function
constexpr std::uint16_t kClearLog = 0xFF00;
constexpr std::uint16_t kLineFeed = 0x0A00;

constexpr unsigned kReceived = 0x80;
constexpr unsigned kReceivedError = 0x02;
constexpr unsigned kReceivedOverrun = 0x10;
constexpr unsigned kInListenOnly = 0x20;
constexpr unsigned kReceivedBroadcast = 0x40;
constexpr unsigned kSent = 0x40;
constexpr unsigned kEnteredListenOnly = 0x04;
constexpr unsigned kRestarted = 0x00;

constexpr std::uint8_t kNegativeAcknowledge = 7;  // of earlier protocol versions

bool is_restart(const wire::RequestView& request) {
    return request.function() == Function::diagnostics && request.well_formed() &&
           request.sub_function() == kRestart;
}

bool is_known(std::uint16_t sub_function) {
    return sub_function <= kListenOnly || (sub_function >= kClearCounters && sub_function <= kLastCounter) ||
           sub_function == kClearOverruns;
}

/// The bit of a send event that reports the exception.
unsigned exception_bit(std::uint8_t code) {
    switch (code) {
        case 1:
        case 2:
        case 3: return 0x01;
        case 4: return 0x02;
        case 5:
        case 6: return 0x04;
        case kNegativeAcknowledge: return 0x08;
        default: return 0;
    }
}

bool is_exception(const Answer& answer) {
    return answer.kind == Answer::Kind::response && wire::is_exception(answer.pdu[0]);
}

}  // namespace

void EventLog::add(std::uint8_t event) {
    if (events_.try_push_back(event)) return;
    events_[next_] = event;
    next_ = (next_ + 1) % kMost;
}

std::uint8_t EventLog::operator[](std::size_t age) const {
    return events_[(next_ + events_.size() - 1 - age) % events_.size()];
}

Diagnostics::Diagnostics(const DiagnosticsOptions& options, EventLog* log) : options_(options), log_(log) {}

void Diagnostics::on_line_event(LineEvent event) {
    switch (event) {
        case LineEvent::message: ++counts_.messages; break;
        case LineEvent::error:
            ++counts_.errors;
            log(kReceived | kReceivedError);
            break;
        case LineEvent::overrun:
            ++counts_.overruns;
            log(kReceived | kReceivedOverrun);
            break;
    }
}

bool Diagnostics::admit(const Context& context, const wire::RequestView& request) {
    ++counts_.own_messages;
    log(kReceived | (context.broadcast ? kReceivedBroadcast : 0U) | (listen_only_ ? kInListenOnly : 0U));
    if (!listen_only_) return true;
    return is_restart(request) && !context.broadcast;
}

void Diagnostics::done(const Context& context, const wire::RequestView& request, const Answer& answer) {
    if (is_exception(answer)) ++counts_.exceptions;
    if (is_restart(request) && !is_exception(answer)) return;  // the restart has cleared all counters
    if (context.broadcast || answer.kind == Answer::Kind::silence)
        ++counts_.silences;
    else
        count_answer(answer);
    const Function function = request.function();
    const bool poll =
        function == Function::get_comm_event_counter || function == Function::get_comm_event_log;
    if (answer.kind != Answer::Kind::silence && !is_exception(answer) && !poll) ++counts_.events;
}

void Diagnostics::count_answer(const Answer& answer) {
    const std::uint8_t code = is_exception(answer) ? answer.pdu[1] : std::uint8_t{0};
    if (code == kNegativeAcknowledge) ++counts_.refusals;
    if (code == static_cast<std::uint8_t>(ExceptionCode::server_device_busy)) ++counts_.busy;
    log(kSent | exception_bit(code));
}

void Diagnostics::log(unsigned event) {
    if (log_) log_->add(static_cast<std::uint8_t>(event));
}

bool Diagnostics::handle(Unit& unit, const Context& context, const wire::RequestView& request,
                         Answer& answer) {
    if (context.broadcast) return false;
    Refusal refusal;
    answer.pdu.assign(request.pdu().first(1));
    switch (request.function()) {
        case Function::read_exception_status: answer.pdu.push_back(exception_status(unit)); break;
        case Function::diagnostics: refusal = diagnose(request, answer); break;
        case Function::get_comm_event_counter:
            put_word(answer.pdu, 0);
            put_word(answer.pdu, counts_.events);
            break;
        case Function::get_comm_event_log:
            if (log_)
                tell_log(answer);
            else
                refusal = ExceptionCode::illegal_function;
            break;
        default: answer.pdu.clear(); return false;
    }
    if (!refusal && !request.well_formed()) refusal = ExceptionCode::illegal_data_value;
    if (refusal) refuse(answer, request, *refusal);
    return true;
}

std::uint8_t Diagnostics::exception_status(const Unit& unit) const {
    if (!options_.status_coils) return exception_status_;
    unsigned status = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
        const unsigned coil = *options_.status_coils + bit;
        const auto address = static_cast<std::uint16_t>(coil);
        if (coil <= 0xFFFF && unit.banks.readable(wire::Area::coil, address, 1) &&
            unit.banks.bit(wire::Area::coil, address))
            status |= 1U << bit;
    }
    return static_cast<std::uint8_t>(status);
}

Diagnostics::Refusal Diagnostics::diagnose(const wire::RequestView& request, Answer& answer) {
    if (!request.sub_function()) return ExceptionCode::illegal_data_value;
    const std::uint16_t sub_function = *request.sub_function();
    if (!is_known(sub_function)) return ExceptionCode::illegal_function;
    if (sub_function == kRestart && !options_.may_restart) return ExceptionCode::illegal_function;
    if (sub_function == kListenOnly && !options_.may_listen_only) return ExceptionCode::illegal_function;
    if (!request.well_formed()) return ExceptionCode::illegal_data_value;
    if (sub_function == kReturnQueryData) {
        answer.pdu.assign(request.pdu());
        return {};
    }
    if (sub_function == kRestart) return restart(request, answer);
    const std::uint16_t expected = sub_function == kAsciiDelimiter ? kLineFeed : 0;
    if (word(request.data(), 0) != expected) return ExceptionCode::illegal_data_value;
    if (sub_function == kListenOnly) return listen_only(answer);
    answer.pdu.assign(request.pdu().first(kHead));
    const std::uint16_t* const value = counter(sub_function);
    put_word(answer.pdu, value ? *value : expected);
    if (sub_function == kClearOverruns) counts_.overruns = 0;
    if (sub_function == kClearCounters) {
        counts_ = {};
        register_ = 0;
    }
    return {};
}

Diagnostics::Refusal Diagnostics::restart(const wire::RequestView& request, Answer& answer) {
    const std::uint16_t data = word(request.data(), 0);
    if (data != 0 && data != kClearLog) return ExceptionCode::illegal_data_value;
    if (listen_only_)
        answer.kind = Answer::Kind::silence;
    else
        answer.pdu.assign(request.pdu());
    listen_only_ = false;
    counts_ = {};
    if (log_ && data == kClearLog) log_->clear();
    log(kRestarted);
    return {};
}

Diagnostics::Refusal Diagnostics::listen_only(Answer& answer) {
    listen_only_ = true;
    answer.kind = Answer::Kind::silence;
    log(kEnteredListenOnly);
    return {};
}

const std::uint16_t* Diagnostics::counter(std::uint16_t sub_function) const {
    switch (sub_function) {
        case kReturnRegister: return &register_;
        case kFirstCounter: return &counts_.messages;
        case kFirstCounter + 1: return &counts_.errors;
        case kFirstCounter + 2: return &counts_.exceptions;
        case kFirstCounter + 3: return &counts_.own_messages;
        case kFirstCounter + 4: return &counts_.silences;
        case kFirstCounter + 5: return &counts_.refusals;
        case kFirstCounter + 6: return &counts_.busy;
        case kLastCounter: return &counts_.overruns;
        default: return nullptr;
    }
}

void Diagnostics::tell_log(Answer& answer) const {
    constexpr unsigned kHeader = 6;  // status, event count and message count
    answer.pdu.push_back(static_cast<std::uint8_t>(kHeader + log_->size()));
    put_word(answer.pdu, 0);
    put_word(answer.pdu, counts_.events);
    put_word(answer.pdu, counts_.messages);
    for (std::size_t age = 0; age < log_->size(); ++age) answer.pdu.push_back((*log_)[age]);
}

}  // namespace takt::serve
