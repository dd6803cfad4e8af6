// The IP packets of a network interface, as they pass (packet(7)).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::os {

/// A packet from its IP header on. Valid during the call that passes it.
struct ReceivedPacket {
    std::int64_t time_ns = 0;  ///< since 1970, when the kernel had it
    std::size_t length = 0;    ///< on the wire, at least data.size()
    std::span<const std::uint8_t> data;
};

/// Listens on an interface, or on all of them ("any"). Nothing is sent, and the interface keeps its mode. On
/// the loopback interface each packet is passed once. One owner, one thread.
class PacketSocket {
public:
    /// @returns cannot_open with the interface and the system's error number: EPERM without CAP_NET_RAW,
    ///          ENODEV for an unknown interface
    [[nodiscard]] static Result<PacketSocket> open(const std::string& interface);
    ~PacketSocket();
    PacketSocket(PacketSocket&& other) noexcept;
    PacketSocket& operator=(PacketSocket&&) = delete;

    [[nodiscard]] int descriptor() const { return socket_.get(); }

    /// Passes some of the packets that have come, without waiting. @returns false: the socket is empty;
    /// io_failed: the interface went down or away
    [[nodiscard]] Result<bool> read(const std::function<void(const ReceivedPacket&)>& sink);

    /// The kernel adds no packet after this call, and does not count later ones as dropped. read() still
    /// passes those that wait. @returns io_failed
    [[nodiscard]] Result<void> stop_receiving();

    /// Packets that the kernel could not keep, up to now.
    [[nodiscard]] std::uint64_t dropped();

private:
    struct Buffers;
    PacketSocket(std::string interface, Descriptor socket);

    std::string interface_;
    Descriptor socket_;
    std::unique_ptr<Buffers> buffers_;
    std::uint64_t dropped_ = 0;
};

}  // namespace takt::os
