#include <algorithm>

#include "takt/plan/request_job.hpp"
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
    config.in_flight = plan::requests_in_flight(line);
    config.length_tolerance = line.length_tolerance;
    config.pause_after_connect = line.connection.pause_after;
    config.echo = line.transport == model::Transport::serial ? bus::Echo::automatic : bus::Echo::absent;
    return config;
}

}  // namespace takt::poll
