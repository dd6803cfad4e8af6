#include "takt/poll/line_poller.hpp"

namespace takt::poll {

bus::LineConfig line_config(const model::Project& project, const model::Line& line) {
    bus::LineConfig config{.framing = line.framing,
                           .format = line.format,
                           .frame_gap = line.frame_gap,
                           .request_gap = line.request_gap,
                           .margin = project.timeout_margin};
    if (!line.is_serial()) config.format.baud = 0;
    config.echo = line.transport == model::Transport::serial ? bus::Echo::automatic : bus::Echo::absent;
    return config;
}

Duration answer_wait(const model::Project& project, const model::Device& device) {
    return project.derive_timeouts && device.turnaround ? *device.turnaround : device.response_timeout;
}

}  // namespace takt::poll
