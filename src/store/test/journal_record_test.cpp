#include "takt/store/journal_record.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace takt::store {
namespace journal_record_test {

using Image = std::vector<std::uint8_t>;

const RecordHeader kHeader{RecordType::samples, 3, 17, 40, 1'700'000'000'123'456'789, -5, 2};

Image encoded(const RecordHeader& header, const Image& payload) {
    Image bytes;
    encode_record(header, payload, bytes);
    return bytes;
}

TEST(JournalRecord, HasTheDocumentedBytes) {
    const Image bytes = encoded({RecordType::samples, 2, 3, 4, 5, 6, 7}, {0xAA, 0xBB});
    const Image expected{
        'T',  'K', 'J', '1', 66, 0, 0, 0, 1, 0, 0, 0,              // magic, length, type, reserved
        2,    0,   0,   0,   0,  0, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0,  // samples, sequence
        4,    0,   0,   0,   0,  0, 0, 0, 5, 0, 0, 0, 0, 0, 0, 0,  // samples before, wall time
        6,    0,   0,   0,   0,  0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0,  // monotonic time, epoch
        0xAA, 0xBB};
    ASSERT_EQ(bytes.size(), expected.size() + 4);
    EXPECT_EQ(Image(bytes.begin(), bytes.end() - 4), expected);
}

TEST(JournalRecord, IsDecodedFromTheBeginningOfBytes) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{255}, kMaxPayloadBytes}) {
        const Image payload(size, 0x5A);
        Image bytes = encoded(kHeader, payload);
        const std::size_t length = bytes.size();
        bytes.insert(bytes.end(), 9, 0xFF);
        const DecodedRecord record = decode_record(bytes);
        ASSERT_EQ(record.state, DecodeState::good) << size;
        EXPECT_EQ(record.header, kHeader);
        EXPECT_EQ(record.bytes, length);
        EXPECT_EQ(Image(record.payload.begin(), record.payload.end()), payload);
    }
}

TEST(JournalRecord, DistinguishesTornFromDamaged) {
    const Image good = encoded(kHeader, {1, 2, 3});
    const auto changed = [&good](std::size_t at, std::uint8_t value) {
        Image bytes = good;
        bytes[at] = value;
        return bytes;
    };
    struct Case {
        const char* what;
        Image bytes;
        DecodeState state;
    };
    const Case cases[] = {
        {"nothing", {}, DecodeState::torn},
        {"part of the magic number", {'T', 'K'}, DecodeState::torn},
        {"part of the header", Image(good.begin(), good.begin() + 30), DecodeState::torn},
        {"one byte short", Image(good.begin(), good.end() - 1), DecodeState::torn},
        {"zeros", Image(100, 0), DecodeState::damaged},
        {"another magic number", changed(0, 'X'), DecodeState::damaged},
        {"a length below the least", changed(4, 10), DecodeState::damaged},
        {"a length above the greatest", changed(6, 200), DecodeState::damaged},
        {"a length beyond the bytes", changed(5, 1), DecodeState::torn},
        {"another payload", changed(kRecordHeaderBytes, 9), DecodeState::damaged},
        {"another checksum", changed(good.size() - 1, static_cast<std::uint8_t>(good.back() ^ 1)),
         DecodeState::damaged},
        {"an unknown type", encoded({static_cast<RecordType>(77), 0, 1, 0, 0, 0, 1}, {}),
         DecodeState::damaged},
    };
    for (const Case& c : cases) EXPECT_EQ(decode_record(c.bytes).state, c.state) << c.what;
}

TEST(JournalRecord, KeepsAGap) {
    const Gap gap{GapCause::quota, 1ULL << 40, 7, 9, -1, 1'700'000'000'000'000'000};
    Image bytes;
    encode_gap(gap, bytes);
    EXPECT_EQ(bytes.size(), kGapPayloadBytes);
    EXPECT_EQ(decode_gap(bytes), gap);
    for (const std::uint8_t cause : {std::uint8_t{0}, std::uint8_t{9}, std::uint8_t{255}}) {
        bytes[0] = cause;
        EXPECT_EQ(decode_gap(bytes).error().code, Code::malformed) << cause;
    }
    EXPECT_EQ(decode_gap(Bytes(bytes).first(kGapPayloadBytes - 1)).error().code, Code::malformed);
}

RC_GTEST_PROP(JournalRecord, IsNeverGoodAfterACut, ()) {
    const Image bytes = encoded(kHeader, *rc::gen::arbitrary<Image>());
    const auto left = *rc::gen::inRange<std::size_t>(0, bytes.size());
    RC_ASSERT(decode_record(Bytes(bytes).first(left)).state == DecodeState::torn);
}

RC_GTEST_PROP(JournalRecord, IsNeverGoodWithAChangedByte, ()) {
    Image bytes = encoded(kHeader, *rc::gen::arbitrary<Image>());
    const auto at = *rc::gen::inRange<std::size_t>(0, bytes.size());
    bytes[at] ^= *rc::gen::inRange<std::uint8_t>(1, 255);
    RC_ASSERT(decode_record(bytes).state != DecodeState::good);
}

RC_GTEST_PROP(JournalRecord, IsNeverFoundInRandomBytes, (const Image& bytes)) {
    RC_ASSERT(decode_record(bytes).state != DecodeState::good);
}

}  // namespace journal_record_test
}  // namespace takt::store
