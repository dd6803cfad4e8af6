#include "fault_injector.hpp"

#include <algorithm>
#include <utility>

#include "damage.hpp"

namespace takt::sim {
namespace {

constexpr int kMostRedraws = 100;
constexpr std::ptrdiff_t kRememberedBytes = 600;  // longer than any frame
constexpr std::size_t kRemembered = 16;           // answers of a device
constexpr Duration kMostLate = std::chrono::minutes(3);

constexpr std::uint64_t bit(FaultKind kind) {
    return std::uint64_t{1} << static_cast<unsigned>(kind);
}
static_assert(kFaultKinds <= 64);

bool is_drawn(FaultKind kind) {
    return !is_timed(kind) && !is_close(kind) && kind != FaultKind::connect_refused;
}

bool is_plain_write(Bytes pdu) {
    return pdu[0] == 0x05 || pdu[0] == 0x06 || pdu[0] == 0x0F || pdu[0] == 0x10 || pdu[0] == 0x16;
}

/// The usual simulated response: reads answer with address and value, other functions with their request.
wire::Pdu as_if_written(Bytes request) {
    constexpr std::size_t kAddressAndQuantity = 5;
    const bool several = request[0] == 0x0F || request[0] == 0x10;
    wire::Pdu answer;
    answer.assign(several ? request.first(kAddressAndQuantity) : request);
    return answer;
}

FaultKind kind_of(std::size_t index) {
    return static_cast<FaultKind>(index);
}

}  // namespace

FaultInjector::FaultInjector(const model::Line& line, Devices& devices, const FaultPlan& plan,
                             FaultObserver* observer)
    : framing_(line.framing),
      format_(line.format),
      serial_(line.is_serial()),
      devices_(devices),
      plan_(plan),
      observer_(observer),
      random_(plan.seed) {
    index_of_unit_.fill(-1);
    for (std::size_t i = 0; i < line.devices.size(); ++i) {
        index_of_unit_[line.devices[i].address.value] = static_cast<std::int16_t>(i);
        units_[line.devices[i].address.value] = true;
        states_.push_back(state_of(line.devices[i], i));
    }
    units_[0] = true;
}

void FaultInjector::run(Instant t, bool on) {
    running_ = on;
    begin_anew();
    if (started_ || !on) return;
    started_ = true;
    for (std::size_t k = 0; k < kFaultKinds; ++k) {
        if (is_of_line(kind_of(k))) schedule(t, kind_of(k), {});
        for (std::size_t i = 0; i < states_.size() && !is_of_line(kind_of(k)); ++i)
            schedule(t, kind_of(k), i);
    }
    update_next_event();
}

FaultInjector::State FaultInjector::state_of(const model::Device& device, std::size_t index) const {
    State state;
    state.rates = index < plan_.devices.size() ? plan_.devices[index] : plan_.rates;
    for (std::size_t k = 0; k < kFaultKinds; ++k) {
        const bool counts = is_drawn(kind_of(k)) && possible(kind_of(k), framing_, serial_);
        if (!counts) state.rates.per_million[k] = 0;
        state.sum += state.rates.per_million[k];
    }
    state.wait = device.wait(plan_.derive_timeouts);
    state.response_timeout = device.response_timeout;
    if (serial_ && framing_ == wire::Framing::rtu) state.wait = std::max(state.wait, wire::t3_5(format_));
    return state;
}

std::optional<std::size_t> FaultInjector::device_of(std::uint8_t unit) const {
    const int index = index_of_unit_[unit];
    return index < 0 ? std::nullopt : std::optional(static_cast<std::size_t>(index));
}

std::optional<FaultKind> FaultInjector::draw(std::optional<std::size_t> device) {
    if (quiet_ || states_.empty()) return {};
    const State& state = states_[device.value_or(0)];
    if (state.sum == 0) return {};
    std::uint32_t x = random_.below(1'000'000);
    if (x >= state.sum) return {};
    std::size_t k = 0;
    while (x >= state.rates.per_million[k]) x -= state.rates.per_million[k++];
    return kind_of(k);
}

void FaultInjector::count(Instant t, FaultKind kind, std::optional<std::size_t> device,
                          std::optional<Instant> until) {
    ++counts_.injected[static_cast<std::size_t>(kind)];
    (device ? states_[*device].ailing : line_ailing_) |= bit(kind);
    if (until) until = std::max(t, std::min(*until, plan_.quiet_from));  // no fault outlasts quiet_from
    if (observer_) observer_->on_fault({t, kind, device, until});
}

void FaultInjector::recovered(std::size_t device) {
    std::uint64_t& ailing = states_[device].ailing;
    if ((ailing | line_ailing_) == 0) return;
    for (std::size_t k = 0; k < kFaultKinds; ++k)
        counts_.recovered[k] += ((ailing | line_ailing_) & bit(kind_of(k))) != 0;
    ailing = line_ailing_ = 0;
}

// ---- an exchange

FaultInjector::Exchange FaultInjector::exchange_of(const serve::Context& context, std::size_t device,
                                                   Bytes request) const {
    const State& state = states_[device];
    Exchange exchange;
    exchange.device = device;
    exchange.request.assign(request);
    exchange.normal_length = answer_length(framing_, request);
    const Duration normal =
        serial_ ? wire::transmission_time(format_, exchange.normal_length) : Duration::zero();
    exchange.deadline = context.time + state.wait + plan_.timeout_margin + normal;
    return exchange;
}

serve::Answer FaultInjector::handle(const serve::Context& context, const wire::RequestView& request) {
    const Bytes pdu = request.pdu();
    const auto device = device_of(context.unit.value);
    if (context.broadcast || !device || states_[*device].silent) {
        const serve::Answer answer = devices_.handle(context, request);
        if (!context.broadcast && answer.kind != serve::Answer::Kind::silence) answering({});
        return answer;
    }
    Exchange exchange = exchange_of(context, *device, pdu);
    exchange.kind = drawn_for(*device, pdu);
    serve::Answer answer;
    if (exchange.kind == FaultKind::lost_request) {
        count(context.time, *exchange.kind, device);
        return answer;
    }
    if (exchange.kind == FaultKind::busy || exchange.kind == FaultKind::wrong_exception) {
        constexpr std::array kBusy{0x05, 0x06};
        constexpr std::array kWrong{0x00, 0x7F, 0xFF};
        const int code = exchange.kind == FaultKind::busy ? kBusy[random_.below(kBusy.size())]
                                                          : kWrong[random_.below(kWrong.size())];
        answer = serve::Answer::response(serve::exception_to(pdu[0], static_cast<wire::ExceptionCode>(code)),
                                         devices_[*device].behaviour.turnaround);
        count(context.time, *exchange.kind, device);
        exchange.kind.reset();
    } else if (exchange.kind == FaultKind::ignored_write && is_plain_write(pdu) &&
               !devices_[*device].behaviour.dead) {
        answer = serve::Answer::response(as_if_written(pdu), devices_[*device].behaviour.turnaround);
        count(context.time, *exchange.kind, device);
        exchange.kind.reset();
    } else {
        answer = devices_.handle(context, request);
    }
    if (answer.kind == serve::Answer::Kind::silence) return answer;
    delay_answer(exchange, answer);
    if (postpone(context.time, exchange, context.unit, answer)) return {};
    answering(exchange);
    return answer;
}

// On serial lines the delay is drawn here, because a device that works does not receive. On a stream the
// response is delayed on its way instead.
void FaultInjector::delay_answer(const Exchange& exchange, serve::Answer& answer) {
    const std::size_t device = *exchange.device;
    if (device < plan_.turnarounds.size() && plan_.turnarounds[device])
        answer.delay = quiet_ ? plan_.turnarounds[device]->least : plan_.turnarounds[device]->draw(random_);
}

// Each doubling is as likely as another.
Duration FaultInjector::lateness(std::size_t device) {
    const Duration wait = states_[device].wait;
    if (!plan_.merciless)
        return random_.between(wait + plan_.timeout_margin, wait + states_[device].response_timeout * 4 / 5);
    const auto factor = 1.2 * static_cast<double>(1U << random_.below(5)) * (1 + random_.fraction());
    const auto usual = Duration(static_cast<Duration::rep>(factor * static_cast<double>(wait.count())));
    if (random_.below(50) != 0) return std::min(usual, 40 * wait);
    return random_.between(std::min(40 * wait, kMostLate), kMostLate);
}

Duration FaultInjector::copy_delay() {
    constexpr std::array<Duration, 4> kMost{std::chrono::milliseconds(10), std::chrono::milliseconds(300),
                                            std::chrono::seconds(10), kMostLate};
    return random_.between(Duration::zero(), kMost[plan_.merciless ? random_.below(kMost.size()) : 0]);
}

bool FaultInjector::serves_again(std::size_t device) {
    return plan_.merciless && in_order(device) && random_.below(2) == 0;
}

Duration FaultInjector::service_time() {
    return random_.between(std::chrono::milliseconds(2), std::chrono::milliseconds(50));
}

ByteString FaultInjector::past_answer(std::size_t device, Bytes sent) {
    const auto now = open_frame(framing_, sent);
    std::vector<const ByteString*> fitting;
    for (const ByteString& past : states_[device].sent) {
        const auto then = open_frame(framing_, past);
        if (now && then && past.size() == sent.size() && then->pdu[0] == now->pdu[0] && then->pdu != now->pdu)
            fitting.push_back(&past);
    }
    if (fitting.empty()) return {};
    return *fitting[random_.below(static_cast<std::uint32_t>(fitting.size()))];
}

void FaultInjector::note_sent(std::size_t device, Bytes sent) {
    auto& all = states_[device].sent;
    all.emplace_back(sent.begin(), sent.end());
    if (all.size() > kRemembered) all.pop_front();
}

ByteString FaultInjector::glitch_for(Bytes frame, bool before) {
    ByteString glitch;
    (void)harmless(
        [&] {
            glitch = any_bytes(random_, 1 + random_.below(3));
            const auto kind = random_.below(3);
            if (kind < 2) std::ranges::fill(glitch, kind == 0 ? std::uint8_t{0x00} : std::uint8_t{0xFF});
            ByteString all = before ? glitch : ByteString(frame.begin(), frame.end());
            if (before)
                all.insert(all.end(), frame.begin(), frame.end());
            else
                all.insert(all.end(), glitch.begin(), glitch.end());
            return all;
        },
        frame);
    return glitch;
}

std::vector<std::uint8_t> FaultInjector::harmless(const std::function<std::vector<std::uint8_t>()>& make,
                                                  Bytes genuine) {
    for (int tries = 0; tries < kMostRedraws; ++tries) {
        std::vector<std::uint8_t> made = make();
        if (!could_mislead(made, false, genuine)) return made;
        ++counts_.redrawn;
    }
    return {};
}

bool FaultInjector::spoil_answer(FaultKind kind, const Exchange& exchange, Bytes sent,
                                 std::vector<std::uint8_t>& instead) {
    switch (kind) {
        case FaultKind::lost_response: return true;
        case FaultKind::bit_error:
        case FaultKind::lost_byte:
        case FaultKind::extra_byte:
        case FaultKind::repeated_byte:
            instead = harmless([&] { return spoil_characters(random_, kind, sent); }, sent);
            return true;
        case FaultKind::truncated:
            instead = harmless([&] { return cut_short(random_, sent); }, sent);
            return true;
        case FaultKind::garbage:
            instead = harmless([&] { return garbage_for(random_, framing_, sent); }, {});
            return true;
        default: break;
    }
    auto answer = open_frame(framing_, sent);
    if (!answer || !alters(kind, exchange.request.span(), *answer)) return false;
    const OpenFrame good = *answer;
    for (int tries = 0; tries < kMostRedraws; ++tries) {
        alter(random_, kind, units_, *answer);
        instead = close_frame(framing_, *answer);
        if (!could_mislead(instead, true, instead)) return true;
        ++counts_.redrawn;
        *answer = good;
    }
    instead.clear();
    return true;
}

bool FaultInjector::could_mislead(Bytes fresh, bool clean, Bytes genuine) const {
    if (framing_ == wire::Framing::tcp || (clean && tail_.empty())) return false;
    ByteString all = tail_;
    all.insert(all.end(), fresh.begin(), fresh.end());
    return sim::misleads(framing_, all, tail_.size(), clean, genuine, units_);
}

bool FaultInjector::lost_for_what_was_before(Bytes frame) {
    if (!could_mislead(frame, true, frame)) return false;
    ++counts_.redrawn;
    return true;
}

void FaultInjector::remember(Bytes received, bool good) {
    if (good && tail_.empty()) return;
    tail_.insert(tail_.end(), received.begin(), received.end());
    if (tail_.size() > kRememberedBytes) tail_.erase(tail_.begin(), tail_.end() - kRememberedBytes);
}

void FaultInjector::note_answer(Bytes received) {
    if (line_ailing_ == 0 && std::ranges::all_of(states_, [](const State& s) { return s.ailing == 0; }))
        return;
    const auto frame = open_frame(framing_, received);
    const auto device = frame ? device_of(frame->unit) : std::nullopt;
    if (device && !wire::is_exception(frame->pdu[0])) recovered(*device);
}

}  // namespace takt::sim
