// The packets of a network interface, read until a signal or the command ends it.
#pragma once

#include <functional>
#include <string>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/os/packet_socket.hpp"
#include "texts.hpp"

namespace takt::app {

struct PacketHandlers {
    std::function<void(const os::ReceivedPacket&)> on_packet;
    /// Called after each read, at least once in each interval. Not called for packets that are read after the
    /// end if there are none. @returns false: the command wants no more packets; its errors end the reading
    std::function<Result<bool>()> on_read;
};

/// Prints that it listens, then passes the packets until a signal comes (see StoppableInput) or on_read()
/// returns false. At that moment the kernel stops to add packets, and those that wait in the socket are
/// passed. A busy interface therefore cannot prolong the reading.
/// @param interface  the name for messages
/// @param interval   longest time between two calls of on_read()
/// @returns io_failed, and the errors of on_read()
[[nodiscard]] Result<void> read_packets(const Texts& texts, const std::string& interface,
                                        os::PacketSocket& socket, Duration interval,
                                        const PacketHandlers& handlers);

}  // namespace takt::app
