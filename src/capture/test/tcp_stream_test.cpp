// The invariant of each case: bytes are passed once, in the order of their numbers, in every order of the
// segments.
#include "takt/capture/tcp_stream.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace tcp_stream_test {

using namespace test;

struct Kept final : StreamSink {
    std::string text;  // "_" is a gap, "#" a cut segment
    std::vector<std::uint64_t> packets;
    void on_data(const PacketRef& packet, Bytes bytes) override {
        text.append(bytes.begin(), bytes.end());
        packets.push_back(packet.number);
    }
    void on_gap() override { text += '_'; }
    void on_cut(const PacketRef&, std::size_t count) override { text += '#' + std::to_string(count); }
};

class Sender {
public:
    explicit Sender(std::uint32_t first = 0xFFFFFFFE) : first_(first) { stream.begin(first); }

    void send(std::uint32_t at, std::string_view text, std::uint16_t identification = 0,
              std::uint32_t cut = 0) {
        const Octets bytes(text.begin(), text.end());
        Segment segment{.sequence = first_ + at,
                        .identification = identification,
                        .length = static_cast<std::uint32_t>(bytes.size())};
        segment.payload = Bytes(bytes).first(bytes.size() - cut);
        stream.push(segment, {.number = ++packet_}, kept);
    }
    void acknowledge(std::uint32_t at) { stream.acknowledged(first_ + at, kept); }

    TcpStream stream;
    Kept kept;

private:
    std::uint32_t first_;
    std::uint64_t packet_ = 0;
};

TEST(TcpStream, PassesBytesInOrderOverTheWrapOfNumbers) {
    Sender sender;
    sender.send(0, "ab");
    sender.send(2, "cde");
    EXPECT_EQ(sender.kept.text, "abcde");
    EXPECT_EQ(sender.stream.counts().segments, 2u);
}

TEST(TcpStream, SortsSegmentsOutOfOrder) {
    Sender sender;
    sender.send(4, "ef");
    sender.send(2, "cd");
    sender.send(0, "ab");
    EXPECT_EQ(sender.kept.text, "abcdef");
    EXPECT_EQ(sender.kept.packets, (std::vector<std::uint64_t>{3, 3, 3}))
        << "the third packet made all available";
    EXPECT_EQ(sender.stream.counts().out_of_order, 2u);
    EXPECT_EQ(sender.stream.counts().retransmissions, 0u);
}

TEST(TcpStream, DropsWhatWasThereBefore) {
    Sender sender;
    sender.send(0, "abcd");
    sender.send(0, "abcd");
    sender.send(1, "bc");
    EXPECT_EQ(sender.stream.counts().retransmissions, 2u);
    sender.send(2, "cdef");
    EXPECT_EQ(sender.stream.counts().overlaps, 1u);
    sender.send(8, "ij");
    sender.send(8, "ij");
    EXPECT_EQ(sender.stream.counts().retransmissions, 3u);
    sender.send(5, "fghijkl");
    EXPECT_EQ(sender.kept.text, "abcdefghijkl");
    EXPECT_EQ(sender.stream.counts().gaps, 0u);
}

TEST(TcpStream, APacketCapturedTwiceIsNoRetransmission) {
    Sender sender;
    sender.send(0, "ab", 7);
    sender.send(0, "ab", 7);
    EXPECT_EQ(sender.stream.counts().duplicates, 1u);
    EXPECT_EQ(sender.stream.counts().retransmissions, 0u);
    sender.send(0, "ab", 8);
    EXPECT_EQ(sender.stream.counts().retransmissions, 1u);
}

TEST(TcpStream, AKeepAliveIsNoRetransmission) {
    Sender sender;
    sender.send(0, "ab");
    sender.send(1, "b");
    EXPECT_EQ(sender.stream.counts().retransmissions, 0u);
}

TEST(TcpStream, AnAcknowledgedHoleIsAGap) {
    Sender sender;
    sender.send(0, "ab");
    sender.send(4, "ef");
    sender.acknowledge(2);
    EXPECT_EQ(sender.kept.text, "ab");
    sender.acknowledge(6);
    EXPECT_EQ(sender.kept.text, "ab_ef");
    EXPECT_EQ(sender.kept.packets.back(), 2u);
    EXPECT_EQ(sender.stream.counts().missing_bytes, 2u);
    sender.acknowledge(9);
    EXPECT_EQ(sender.kept.text, "ab_ef_");
    EXPECT_EQ(sender.stream.counts().gaps, 2u);
    sender.send(9, "j");
    EXPECT_EQ(sender.kept.text, "ab_ef_j");
}

TEST(TcpStream, TheAcknowledgementOfTheEndIsNoGap) {
    Sender sender;
    sender.send(0, "ab");
    sender.stream.end_at(0xFFFFFFFE + 2);
    sender.acknowledge(3);
    EXPECT_EQ(sender.stream.counts().gaps, 0u);
}

TEST(TcpStream, WaitingSegmentsAreBounded) {
    Sender sender;
    sender.send(0, "a");
    for (std::uint32_t i = 0; i < TcpStream::kMostPending; ++i) sender.send(2 + i, "x");
    EXPECT_EQ(sender.kept.text, "a");
    sender.send(2 + TcpStream::kMostPending, "y");
    EXPECT_EQ(sender.kept.text, "a_" + std::string(TcpStream::kMostPending, 'x') + "y");
}

TEST(TcpStream, ACutPacketLacksItsLastBytes) {
    Sender sender;
    sender.send(0, "abcd", 0, 2);
    sender.send(4, "ef");
    EXPECT_EQ(sender.kept.text, "ab#2ef");
    EXPECT_EQ(sender.stream.counts().missing_bytes, 2u);
}

TEST(TcpStream, ContinuesAtUnrelatedNumbers) {
    Sender sender(0x80000000);
    sender.send(0, "ab");
    sender.send(0xE0000000, "cd");
    EXPECT_EQ(sender.kept.text, "ab_cd");
    sender.acknowledge(0x40000000);
    sender.send(0xE0000002, "ef");
    EXPECT_EQ(sender.kept.text, "ab_cdef") << "an acknowledgement far away is ignored";
    sender.send(0x20000000, "gh");
    EXPECT_EQ(sender.kept.text, "ab_cdef_gh");
    EXPECT_EQ(sender.stream.counts().missing_bytes, 0u) << "how many is not known";
}

TEST(TcpStream, FlushPassesWhatWaits) {
    Sender sender;
    sender.send(3, "de");
    sender.stream.flush(sender.kept);
    EXPECT_EQ(sender.kept.text, "_de");
}

RC_GTEST_PROP(TcpStream, AnyCutsInAnyOrderGiveTheSameBytes, ()) {
    std::string text(60, ' ');
    std::iota(text.begin(), text.end(), 'A');
    const auto starts =
        *rc::gen::container<std::vector<std::uint32_t>>(20, rc::gen::inRange<std::uint32_t>(0, 60));
    const auto lengths =
        *rc::gen::container<std::vector<std::uint32_t>>(20, rc::gen::inRange<std::uint32_t>(1, 30));
    Sender sender(*rc::gen::arbitrary<std::uint32_t>());
    for (std::size_t i = 0; i < starts.size(); ++i)
        sender.send(starts[i], text.substr(starts[i], lengths[i]));
    for (std::uint32_t at = 0; at < 60; at += 10) sender.send(at, text.substr(at, 10));
    RC_ASSERT(sender.kept.text == text);
    RC_ASSERT(sender.stream.counts().gaps == 0u);
}

}  // namespace tcp_stream_test
}  // namespace takt::capture
