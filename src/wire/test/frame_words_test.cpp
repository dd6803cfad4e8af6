#include "takt/wire/frame_words.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "bytes.hpp"

namespace takt::wire {
namespace words_test {

struct Row {
    std::string_view pdu;
    std::string_view words;
};

TEST(Words, RequestsOfEveryFunction) {
    constexpr Row kRows[] = {
        {"01 0013 0025", "unit 16 read coils 19..55"},
        {"02 00C4 0001", "unit 16 read discrete inputs 196"},
        {"03 01F4 0002", "unit 16 read holding registers 500..501"},
        {"04 FFFF 0002", "unit 16 read input registers 65535..65536"},
        {"05 00AC FF00", "unit 16 write single coil 172 = on"},
        {"05 00AC 0000", "unit 16 write single coil 172 = off"},
        {"06 0001 0003", "unit 16 write single register 1 = 3"},
        {"07", "unit 16 read exception status"},
        {"08 0000 A537", "unit 16 diagnostics return query data (0) A5 37"},
        {"08 000A 0000", "unit 16 diagnostics clear counters (10) 00 00"},
        {"0B", "unit 16 get comm event counter"},
        {"0C", "unit 16 get comm event log"},
        {"0F 0013 000A 02 CD01", "unit 16 write multiple coils 19..28 = 1 0 1 1 0 0 1 1 1 0"},
        {"10 0001 0002 04 000A 0102", "unit 16 write multiple registers 1..2 = 10 258"},
        {"11", "unit 16 report server id"},
        {"14 0E 06 0004 0001 0002 06 0003 0009 0001",
         "unit 16 read file record: file 4 record 1..2, file 3 record 9"},
        {"15 0D 06 0004 0007 0003 06AF 04BE 100D",
         "unit 16 write file record: file 4 record 7..9 = 1711 1214 4109"},
        {"16 0004 00F2 0025", "unit 16 mask write register 4: AND 0x00F2, OR 0x0025"},
        {"17 0003 0006 000E 0003 06 00FF 00FF 00FF",
         "unit 16 read/write multiple registers read 3..8, write 14..16 = 255 255 255"},
        {"18 04DE", "unit 16 read fifo queue 1246"},
        {"2B 0E 01 00",
         "unit 16 encapsulated interface transport read device identification basic from object 0"},
        {"2B 0D 01 02", "unit 16 encapsulated interface transport type 13 01 02"},
        {"63 01", "unit 16 function 0x63 (unknown) 63 01"},
        {"03 0000 007E", "unit 16 read holding registers (126 is outside 1..125) 03 00 00 00 7E"},
        {"03 0000", "unit 16 read holding registers (too short, 3 of 5 bytes) 03 00 00"},
        {"03 0000 0001 00",
         "unit 16 read holding registers (too long, 6 bytes instead of 5) 03 00 00 00 01 00"},
        {"05 0000 0001", "unit 16 write single coil (malformed) 05 00 00 00 01"},
        {"", "unit 16 (too short, 0 of 1 bytes)"},
    };
    for (const auto& [pdu, words] : kRows) EXPECT_EQ(describe_request(UnitId{16}, from_hex(pdu)), words);
}

TEST(Words, ResponsesOfEveryFunctionAlone) {
    constexpr Row kRows[] = {
        {"01 01 05", "unit 16 read coils → 8 values: 1 0 1 0 0 0 0 0"},
        {"03 04 0000 3F80", "unit 16 read holding registers → 2 values: 0 16256"},
        {"04 02 0001", "unit 16 read input registers → 1 value: 1"},
        {"05 00AC FF00", "unit 16 write single coil → 172 = on"},
        {"06 0001 0003", "unit 16 write single register → 1 = 3"},
        {"07 6D", "unit 16 read exception status → status 0x6D"},
        {"08 000B 0003", "unit 16 diagnostics → return bus message count (11) 00 03"},
        {"0B FFFF 0108", "unit 16 get comm event counter → status 0xFFFF, 264 events"},
        {"0C 08 0000 0108 0121 20 00",
         "unit 16 get comm event log → status 0x0000, 264 events, 289 messages: 20 00"},
        {"0F 0013 000A", "unit 16 write multiple coils → 19..28 written"},
        {"10 0001 0001", "unit 16 write multiple registers → 1 written"},
        {"11 02 2A FF", "unit 16 report server id → 2A FF"},
        {"14 0A 05 06 0DFE 0020 03 06 33CD", "unit 16 read file record → 2 values: 3582 32; 1 value: 13261"},
        {"15 09 06 0004 0007 0001 06AF", "unit 16 write file record → written: file 4 record 7"},
        {"16 0004 00F2 0025", "unit 16 mask write register → 4: AND 0x00F2, OR 0x0025"},
        {"17 02 00FE", "unit 16 read/write multiple registers → 1 value: 254"},
        {"18 0006 0002 01B8 1284", "unit 16 read fifo queue → 2 values: 440 4740"},
        {"18 0002 0000", "unit 16 read fifo queue → no values"},
        {"2B 0E 01 01 FF 02 02 00 02 4142 01 02 430A",
         "unit 16 encapsulated interface transport → 0 \"AB\", 1 \"C.\", more from object 2"},
        {"2B 0E 01 01 00 00 00", "unit 16 encapsulated interface transport → no objects"},
        {"2B 0D 07", "unit 16 encapsulated interface transport → type 13 07"},
        {"84 02", "unit 16 read input registers → exception 2 illegal data address"},
        {"83 7F", "unit 16 read holding registers → exception 127"},
        {"03 03 000000", "unit 16 read holding registers → (malformed) 03 03 00 00 00"},
        {"", "unit 16 → (too short, 0 of 1 bytes)"},
    };
    for (const auto& [pdu, words] : kRows) EXPECT_EQ(describe_response(UnitId{16}, from_hex(pdu)), words);
}

TEST(Words, ResponsesToTheirRequest) {
    const Request read = ReadRequest{Function::read_holding_registers, {500}, 2};
    const auto words = [&](std::string_view pdu) {
        return describe_response(UnitId{16}, from_hex(pdu), &read);
    };
    EXPECT_EQ(words("03 04 0000 3F80"), "unit 16 read holding registers 500..501 → 2 values: 0 16256");
    EXPECT_EQ(
        words("83 0B"),
        "unit 16 read holding registers 500..501 → exception 11 gateway target device failed to respond");
    EXPECT_EQ(words("04 04 0000 3F80"),
              "unit 16 read holding registers 500..501 → (no answer to that request) 04 04 00 00 3F 80");
    const Request coils = ReadRequest{Function::read_coils, {0}, 3};
    EXPECT_EQ(describe_response(UnitId{1}, from_hex("01 01 05"), &coils),
              "unit 1 read coils 0..2 → 3 values: 1 0 1");
}

TEST(Words, OfManyValuesTheFirst) {
    const Request read = ReadRequest{Function::read_coils, {0}, 33};
    EXPECT_EQ(describe_response(UnitId{1}, from_hex("01 05 0000000001"), &read),
              "unit 1 read coils 0..32 → 33 values: 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 "
              "0 0 0 0 …");
}

TEST(Words, HexIsUpperCaseAndSeparated) {
    EXPECT_EQ(hex(from_hex("10 03 0a ff")), "10 03 0A FF");
    EXPECT_EQ(hex({}), "");
}

RC_GTEST_PROP(Words, AnyBytesHaveWords, (ByteVector pdu)) {
    if (!pdu.empty()) pdu[0] = *rc::gen::inRange<std::uint8_t>(0, 0x30);
    RC_ASSERT(describe_request(UnitId{1}, pdu).starts_with("unit 1"));
    RC_ASSERT(describe_response(UnitId{1}, pdu).starts_with("unit 1"));
}

// Over TCP several requests are in flight, and late responses come behind later requests.
TEST(FrameWords, AResponseHasTheAddressesOfItsRequest) {
    FrameWords words;
    const UnitId unit{2};
    const auto framed = [](std::uint8_t id, const Pdu& pdu) {
        std::vector<std::uint8_t> raw{0, id, 0, 0, 0, static_cast<std::uint8_t>(pdu.size() + 1), 2};
        raw.insert(raw.end(), pdu.begin(), pdu.end());
        return raw;
    };
    const Pdu first{3, 0, 0, 0, 1};
    const Pdu second{3, 0, 40, 0, 2};
    const Pdu one{3, 2, 0, 7};
    const Pdu two{3, 4, 0, 7, 0, 8};
    words.request(unit, first.span(), framed(1, first));
    words.request(unit, second.span(), framed(2, second));
    EXPECT_EQ(words.response(unit, one.span(), framed(1, one)),
              "unit 2 read holding registers 0 → 1 value: 7");
    EXPECT_EQ(words.response(unit, two.span(), framed(2, two)),
              "unit 2 read holding registers 40..41 → 2 values: 7 8");
    EXPECT_EQ(words.response(unit, one.span(), framed(3, one)), "unit 2 read holding registers → 1 value: 7");
    for (int id = 3; id < 1000; ++id)
        words.request(unit, first.span(), framed(static_cast<std::uint8_t>(id), first));
    // On a serial line it is the last one, if the response answers it.
    const std::vector<std::uint8_t> rtu(second.size() + 3);
    words.request(unit, second.span(), rtu);
    EXPECT_EQ(words.response(unit, two.span(), std::vector<std::uint8_t>(two.size() + 3)),
              "unit 2 read holding registers 40..41 → 2 values: 7 8");
    EXPECT_EQ(words.response(unit, one.span(), std::vector<std::uint8_t>(one.size() + 3)),
              "unit 2 read holding registers → 1 value: 7");
}

}  // namespace words_test
}  // namespace takt::wire
