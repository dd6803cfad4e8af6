#include "network/mbap_stream.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace mbap_stream_test {

using namespace test;

struct Kept final : AduSink {
    std::vector<std::pair<int, std::uint64_t>> messages;  // transaction, packet
    void on_adu(const Adu& adu) override { messages.emplace_back(adu.transaction, adu.packet.number); }
};

class Reader {
public:
    explicit Reader(bool certain = true) : stream(certain) {}
    void push(const Octets& bytes) { stream.push({.number = ++packet_}, bytes, kept); }

    MbapStream stream;
    Kept kept;

private:
    std::uint64_t packet_ = 0;
};

using Messages = std::vector<std::pair<int, std::uint64_t>>;

constexpr const char* kRead = "03 0000 0002";
constexpr const char* kAnswer = "03 04 0000 0001";

TEST(MbapStream, SeveralMessagesInASegment) {
    Reader reader;
    reader.stream.begin_aligned();
    reader.push(joined({adu(1, 1, kRead), adu(2, 1, kRead), adu(3, 1, kRead)}));
    EXPECT_EQ(reader.kept.messages, (Messages{{1, 1}, {2, 1}, {3, 1}}));
}

TEST(MbapStream, AMessageInManySegmentsHasThePacketOfItsLastByte) {
    Reader reader;
    reader.stream.begin_aligned();
    const auto bytes = joined({adu(1, 1, kRead), adu(2, 1, kRead)});
    for (const auto byte : bytes) reader.push({byte});
    EXPECT_EQ(reader.kept.messages, (Messages{{1, 12}, {2, 24}}));
}

TEST(MbapStream, FindsTheFirstMessageOfACaptureInTheMiddle) {
    Reader reader;
    reader.push(joined({hex("0001 00"), adu(7, 1, kAnswer)}));
    reader.push(adu(8, 1, kAnswer));
    EXPECT_EQ(reader.kept.messages, (Messages{{7, 1}, {8, 2}}));
    EXPECT_EQ(reader.stream.skipped_bytes(), 3u);
    EXPECT_EQ(reader.stream.resynchronisations(), 0u);
}

TEST(MbapStream, AMessageOfAVendorBeginsACertainStreamInTheMiddle) {
    for (const bool certain : {true, false}) {
        Reader reader(certain);
        reader.push(adu(7, 1, "5A 00 02"));
        reader.push(adu(8, 1, "5A 00 02"));
        EXPECT_EQ(reader.kept.messages, certain ? (Messages{{7, 1}, {8, 2}}) : Messages{});
    }
}

TEST(MbapStream, ResynchronisesAfterAGap) {
    Reader reader;
    reader.stream.begin_aligned();
    reader.push(hex("0001 0000 0007 01 03 04"));
    reader.stream.on_gap();
    reader.push(hex("00 01"));        // the end of a message
    reader.push(adu(2, 1, kAnswer));  // begins with a segment
    reader.stream.on_gap();
    reader.push(joined({hex("05 06"), adu(3, 1, kAnswer)}));  // does not
    EXPECT_EQ(reader.kept.messages, (Messages{{2, 3}, {3, 4}}));
    EXPECT_EQ(reader.stream.resynchronisations(), 2u);
    EXPECT_EQ(reader.stream.skipped_bytes(), 13u);
}

TEST(MbapStream, AHeaderThatIsNoneIsSkipped) {
    Reader reader;
    reader.stream.begin_aligned();
    reader.push(joined({adu(1, 1, kRead), hex("ffff ffff ffff 01 03"), adu(2, 1, kRead)}));
    reader.push(adu(3, 1, kRead));
    EXPECT_EQ(reader.kept.messages, (Messages{{1, 1}, {2, 1}, {3, 2}}));
    EXPECT_EQ(reader.stream.skipped_bytes(), 8u);
}

TEST(MbapStream, AMessageWhoseTimeIsNotKnownIsDropped) {
    Reader reader;
    // Looks like the begin of a message of 200 bytes, which hides the message behind it for a while.
    reader.push(joined({hex("00 00 00 00 00 c8 01"), adu(2, 1, kAnswer)}));
    EXPECT_TRUE(reader.kept.messages.empty());
    for (std::uint16_t i = 3; i < 20; ++i) reader.push(joined({hex("ee"), adu(i, 1, kAnswer)}));
    ASSERT_FALSE(reader.kept.messages.empty());
    for (const auto& [transaction, packet] : reader.kept.messages)
        EXPECT_EQ(transaction, static_cast<int>(packet) + 1);
}

TEST(MbapStream, AnotherProtocolIsIgnored) {
    Reader reader(false);
    for (int i = 0; i < 100; ++i) reader.push(Octets(100, 0x41));
    EXPECT_TRUE(reader.stream.is_foreign());
    reader.push(adu(1, 1, kRead));
    EXPECT_TRUE(reader.kept.messages.empty());
    Reader certain(true);
    for (int i = 0; i < 100; ++i) certain.push(Octets(100, 0x41));
    certain.push(adu(1, 1, kRead));
    EXPECT_EQ(certain.kept.messages.size(), 1u);
}

RC_GTEST_PROP(MbapStream, CutsDoNotMatter, ()) {
    const auto counts = *rc::gen::container<std::vector<int>>(rc::gen::inRange(1, 124));
    const auto cuts = *rc::gen::nonEmpty(
        rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(1, 300)));
    Octets bytes;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        auto pdu = joined({{0x03, static_cast<std::uint8_t>(2 * counts[i])},
                           Octets(static_cast<std::size_t>(2 * counts[i]))});
        bytes = joined({bytes, be(i, 2), hex("0000"), be(pdu.size() + 1, 2), {1}, pdu});
    }
    Reader reader;
    reader.stream.begin_aligned();
    for (std::size_t at = 0, i = 0; at < bytes.size(); ++i) {
        const auto size = std::min(cuts[i % cuts.size()], bytes.size() - at);
        const auto piece = Bytes(bytes).subspan(at, size);
        reader.push(Octets(piece.begin(), piece.end()));
        at += size;
    }
    RC_ASSERT(reader.kept.messages.size() == counts.size());
    RC_ASSERT(reader.stream.skipped_bytes() == 0u);
}

RC_GTEST_PROP(MbapStream, AnyBytesAreSafe, (const std::vector<std::vector<std::uint8_t>>& chunks)) {
    Reader reader(*rc::gen::arbitrary<bool>());
    if (*rc::gen::arbitrary<bool>()) reader.stream.begin_aligned();
    std::size_t total = 0;
    for (const auto& chunk : chunks) {
        reader.push(chunk);
        total += chunk.size();
    }
    RC_ASSERT(reader.stream.skipped_bytes() <= total);
}

}  // namespace mbap_stream_test
}  // namespace takt::capture
