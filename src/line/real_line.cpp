#include "takt/line/real_line.hpp"

#include "takt/line/serial_port.hpp"

namespace takt::line {

bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line) {
    if (line.transport == model::Transport::serial && is_pseudo_terminal(line.port))
        config.echo = bus::Echo::untimed;
    return config;
}

}  // namespace takt::line
