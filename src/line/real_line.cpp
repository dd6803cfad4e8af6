#include "takt/line/real_line.hpp"

#include "takt/line/serial_port.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::line {
namespace {

constexpr Duration kLumpPause =
    std::chrono::milliseconds(8);  // two slices of the scheduler of a busy machine

}  // namespace

bus::LineConfig fit_to_real_line(bus::LineConfig config, const model::Line& line) {
    if (line.transport != model::Transport::serial) return config;
    if (is_pseudo_terminal(line.port)) config.echo = bus::Echo::absent;
    if (config.frame_silence == Duration::zero())
        config.frame_silence = wire::t3_5(config.format) + kLumpPause;
    return config;
}

}  // namespace takt::line
