#include <algorithm>

#include "takt/poll/line_poller.hpp"

namespace takt::poll {

bus::LineConfig line_config(const model::Project& project, const model::Line& line) {
    bus::LineConfig config{.framing = line.framing,
                           .format = line.format,
                           .frame_gap = line.frame_gap,
                           .request_gap = line.request_gap,
                           .margin = project.timeout_margin};
    if (!line.is_serial()) config.format.baud = 0;
    if (line.byte_timeout) {
        config.frame_silence = *line.byte_timeout;
        if (config.is_serial())
            config.frame_silence = std::max(config.frame_silence, wire::t3_5(config.format));
    }
    if (line.framing == wire::Framing::tcp)
        for (const auto& device : line.devices)
            config.in_flight = std::max<std::size_t>(config.in_flight, device.in_flight);
    config.echo = line.transport == model::Transport::serial ? bus::Echo::automatic : bus::Echo::absent;
    return config;
}

}  // namespace takt::poll
