#include "takt/app/client.hpp"

#include <algorithm>
#include <cerrno>

#include "takt/app/stop_signals.hpp"
#include "takt/line/real_line.hpp"
#include "takt/line/target.hpp"

namespace takt::app {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

constexpr std::size_t kAnswersToKnow = 8;
constexpr Duration kLeastExpected = milliseconds(50);
constexpr int kLateFactor = 4;

Error error_of(const bus::Outcome& outcome, const ClientOptions& options) {
    switch (outcome.status) {
        case bus::Status::bad_checksum: return fail(Code::bad_checksum, options.target).error();
        case bus::Status::unexpected_reply: return fail(Code::unexpected_reply, options.target).error();
        case bus::Status::link_lost: return fail(Code::connection_lost, options.target).error();
        case bus::Status::timeout:
        case bus::Status::line_busy:
        case bus::Status::cancelled:
        case bus::Status::ok:
        case bus::Status::exception: break;
    }
    return fail(Code::timed_out, options.target, duration_cast<milliseconds>(options.timeout).count())
        .error();
}

}  // namespace

bus::LineConfig one_off_line(const line::Target& target) {
    bus::LineConfig config;
    config.framing = target.framing;
    config.format = target.format;
    if (target.transport != model::Transport::serial) config.echo = bus::Echo::absent;
    return line::fit_to_real_line(config, target.as_line());
}

Result<std::unique_ptr<Client>> Client::open(const ClientOptions& options) {
    auto client = std::unique_ptr<Client>(new Client(options));
    TAKT_CHECK(client->connect());
    return client;
}

Result<void> Client::connect() {
    TAKT_TRY(const auto target, line::parse_target(options_.target));
    TAKT_TRY(loop_, line::Loop::create());
    if (!options_.traffic.empty()) {
        TAKT_TRY(log_, TrafficLog::open(options_.traffic));
        traffic_ = std::make_unique<LineTraffic>(*log_, target.as_line(), LineTraffic::Side::master);
    }
    TAKT_CHECK(on_stop(*loop_, [this] {
        interrupted_ = true;
        loop_->stop();
    }));
    engine_ = std::make_unique<bus::TransactionEngine>(one_off_line(target), traffic_.get());
    line::DriverOptions driver;
    driver.connect_limit = options_.timeout;
    driver.on_link = [this](Instant, bool, const std::optional<Error>& why) {
        if (why && !link_error_) link_error_ = why;
    };
    if (options_.reconnect) driver.must_reconnect = [this] { return engine_->must_reconnect(); };
    TAKT_TRY(driver_, line::open_target(*loop_, target, *engine_, driver));
    loop_->run_until([this] { return driver_->up() || link_error_.has_value(); }, options_.timeout);
    if (driver_->up()) return {};
    if (link_error_) return std::unexpected(*link_error_);
    if (target.transport != model::Transport::serial)
        return fail(Code::cannot_open, line::host_and_port(target.port, target.tcp_port),
                    interrupted_ ? ECANCELED : ETIMEDOUT);
    return fail(Code::timed_out, options_.target, duration_cast<milliseconds>(options_.timeout).count());
}

// An answer that comes later than all before is no reason to wait as long for each that is lost; only the
// repetition gets the full time. Once an answer came late, nothing is expected any more.
Duration Client::expected_wait() const {
    const bool known =
        options_.adaptive && answers_ >= kAnswersToKnow && engine_->counters().late_answers == 0;
    return known ? std::min(options_.timeout, 4 * slowest_ + kLeastExpected) : options_.timeout;
}

void Client::learn(const bus::Outcome& outcome) {
    ++answers_;
    slowest_ = std::max(slowest_, outcome.ended_at - outcome.request_end);
}

Result<bus::Outcome> Client::transmit_once(const wire::PreparedRequest& request, Duration wait) {
    bus::Transaction transaction;
    transaction.id = next_id_++;
    transaction.unit = UnitId{options_.unit};
    transaction.request = request;
    transaction.wait = wait;
    transaction.late_limit = std::min(options_.timeout, kLateFactor * wait);
    TAKT_CHECK(engine_->submit(line::now(), transaction));
    driver_->poke();
    std::optional<bus::Outcome> outcome;
    // Late answers of an earlier attempt may hold this one back for as long as the time-out again.
    const Duration limit = 3 * options_.timeout + std::chrono::seconds(2);
    const auto ended = [&] {
        while (!outcome || outcome->id != transaction.id) {
            outcome = engine_->take_outcome();  // also those of requests given up before
            if (!outcome) break;
        }
        return outcome.has_value() || engine_->must_reconnect();
    };
    loop_->run_until(ended, limit);
    if (!outcome && engine_->must_reconnect()) return fail(Code::malformed, options_.target);
    if (!outcome)
        return fail(Code::timed_out, options_.target, duration_cast<milliseconds>(options_.timeout).count());
    return *outcome;
}

void Client::pause(Duration time) {
    loop_->run_until([] { return false; }, time);
}

Result<wire::ResponseView> Client::transact(const wire::PreparedRequest& request, bool repeatable) {
    const int attempts = repeatable ? options_.attempts : 1;
    Error error;
    for (int attempt = 0; attempt < attempts && !interrupted_; ++attempt) {
        const bool last = attempt + 1 == attempts;
        TAKT_TRY(const auto outcome, transmit_once(request, last ? options_.timeout : expected_wait()));
        if (outcome.status == bus::Status::ok || outcome.status == bus::Status::exception) {
            learn(outcome);
            return outcome.response;
        }
        error = error_of(outcome, options_);
        if (outcome.status == bus::Status::link_lost) break;
    }
    return std::unexpected(error);
}

Result<wire::ResponseView> Client::ask(const wire::Request& request) {
    TAKT_TRY(const auto prepared, wire::prepare(request));
    TAKT_TRY(const auto response, transact(prepared));
    if (response.is_exception())
        return fail(Code::modbus_exception, options_.target, response.exception());
    return response;
}

Result<void> Client::order(const wire::Request& request) {
    TAKT_CHECK(ask(request));
    return {};
}

}  // namespace takt::app
