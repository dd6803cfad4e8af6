// The socket is of type SOCK_DGRAM: the kernel removes any link layer. recvmmsg() takes many
// packets in one call; the memory-mapped ring (TPACKET_V3) would save a copy, which Modbus does not need.
#include "takt/os/packet_socket.hpp"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <utility>

namespace takt::os {
namespace {

constexpr std::size_t kPackets = 32;      // of one call
constexpr std::size_t kPacket = 1 << 16;  // the greatest IP packet; longer ones are cut
constexpr int kKernelBuffer = 32 << 20;   // bytes for packets that wait, where the process may ask for them

std::int64_t time_of(msghdr& message) {
    for (auto* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
        if (part->cmsg_level != SOL_SOCKET || part->cmsg_type != SCM_TIMESTAMPNS) continue;
        timespec time{};
        std::memcpy(&time, CMSG_DATA(part), sizeof time);
        return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec;
    }
    timespec now{};
    ::clock_gettime(CLOCK_REALTIME, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::optional<unsigned> index_of(const std::string& interface) {
    if (interface == "any") return 0;
    const unsigned index = ::if_nametoindex(interface.c_str());
    return index == 0 ? std::nullopt : std::optional(index);
}

}  // namespace

struct PacketSocket::Buffers {
    std::array<std::array<std::uint8_t, kPacket>, kPackets> data;
    std::array<std::array<std::uint8_t, CMSG_SPACE(sizeof(timespec))>, kPackets> control;
    std::array<sockaddr_ll, kPackets> addresses;
    std::array<iovec, kPackets> parts;
    std::array<mmsghdr, kPackets> messages;
    unsigned loopback = ::if_nametoindex("lo");

    void prepare() {
        for (std::size_t i = 0; i < kPackets; ++i) {
            parts[i] = {.iov_base = data[i].data(), .iov_len = kPacket};
            messages[i] = {};
            auto& head = messages[i].msg_hdr;
            head.msg_name = &addresses[i];
            head.msg_namelen = sizeof addresses[i];
            head.msg_iov = &parts[i];
            head.msg_iovlen = 1;
            head.msg_control = control[i].data();
            head.msg_controllen = control[i].size();
        }
    }

    /// An IP packet that is not the first of the two copies of the loopback interface.
    [[nodiscard]] bool is_wanted(std::size_t i) const {
        const auto& from = addresses[i];
        const auto protocol = ntohs(from.sll_protocol);
        if (protocol != ETH_P_IP && protocol != ETH_P_IPV6) return false;
        return from.sll_pkttype != PACKET_OUTGOING || static_cast<unsigned>(from.sll_ifindex) != loopback;
    }
};

Result<PacketSocket> PacketSocket::open(const std::string& interface) {
    const auto failed = [&interface] { return fail(Code::cannot_open, interface, errno); };
    const auto index = index_of(interface);
    if (!index) return failed();
    Descriptor socket(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    if (!socket) return failed();
    const int on = 1;
    if (::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUFFORCE, &kKernelBuffer, sizeof kKernelBuffer) != 0)
        (void)::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &kKernelBuffer, sizeof kKernelBuffer);
    (void)::setsockopt(socket.get(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_protocol = htons(ETH_P_ALL);
    address.sll_ifindex = static_cast<int>(*index);
    if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return failed();
    return PacketSocket(interface, std::move(socket));
}

PacketSocket::PacketSocket(std::string interface, Descriptor socket)
    : interface_(std::move(interface)), socket_(std::move(socket)), buffers_(std::make_unique<Buffers>()) {}
PacketSocket::PacketSocket(PacketSocket&& other) noexcept = default;
PacketSocket::~PacketSocket() = default;

Result<bool> PacketSocket::read(const std::function<void(const ReceivedPacket&)>& sink) {
    buffers_->prepare();
    const int count = ::recvmmsg(socket_.get(), buffers_->messages.data(), kPackets, MSG_TRUNC, nullptr);
    if (count < 0 && errno == EINTR) return true;
    if (count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return false;
    if (count < 0) return fail(Code::io_failed, interface_, errno);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        if (!buffers_->is_wanted(i)) continue;
        const std::size_t length = buffers_->messages[i].msg_len;
        sink({.time_ns = time_of(buffers_->messages[i].msg_hdr),
              .length = length,
              .data = {buffers_->data[i].data(), std::min(length, kPacket)}});
    }
    return true;
}

// The filter accepts no byte of a packet, so the kernel discards it. The queue is not filtered again.
Result<void> PacketSocket::stop_receiving() {
    sock_filter discard = BPF_STMT(BPF_RET | BPF_K, 0);
    const sock_fprog program{.len = 1, .filter = &discard};
    if (::setsockopt(socket_.get(), SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0)
        return fail(Code::io_failed, interface_, errno);
    return {};
}

std::uint64_t PacketSocket::dropped() {
    tpacket_stats statistics{};  // since the last call
    socklen_t size = sizeof statistics;
    if (::getsockopt(socket_.get(), SOL_PACKET, PACKET_STATISTICS, &statistics, &size) == 0)
        dropped_ += statistics.tp_drops;
    return dropped_;
}

}  // namespace takt::os
