#include "takt/client/connection.hpp"

#include <cerrno>
#include <optional>
#include <utility>

#include "takt/line/driver.hpp"
#include "takt/line/real_line.hpp"
#include "takt/line/target.hpp"

namespace takt::client {
namespace {

using std::chrono::duration_cast;
using std::chrono::milliseconds;

/// An engine whose closed connection is made again when the client needs it.
class Reopened final : public Engine {
public:
    explicit Reopened(bus::TransactionCore& engine) : engine_(engine) {}

    void need() { needed_ = true; }

    void on_link(Instant t, bool up) override {
        needed_ = needed_ && !up;
        engine_.on_link(t, up);
    }
    /// A stream that is out of step is no answer: what the peer sent is in the reason of the link.
    void on_close(Instant t) override {
        if (engine_.must_reconnect())
            engine_.on_link(t, false);
        else
            engine_.on_close(t);
    }
    [[nodiscard]] std::optional<Instant> opens_at() const override {
        return needed_ ? Instant::min() : kNever;
    }
    [[nodiscard]] std::optional<Error> rejection() const override { return engine_.rejection(); }
    void on_bytes(Instant t, Bytes bytes) override { engine_.on_bytes(t, bytes); }
    void on_tick(Instant t) override { engine_.on_tick(t); }
    [[nodiscard]] Bytes transmit(Instant t) override { return engine_.transmit(t); }
    [[nodiscard]] Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    bus::TransactionCore& engine_;
    bool needed_ = false;
};

bus::LineConfig one_at_a_time(bus::LineConfig config) {
    config.length_tolerance = config.framing == wire::Framing::tcp;
    return config;
}

class RealConnection final : public Connection {
public:
    RealConnection(line::Loop& loop, const model::Line& line, std::shared_ptr<wire::TrafficObserver> traffic)
        : loop_(loop),
          traffic_(std::move(traffic)),
          engine_(one_at_a_time(one_off_line(line)), traffic_.get()),
          reopened_(engine_) {}

    Result<void> open(const model::Line& line, const Options& options, const OpenLine& open_line) {
        line::DriverOptions driver;
        driver.connect_limit = options.timeout;
        driver.on_link = [this](Instant, bool, const std::optional<Error>& why) { link_error_ = why; };
        driver.on_close = [this](Instant, const std::optional<Error>& why) {
            if (why && (why->code == Code::not_modbus || why->code == Code::tls_failed)) link_error_ = why;
        };
        driver.must_reconnect = [this] { return engine_.must_reconnect(); };
        TAKT_TRY(driver_, open_line(loop_, line, reopened_, driver));
        loop_.run_until([this] { return up() || link_error_.has_value(); }, options.timeout);
        if (up()) return {};
        if (link_error_) return std::unexpected(*link_error_);
        if (line.transport != model::Transport::serial)
            return fail(Code::cannot_open, line::host_and_port(line.port, line.tcp_port),
                        stopped() ? ECANCELED : ETIMEDOUT);
        return fail(Code::timed_out, options.target, duration_cast<milliseconds>(options.timeout).count());
    }

    bus::TransactionCore& engine() override { return engine_; }
    void poke() override { driver_->poke(); }
    [[nodiscard]] bool up() const override { return driver_->up(); }
    bool reopen(Duration limit) override {
        if (up()) return true;
        link_error_.reset();
        reopened_.need();
        poke();
        loop_.run_until([this] { return up() || link_error_.has_value(); }, limit);
        return up();
    }
    [[nodiscard]] std::optional<Error> link_error() const override { return link_error_; }
    [[nodiscard]] Instant now() const override { return line::now(); }
    void run_until(const std::function<bool()>& done, Duration limit) override {
        loop_.run_until(done, limit);
    }
    [[nodiscard]] bool stopped() const override { return loop_.stopped(); }

private:
    line::Loop& loop_;
    std::shared_ptr<wire::TrafficObserver> traffic_;
    bus::TransactionEngine engine_;
    Reopened reopened_;
    std::unique_ptr<line::Driver> driver_;
    std::optional<Error> link_error_;
};

}  // namespace

bus::LineConfig one_off_line(const model::Line& line) {
    bus::LineConfig config;
    config.framing = line.framing;
    config.format = line.format;
    if (line.transport != model::Transport::serial) config.echo = bus::Echo::absent;
    return line::fit_to_real_line(config, line);
}

Result<std::unique_ptr<Connection>> connect(line::Loop& loop, const Options& options,
                                            const line::TrafficFactory& traffic) {
    TAKT_TRY(const auto target, line::parse_target(options.target));
    return connect(loop, target.as_line(), options, line::open_line, traffic);
}

Result<std::unique_ptr<Connection>> connect(line::Loop& loop, const model::Line& line, const Options& options,
                                            const OpenLine& open, const line::TrafficFactory& traffic) {
    auto connection = std::make_unique<RealConnection>(loop, line, traffic ? traffic(line) : nullptr);
    TAKT_CHECK(connection->open(line, options, open));
    return connection;
}

}  // namespace takt::client
