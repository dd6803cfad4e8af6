// Lines of Modbus TCP, and frames of their devices.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "bench.hpp"

namespace takt::poll::test {

using Frame = std::vector<std::uint8_t>;

/// The PDU of a frame with an MBAP header.
inline Frame pdu_of(const Frame& frame) {
    return {frame.begin() + 7, frame.end()};
}

/// The response with this PDU of up to 253 bytes: the transaction and the unit are those of the request.
inline Frame tcp_response(const Frame& request, const Frame& pdu) {
    Frame response{request[0], request[1], 0, 0, 0, static_cast<std::uint8_t>(pdu.size() + 1), request[6]};
    response.insert(response.end(), pdu.begin(), pdu.end());
    return response;
}

/// A project with one line of Modbus TCP.
inline model::Project tcp_project(std::vector<model::Device> devices) {
    auto made = project(std::move(devices));
    made.lines[0].framing = wire::Framing::tcp;
    made.lines[0].transport = model::Transport::tcp;
    return made;
}

}  // namespace takt::poll::test
