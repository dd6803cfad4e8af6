#include "takt/os/packet_socket.hpp"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>

namespace takt::os {
namespace packet_socket_test {

/// Sends a datagram to a free port of the loopback interface.
void send_datagram(std::string_view text) {
    const Descriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(9);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const auto sent = ::sendto(socket.get(), text.data(), text.size(), 0,
                               reinterpret_cast<const sockaddr*>(&to), sizeof to);
    ASSERT_EQ(sent, static_cast<ssize_t>(text.size()));
}

TEST(PacketSocket, PassesEachPacketOfTheLoopbackInterfaceOnce) {
    auto socket = PacketSocket::open("lo");
    if (!socket) GTEST_SKIP() << "needs CAP_NET_RAW";
    const std::string text = "packet socket " + std::to_string(::getpid());
    send_datagram(text);
    send_datagram(text + " end");
    int found = 0;
    std::int64_t time_ns = 0;
    for (bool ended = false; !ended;) {
        pollfd waited{.fd = socket->descriptor(), .events = POLLIN, .revents = 0};
        ASSERT_EQ(::poll(&waited, 1, 5000), 1);
        ASSERT_TRUE(socket->read([&](const ReceivedPacket& packet) {
            const std::string_view bytes(reinterpret_cast<const char*>(packet.data.data()),
                                         packet.data.size());
            EXPECT_EQ(packet.length, packet.data.size());
            EXPECT_TRUE((packet.data[0] & 0xF0U) == 0x40U || (packet.data[0] & 0xF0U) == 0x60U);
            if (packet.data[9] != IPPROTO_UDP) return;  // the errors that the system sends repeat it
            if (bytes.ends_with(text)) ++found;
            if (bytes.ends_with(text + " end")) ended = true;
            time_ns = packet.time_ns;
        }));
    }
    EXPECT_EQ(found, 1);
    EXPECT_LT(std::abs(time_ns / 1'000'000'000 - ::time(nullptr)), 60);
    EXPECT_EQ(socket->dropped(), 0u);
}

TEST(PacketSocket, PassesWhatCameBeforeTheStopAndNothingElse) {
    auto socket = PacketSocket::open("lo");
    if (!socket) GTEST_SKIP() << "needs CAP_NET_RAW";
    const std::string text = "packet socket " + std::to_string(::getpid());
    send_datagram(text + " before");
    ASSERT_TRUE(socket->stop_receiving());
    send_datagram(text + " after");
    int before = 0;
    int after = 0;
    for (;;) {
        const auto more = socket->read([&](const ReceivedPacket& packet) {
            const std::string_view bytes(reinterpret_cast<const char*>(packet.data.data()),
                                         packet.data.size());
            if (packet.data[9] != IPPROTO_UDP) return;
            if (bytes.ends_with(text + " before")) ++before;
            if (bytes.ends_with(text + " after")) ++after;
        });
        ASSERT_TRUE(more);
        if (!*more) break;
    }
    EXPECT_EQ(before, 1);
    EXPECT_EQ(after, 0);
    EXPECT_EQ(socket->dropped(), 0u) << "packets after the stop are not counted";
}

TEST(PacketSocket, AnUnknownInterfaceIsAnError) {
    const auto socket = PacketSocket::open("takt-none");
    ASSERT_FALSE(socket);
    EXPECT_EQ(socket.error().code, Code::cannot_open);
    EXPECT_EQ(socket.error().subject.view(), "takt-none");
    EXPECT_EQ(socket.error().numbers[0], ENODEV);
}

}  // namespace packet_socket_test
}  // namespace takt::os
