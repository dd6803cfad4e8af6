#include "load_connection.hpp"

#include <algorithm>

#include "takt/line/real_line.hpp"

namespace takt::client {
namespace {

template <class Flights, class Match>
auto take_first(Flights& flights, const Match& match) {
    const auto found = std::ranges::find_if(flights, match);
    std::optional<typename Flights::value_type> taken;
    if (found == flights.end()) return taken;
    taken = *found;
    std::copy(found + 1, flights.end(), found);
    flights.pop_back();
    return taken;
}

}  // namespace

Result<void> LoadConnection::open(const model::Line& line, const OpenLine& open_line) {
    line::DriverOptions driver;
    driver.connect_limit = load_.options_.target.timeout;
    driver.on_link = [this](Instant, bool, const std::optional<Error>& why) { link_error_ = why; };
    driver.must_reconnect = [this] { return engine_.must_reconnect(); };
    TAKT_TRY(driver_, open_line(load_.loop_, line, *this, driver));
    return {};
}

void LoadConnection::on_link(Instant t, bool up) {
    engine_.on_link(t, up);
    load_.up_at_ = t;
    if (!up && load_.running_) ++load_.counts_.disconnections;
    proceed(t);
}

void LoadConnection::on_bytes(Instant t, Bytes bytes) {
    engine_.on_bytes(t, bytes);
    proceed(t);
}

void LoadConnection::on_tick(Instant t) {
    engine_.on_tick(t);
    proceed(t);
}

void LoadConnection::proceed(Instant t) {
    while (const auto outcome = engine_.take_outcome()) conclude(*outcome);
    take_late();
    while (has_room() && load_.due(t)) take_one(t);
}

void LoadConnection::take_one(Instant t) {
    const auto due = *load_.due(t);
    bus::Transaction transaction;
    transaction.id = due.number;
    transaction.unit = UnitId{load_.options_.target.unit};
    transaction.request = load_.options_.request;
    transaction.wait = load_.options_.target.timeout;
    load_.take();
    if (const auto taken = engine_.submit(t, transaction); !taken) {
        load_.failure_ = taken.error();
        return;
    }
    flights_.push_back({due.number, due.intended});
    ++load_.in_flight_;
}

void LoadConnection::conclude(const bus::Outcome& outcome) {
    auto flight = take_first(flights_, [&](const Flight& each) { return each.number == outcome.id; });
    if (!flight) return;
    --load_.in_flight_;
    auto& counts = load_.counts_;
    if (outcome.sent) ++counts.sent;
    flight->sent_at = outcome.sent_at;
    flight->request_end = outcome.request_end;
    flight->wire_id = outcome.wire_id;
    load_.report_.on_request(load_.observed(flight->number, flight->request_end));
    switch (outcome.status) {
        case bus::Status::ok:
            compare(outcome.response.pdu());
            answered(*flight, outcome.ended_at, 0);
            break;
        case bus::Status::exception: answered(*flight, outcome.ended_at, outcome.exception); break;
        case bus::Status::timeout:
        case bus::Status::ambiguous:
            ++counts.timed_out;
            if (timed_out_.full()) {
                no_response(timed_out_[0], capture::NoResponse::unanswered);
                timed_out_.drop_front(1);
            }
            timed_out_.push_back(*flight);
            break;
        case bus::Status::bad_checksum:
        case bus::Status::unexpected_reply:
            ++counts.wrong;
            no_response(*flight, capture::NoResponse::unanswered);
            break;
        case bus::Status::link_lost:
        case bus::Status::closed:
            ++counts.lost;
            no_response(*flight, capture::NoResponse::unanswered);
            break;
        case bus::Status::line_busy: no_response(*flight, capture::NoResponse::unanswered); break;
        case bus::Status::cancelled: no_response(*flight, capture::NoResponse::end); break;
    }
}

// On a serial line the time of a request that was due earlier begins as much later as its bytes take.
void LoadConnection::answered(const Flight& flight, Instant end, std::uint8_t exception) {
    auto& load = load_;
    const Instant begin =
        load.options_.rate ? flight.intended + (flight.request_end - flight.sent_at) : flight.request_end;
    load.counts_.from_sending.record(end - flight.request_end);
    ++load.second_.responses;
    load.second_.longest = std::max<Duration>(load.second_.longest, end - begin);
    load.report_.on_response(load.observed(flight.number, begin),
                             {.packet = {flight.number + 1, load.wall_ns(end)}, .exception = exception});
}

void LoadConnection::no_response(const Flight& flight, capture::NoResponse why) {
    load_.report_.on_no_response(load_.observed(flight.number, flight.request_end), why);
}

// Another request of this connection may have the same id after 65,536 ones, and not before.
bool LoadConnection::may_answer(const Flight& flight, std::uint16_t wire_id) const {
    constexpr std::uint64_t kMostBetween = 65'000;
    return flight.wire_id == wire_id && load_.next_ - flight.number < kMostBetween;
}

void LoadConnection::on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) {
    if (direction == wire::Direction::sent || timed_out_.empty()) return;
    if (unit.value != load_.options_.target.unit || pdu.empty() ||
        wire::requested_function(pdu[0]) != load_.options_.request.function())
        return;
    if (!numbered_) {
        if (received_.full()) received_.drop_front(1);
        received_.push_back({t, {}});
        return received_.back().pdu.assign(pdu);
    }
    if (raw.size() < 2) return;
    const auto wire_id = static_cast<std::uint16_t>(raw[0] << 8U | raw[1]);
    const auto flight = take_first(timed_out_, [&](const Flight& each) { return may_answer(each, wire_id); });
    if (!flight) return;
    ++late_;
    answered_late(*flight, t, pdu);
}

// Several frames of one read have the same time. Of them the oldest is the response to the oldest request.
wire::Pdu LoadConnection::take_received(Instant at) {
    const auto received = take_first(received_, [at](const Received& each) { return each.at == at; });
    return received ? received->pdu : wire::Pdu();
}

// On a serial line a late response belongs to the oldest request that has none. Another frame may have
// followed it.
void LoadConnection::take_late() {
    while (const auto late = engine_.take_late()) {
        if (numbered_) continue;
        const auto flight = take_first(timed_out_, [](const Flight&) { return true; });
        const auto pdu = take_received(late->at);
        if (flight) answered_late(*flight, late->at, pdu.span());
    }
}

void LoadConnection::answered_late(const Flight& flight, Instant end, Bytes pdu) {
    const auto& request = load_.options_.request;
    const auto response = wire::decode_response(request.shape(), request.pdu(), pdu);
    if (!response && numbered_) {
        ++load_.counts_.wrong;
        return no_response(flight, capture::NoResponse::unanswered);
    }
    if (response && !response->is_exception()) compare(pdu);
    answered(flight, end, response ? response->exception() : std::uint8_t{0});
}

std::uint64_t LoadConnection::unexpected() const {
    const auto& counters = engine_.counters();
    return numbered_ ? counters.late_answers + counters.foreign_frames - late_ : 0;
}

void LoadConnection::compare(Bytes pdu) {
    if (!load_.options_.same_content) return;
    auto& first = load_.first_content_;
    if (first.empty())
        first.assign(pdu.begin(), pdu.end());
    else if (!std::ranges::equal(first, pdu))
        ++load_.counts_.different;
}

void LoadConnection::end(Instant t) {
    engine_.cancel_all(t);
    while (const auto outcome = engine_.take_outcome()) conclude(*outcome);
    for (const auto& flight : timed_out_) no_response(flight, capture::NoResponse::unanswered);
    timed_out_.clear();
}

}  // namespace takt::client
