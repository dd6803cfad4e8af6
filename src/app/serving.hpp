// Places at work: listening, or on a serial port.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "serve_places.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/line/answer_routes.hpp"
#include "takt/line/driver.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/slave_session.hpp"
#include "takt/line/tcp_server.hpp"
#include "takt/report/serve_report.hpp"
#include "takt/serve/serial_slave.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::app {

/// One place at work. Must not outlive its place.
struct Serving {
    std::unique_ptr<LineTraffic> traffic;
    std::unique_ptr<sim::FaultyResponder> faulty;
    std::unique_ptr<serve::SerialSlave> slave;
    std::unique_ptr<sim::FaultyEngine> faulty_slave;
    std::unique_ptr<line::Driver> driver;
    std::unique_ptr<line::SerialAnswers> serial_answers;
    std::unique_ptr<line::SlaveSessions> sessions;
    std::unique_ptr<line::TcpServer> server;
};

/// Opens the place. Its pending answers go the way of Place::answers.
/// @param log  of its frames; may be nullptr
/// @returns what opening a serial port or an address returns
[[nodiscard]] Result<Serving> start_serving(line::Loop& loop, const Place& place, TrafficLog* log);

/// "tcp://[::]:502", "rtu /dev/ttyS0 19200 bit/s".
[[nodiscard]] std::string place_name(const Place& place, const Serving& serving);

/// Where it answers, and for which units.
[[nodiscard]] std::string place_text(const Texts& texts, const Place& place, const Serving& serving);

/// Closes all places, so that their connections are counted too, and writes what is left to be written of
/// what they retain.
/// @param serving  of places[0], places[1], …
[[nodiscard]] report::ServeSummary end_serving(const std::vector<Place>& places,
                                               std::vector<Serving>& serving);

}  // namespace takt::app
