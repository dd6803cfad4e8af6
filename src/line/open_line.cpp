#include "takt/line/driver.hpp"

namespace takt::line {

Result<std::unique_ptr<Driver>> open_line(Loop& loop, const model::Line& line, Engine& engine,
                                          const DriverOptions& options) {
    switch (line.transport) {
        case model::Transport::serial: {
            SerialSettings settings;
            settings.path = line.port;
            settings.format = line.format;
            settings.rs485 = line.rs485;
            return open_serial(loop, settings, engine, options);
        }
        case model::Transport::tcp: return connect_tcp(loop, line.port, line.tcp_port, engine, options);
        case model::Transport::tls:
        case model::Transport::simulated: break;
    }
    return fail(Code::unsupported, model::name(line.transport));
}

}  // namespace takt::line
