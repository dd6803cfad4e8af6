#include "takt/line/real_line.hpp"

#include <random>

#include "serial/receive_trigger.hpp"
#include "takt/line/serial_port.hpp"

namespace takt::line {
namespace {

constexpr std::size_t kPause = 4;  // characters, after which a 16550 hands on fewer than its trigger

}  // namespace

bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line) {
    config.first_transaction = static_cast<std::uint16_t>(std::random_device{}());
    if (line.transport != model::Transport::serial) return config;
    if (is_pseudo_terminal(line.port)) config.echo = bus::Echo::untimed;
    const ReceiveTrigger trigger(line.port);
    if (trigger.characters().value_or(1) > 1 && !trigger.is_writable())
        config.margin += config.characters_time(kPause);
    return config;
}

}  // namespace takt::line
