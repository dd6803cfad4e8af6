#include "takt/client/client.hpp"

#include <algorithm>
#include <optional>

#include "takt/bus/expected_wait.hpp"
#include "takt/bus/outcome_status.hpp"

namespace takt::client {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr std::size_t kResponsesToKnow = 8;
constexpr int kLateFactor = 4;  // of the time-out
constexpr int kMostCloses = 2;  // connections that the peer may close instead of answering one request

}  // namespace

Result<std::unique_ptr<Client>> Client::open(line::Loop& loop, const Options& options,
                                             const line::TrafficFactory& traffic) {
    TAKT_TRY(auto connection, connect(loop, options, traffic));
    return std::make_unique<Client>(std::move(connection), options);
}

Error Client::timed_out() const {
    return fail(Code::timed_out, options_.target, duration_cast<milliseconds>(options_.timeout).count())
        .error();
}

Error Client::link_lost() const {
    auto error = fail(Code::connection_lost, options_.target).error();
    const auto why = connection_->link_error();
    if (why && (why->code == Code::not_modbus || why->code == Code::tls_failed)) {
        error.code = why->code;
        error.numbers = why->numbers;
    }
    return error;
}

Error Client::error_of(const bus::Outcome& outcome) const {
    if (outcome.instead) return misdirected(options_.target, *outcome.instead);
    switch (outcome.status) {
        case bus::Status::bad_checksum: return fail(Code::bad_checksum, options_.target).error();
        case bus::Status::unexpected_reply: return fail(Code::unexpected_reply, options_.target).error();
        case bus::Status::link_lost: return link_lost();
        case bus::Status::closed: return fail(Code::closed_by_peer, options_.target).error();
        case bus::Status::timeout:
        case bus::Status::ambiguous:
        case bus::Status::line_busy:
        case bus::Status::cancelled:
        case bus::Status::ok:
        case bus::Status::exception: break;
    }
    return timed_out();
}

// A lost response is found lost as soon as it is later than all before; only the last attempt waits for the
// full time-out. After one late response the measured times are no bound any more.
Duration Client::expected_wait() const {
    const bool known = options_.adaptive && responses_ >= kResponsesToKnow &&
                       connection_->engine().counters().late_answers == 0;
    return known ? bus::expected_wait(slowest_, options_.timeout) : options_.timeout;
}

void Client::learn(const bus::Outcome& outcome) {
    ++responses_;
    slowest_ = std::max(slowest_, outcome.ended_at - outcome.request_end);
}

Result<bus::Outcome> Client::transmit_once(const wire::PreparedRequest& request, Duration wait) {
    auto& engine = connection_->engine();
    pause(Duration::zero());  // the peer may have closed it meanwhile
    if (!connection_->up() && !connection_->reopen(options_.timeout)) return std::unexpected(link_lost());
    bus::Transaction transaction;
    transaction.id = next_id_++;
    transaction.unit = UnitId{options_.unit};
    transaction.request = request;
    transaction.wait = wait;
    transaction.late_limit = std::min(options_.timeout, kLateFactor * wait);
    if (const auto taken = engine.submit(connection_->now(), transaction); !taken)
        return std::unexpected(taken.error().code == Code::connection_lost ? link_lost() : taken.error());
    connection_->poke();
    std::optional<bus::Outcome> outcome;
    // Late responses of an earlier attempt may hold this one back for as long as the time-out again.
    const Duration limit = 3 * options_.timeout + std::chrono::seconds(2);
    const auto ended = [&] {
        while (!outcome || outcome->id != transaction.id) {
            outcome = engine.take_outcome();  // also those of requests given up before
            if (!outcome) break;
        }
        return outcome.has_value() || engine.must_reconnect();
    };
    connection_->run_until(ended, limit);
    if (outcome) return *outcome;
    if (engine.must_reconnect()) {
        auto error = engine.rejection().value_or(Error{.code = Code::not_modbus});
        error.subject = std::string_view(options_.target);
        return std::unexpected(error);
    }
    return std::unexpected(timed_out());
}

void Client::pause(Duration time) {
    connection_->run_until([] { return false; }, time);
}

// A response that came shows that the device is there: only the time-out is too short.
void Client::name_late_response(Error& error) {
    auto& engine = connection_->engine();
    Duration delay{};
    const auto is_late = [&] {
        while (const auto late = engine.take_late())
            if (late->delay > late->wait) delay = std::max(delay, late->delay);
        return delay > Duration::zero();
    };
    connection_->run_until(is_late, options_.late_wait);
    if (delay == Duration::zero()) return;
    error.numbers[1] = std::chrono::ceil<milliseconds>(delay).count();
    error.numbers[2] = duration_cast<milliseconds>(bus::advised_timeout(delay)).count();
}

Result<wire::ResponseView> Client::transact(const wire::PreparedRequest& request, bool repeatable) {
    const auto attempts = static_cast<std::uint16_t>(repeatable ? options_.attempts : 1);
    Error error;
    std::uint16_t failures = 0;
    int closes = 0;
    for (bool again = true; again && !interrupted();) {
        const bool last = failures + 1 >= attempts;
        TAKT_TRY(const auto outcome, transmit_once(request, last ? options_.timeout : expected_wait()));
        if (outcome.status == bus::Status::ok || outcome.status == bus::Status::exception) {
            learn(outcome);
            return outcome.response;
        }
        error = error_of(outcome);
        const bool closed = outcome.status == bus::Status::closed;
        again = repeatable && outcome.status != bus::Status::link_lost &&
                (closed ? ++closes < kMostCloses
                        : bus::attempts_left(bus::status_of(outcome).status, attempts, failures));
    }
    if (error.code == Code::timed_out && !interrupted()) name_late_response(error);
    return std::unexpected(error);
}

Result<wire::ResponseView> Client::ask(const wire::Request& request) {
    TAKT_TRY(const auto prepared, wire::prepare(request));
    TAKT_TRY(const auto response, transact(prepared));
    if (response.is_exception()) return fail(Code::modbus_exception, options_.target, response.exception());
    return response;
}

Result<void> Client::order(const wire::Request& request) {
    TAKT_CHECK(ask(request));
    return {};
}

}  // namespace takt::client
