// A TCP port or a serial port at work.
#pragma once

#include <memory>
#include <string>

#include "takt/endpoint/environment.hpp"
#include "takt/endpoint/pending_answers.hpp"
#include "takt/endpoint/spec.hpp"
#include "takt/endpoint/statistics.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/serial_answers.hpp"
#include "takt/line/slave_session.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::endpoint {

/// Answers the requests that come to one port from a responder. Pending answers come back through
/// PendingAnswers.
class Listener {
public:
    /// @param spec, environment, responder, pending  outlive it
    Listener(const ListenerSpec& spec, const Environment& environment, serve::Responder& responder,
             PendingAnswers& pending);
    ~Listener();
    Listener(const Listener&) = delete;
    Listener& operator=(const Listener&) = delete;

    /// @returns what opening a serial port or an address returns
    [[nodiscard]] Result<void> open();

    /// "tcp://[::]:502", "rtu /dev/ttyS0 19200 bit/s".
    [[nodiscard]] std::string name() const;

    /// The counters so far, including those of open connections.
    [[nodiscard]] ListenerStatistics statistics() const;
    /// The same into what statistics() returned before, without allocating.
    void refresh(ListenerStatistics& statistics) const;

    /// Closes it, so that all connections are counted.
    [[nodiscard]] ListenerStatistics close();

private:
    Result<void> open_tcp();
    Result<void> open_serial();
    void note_link(bool up, const std::optional<Error>& why);

    const ListenerSpec& spec_;
    const Environment& environment_;
    serve::Responder& responder_;
    PendingAnswers& pending_;
    std::shared_ptr<wire::TrafficObserver> traffic_;
    // a serial port
    std::unique_ptr<serve::SerialSlave> slave_;
    std::unique_ptr<sim::FaultyEngine> faulty_slave_;
    std::unique_ptr<line::Driver> driver_;
    bool port_open_ = true;
    std::unique_ptr<line::SerialAnswers> serial_answers_;
    // a TCP port
    line::SlaveSessions sessions_;
    std::unique_ptr<line::TcpServer> server_;
};

}  // namespace takt::endpoint
