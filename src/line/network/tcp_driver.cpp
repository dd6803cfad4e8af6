// A TCP client connection as a state machine: resolve the name, try each address with a time limit, run the
// pump, and start again after a back-off.
#include <cerrno>
#include <utility>

#include "loop/pump.hpp"
#include "network/backoff.hpp"
#include "network/handshake.hpp"
#include "network/resolver.hpp"
#include "takt/line/connect_gate.hpp"
#include "takt/line/connection_limit.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/socket.hpp"

namespace takt::line {
namespace {

constexpr Duration kWriteLimit = std::chrono::seconds(10);  // a server that does not read counts as lost

class TcpDriver final : public Driver {
public:
    TcpDriver(Loop& loop, const std::string& host, std::uint16_t port, Engine& engine,
              const DriverOptions& options)
        : loop_(loop),
          host_(host),
          port_(port),
          name_(host_and_port(host, port)),
          engine_(engine),
          options_(options),
          backoff_(name_) {
        call_at(now());
    }

    void poke() override {
        if (pump_) return pump_->poke();
        if (waits_for_ == Wait::need) await_need(now());
    }
    bool up() const override { return pump_ != nullptr; }
    const std::string& name() const override { return name_; }

    DriverCounters counters() const override {
        DriverCounters all = counters_;
        if (pump_) add(all, *pump_);
        return all;
    }

private:
    /// What the timer ends.
    enum class Wait : std::uint8_t {
        back_off,
        need,     // the connection was closed; the engine's time goes on until it needs another one
        permit,   // for a connection to the host
        attempt,  // to connect
    };

    static void add(DriverCounters& sum, const Pump& pump) {
        sum.bytes_read += pump.counters().bytes_read;
        sum.bytes_written += pump.counters().bytes_written;
    }

    Error cannot_open(int number) const { return fail(Code::cannot_open, name_, number).error(); }

    Error no_tls() const {
        return fail(Code::tls_failed, name_, static_cast<int>(TlsFault::not_tls)).error();
    }

    // Created on first use: a connection that stays up needs no timer.
    void call_at(Instant t) {
        if (!timer_) timer_ = std::make_unique<Timer>(loop_, [this](Instant t) { on_time(t); });
        timer_->set(t);
    }

    void on_time(Instant t) {
        switch (waits_for_) {
            case Wait::back_off: return open();
            case Wait::permit: return enter_gate();
            case Wait::attempt: return attempt_failed(handshake_ ? no_tls() : cannot_open(ETIMEDOUT));
            case Wait::need: break;
        }
        if (t >= engine_.next_wakeup()) engine_.on_tick(t);
        await_need(t);
    }

    // Until the engine needs a connection, its time goes on here.
    void await_need(Instant t) {
        (void)engine_.transmit(t);  // chooses what comes next; without a link it sends nothing
        const auto opens_at = engine_.opens_at();
        if (!opens_at || *opens_at <= t) return open();
        call_at(std::max(std::min(*opens_at, engine_.next_wakeup()), t));
    }

    void open() {
        if (timer_) timer_->set(kNever);
        waits_for_ = Wait::permit;
        if (!options_.connection_limit) return enter_gate();
        permit_ =
            options_.connection_limit->ask(host_, options_.connections_per_host, [this] { call_at(now()); });
    }

    void enter_gate() {
        if (!options_.gate) return look_up();
        pass_ = options_.gate->ask([this] { look_up(); });
    }

    void look_up() {
        resolver_ =
            std::make_unique<Resolver>(loop_, host_, port_, [this](Result<std::vector<SocketAddress>> found) {
                resolver_.reset();
                if (!found) return down(now(), found.error());
                addresses_ = *std::move(found);
                next_ = 0;
                connect_next();
            });
    }

    void connect_next() {
        const SocketAddress& address = addresses_[next_++];
        auto opened = open_socket(address.family());
        if (!opened) return attempt_failed(opened.error());
        socket_ = *std::move(opened);
        set_connection_options(socket_.get());
        if (::connect(socket_.get(), address.get(), address.length) == 0) return greet();
        if (errno != EINPROGRESS) return attempt_failed(cannot_open(errno));
        connecting_ = std::make_unique<Watch>(loop_, socket_.get(), [] {}, [this] { judge_connection(); });
        connecting_->want_write();
        waits_for_ = Wait::attempt;
        call_at(now() + options_.connect_limit);
    }

    void judge_connection() {
        int error = 0;
        socklen_t length = sizeof error;
        if (::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error, &length) != 0) error = errno;
        if (error != 0) return attempt_failed(cannot_open(error));
        // TCP simultaneous open: a connect to a closed local port succeeds when the kernel picks that very
        // port as the source port. The result is a connection to itself.
        if (is_connected_to_itself(socket_.get())) return attempt_failed(cannot_open(ECONNREFUSED));
        greet();
    }

    // The gate counts a handshake as a part of the attempt: it is most of its work.
    void greet() {
        stop_connecting();
        if (!options_.tls) {
            auto stream = std::make_unique<SocketStream>(std::move(socket_), name_);
            if (options_.acknowledge_at_once) stream->acknowledge_at_once();
            return connected(std::move(stream));
        }
        auto begun = tls::Connection::begin(options_.tls, socket_.get(), host_, name_);
        if (!begun) return attempt_failed(begun.error());
        const auto done = [this](Result<std::unique_ptr<ByteStream>> stream, const std::string&) {
            if (!stream) return attempt_failed(stream.error());
            connected(*std::move(stream));
        };
        handshake_ = std::make_unique<Handshake>(loop_, std::move(socket_), *std::move(begun), nullptr, done);
        waits_for_ = Wait::attempt;
        call_at(now() + options_.connect_limit);
    }

    void attempt_failed(const Error& why) {
        stop_connecting();
        socket_.reset();
        if (next_ < addresses_.size()) return connect_next();
        ++counters_.failed_attempts;
        down(now(), why);
    }

    void stop_connecting() {
        connecting_.reset();
        handshake_.reset();
        if (timer_) timer_->set(kNever);
    }

    void connected(std::unique_ptr<ByteStream> stream) {
        stop_connecting();
        pass_ = {};
        timer_.reset();
        std::vector<SocketAddress>().swap(addresses_);
        stream_ = std::move(stream);
        PumpOptions pumping;
        pumping.finished = options_.must_reconnect;
        pumping.write_limit = kWriteLimit;
        pumping.reopens = true;
        pump_ = std::make_unique<Pump>(loop_, *stream_, engine_, std::move(pumping),
                                       [this](Instant t, const std::optional<Error>& why) { lost(t, why); });
        ++counters_.links;
        connected_at_ = now();
        if (!std::exchange(reopening_, false) && options_.on_link)
            options_.on_link(now(), true, std::nullopt);
        pump_->start();
    }

    // Without an error the engine asked for the end: the peer sends something else, or nothing, or there is
    // nothing to do. A peer that closes early would be asked again and again if its bytes ended the back-off.
    void lost(Instant t, std::optional<Error> why) {
        if (!why) why = rejection();
        if (pump_->counters().bytes_read > 0 && t - connected_at_ >= Backoff::kLongest) backoff_.reset();
        if (engine_.opens_at()) return closed(t, why);
        if (!why) why = fail(Code::timed_out, name_).error();
        add(counters_, *pump_);
        pump_.reset();
        stream_.reset();
        down(t, why);
    }

    std::optional<Error> rejection() const {
        auto why = engine_.rejection();
        if (why) why->subject = std::string_view(name_);
        return why;
    }

    void closed(Instant t, const std::optional<Error>& why) {
        add(counters_, *pump_);
        pump_.reset();
        stream_.reset();
        permit_ = {};
        reopening_ = true;
        waits_for_ = Wait::need;
        call_at(t);
        if (options_.on_close) options_.on_close(t, why);
    }

    void down(Instant t, const std::optional<Error>& why) {
        pass_ = {};
        permit_ = {};
        reopening_ = false;
        waits_for_ = Wait::back_off;
        call_at(t + backoff_.next());
        if (options_.on_link) options_.on_link(t, false, why);
    }

    Loop& loop_;
    std::string host_;
    std::uint16_t port_;
    std::string name_;
    Engine& engine_;
    DriverOptions options_;
    Backoff backoff_;
    DriverCounters counters_;
    std::unique_ptr<Resolver> resolver_;
    std::vector<SocketAddress> addresses_;
    std::size_t next_ = 0;
    os::Descriptor socket_;  // while connecting
    std::unique_ptr<Watch> connecting_;
    std::unique_ptr<Handshake> handshake_;
    std::unique_ptr<ByteStream> stream_;
    std::unique_ptr<Pump> pump_;
    ConnectGate::Pass pass_;
    Instant connected_at_;
    ConnectionLimit::Permit permit_;
    Wait waits_for_ = Wait::back_off;
    bool reopening_ = false;        // the connection that was closed is made again
    std::unique_ptr<Timer> timer_;  // limits the current attempt, else ends the back-off
};

}  // namespace

std::unique_ptr<Driver> connect_tcp(Loop& loop, const std::string& host, std::uint16_t port, Engine& engine,
                                    const DriverOptions& options) {
    return std::make_unique<TcpDriver>(loop, host, port, engine, options);
}

}  // namespace takt::line
