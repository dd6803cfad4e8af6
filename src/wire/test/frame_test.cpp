#include "takt/wire/frame.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"
#include "takt/wire/framer.hpp"

namespace takt::wire {
namespace frame_test {

using enum Function;

constexpr FrameLimits kOwenWithoutCut{.frame_buffer = 256, .max_items = 0};
constexpr FrameLimits kOwen{.frame_buffer = 256, .max_items = 125};

// Specification, sections 5 and 8.
constexpr std::string_view kGoldenRtu[] = {
    "10 03 00 00 00 02 C7 4A",    "10 03 00 12 00 02 67 4F",    "10 03 01 F4 00 02 87 44",
    "10 03 01 FA 00 01 A6 86",    "10 04 01 FA 00 01 13 46",    "10 03 04 00 00 3F 80 EB 62",
    "10 03 04 00 00 40 00 CA F2", "10 03 04 00 00 40 40 CB 02", "10 03 04 00 00 40 80 CB 52",
    "10 03 04 00 00 40 A0 CA 8A", "10 03 02 00 00 44 47",       "01 04 04 00 02 00 03 1A 45",
    "01 04 00 00 00 02 71 CB",    "01 04 00 00 00 10 F1 C6",    "01 84 02 C2 C1",
};

TEST(Frame, GoldenRtuFramesAreWhatIsEncoded) {
    for (const auto text : kGoldenRtu) {
        const ByteVector frame = from_hex(text);
        const Bytes pdu = Bytes(frame).subspan(1, frame.size() - 3);
        EXPECT_EQ(to_hex(encode_frame(Framing::rtu, UnitId{frame[0]}, 0, pdu).span()), text);
    }
}

TEST(Frame, GoldenTcpFrames) {
    EXPECT_EQ(to_hex(encode_frame(Framing::tcp, UnitId{17}, 1, from_hex("03 006B 0003")).span()),
              "00 01 00 00 00 06 11 03 00 6B 00 03");
    EXPECT_EQ(to_hex(encode_frame(Framing::tcp, UnitId{17}, 1, from_hex("03 06 022B 0064 007F")).span()),
              "00 01 00 00 00 09 11 03 06 02 2B 00 64 00 7F");
}

TEST(Frame, AsciiIsHexWithItsCheck) {
    const auto frame = encode_frame(Framing::ascii, UnitId{0xF7}, 0, from_hex("03 13 89 00 0A"));
    EXPECT_EQ(std::string(frame.begin(), frame.end()), ":F7031389000A60\r\n");
}

TEST(Frame, ChecksumsOfKnownTexts) {
    const ByteVector check{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(crc16(check), 0x4B37);
    EXPECT_EQ(crc16({}), 0xFFFF);
    EXPECT_EQ(lrc(from_hex("11 03 00 6B 00 03")), 0x7E);
}

TEST(Frame, LengthsAreThoseOfTheEncodedFrames) {
    for (const std::size_t length : {1U, 5U, 253U}) {
        const ByteVector pdu(length, 0x5A);
        for (const Framing framing : {Framing::rtu, Framing::ascii, Framing::tcp})
            EXPECT_EQ(encode_frame(framing, UnitId{1}, 0, pdu).size(), frame_length(framing, length));
    }
    EXPECT_EQ(frame_length(Framing::rtu, kMaxPdu), kMaxRtuFrame);
    EXPECT_EQ(frame_length(Framing::ascii, kMaxPdu), kMaxAsciiFrame);
    EXPECT_EQ(frame_length(Framing::tcp, kMaxPdu), kMaxTcpFrame);
}

TEST(MaxItems, ComeOutAsInTheSpecification) {
    struct Row {
        Framing framing;
        Function function;
        FrameLimits limits;
        std::size_t items;
    };
    const Row rows[] = {
        {Framing::rtu, read_holding_registers, kOwen, 125},
        {Framing::rtu, read_input_registers, kOwen, 125},
        {Framing::rtu, write_multiple_registers, kOwen, 123},
        {Framing::rtu, read_coils, kOwen, 125},
        {Framing::rtu, read_discrete_inputs, kOwen, 125},
        {Framing::rtu, write_multiple_coils, kOwen, 125},
        {Framing::rtu, read_coils, kOwenWithoutCut, 2000},
        {Framing::rtu, read_discrete_inputs, kOwenWithoutCut, 2000},
        {Framing::rtu, write_multiple_coils, kOwenWithoutCut, 1968},
        {Framing::ascii, read_holding_registers, kOwen, 61},
        {Framing::ascii, read_input_registers, kOwen, 61},
        {Framing::ascii, write_multiple_registers, kOwen, 59},
        {Framing::ascii, read_coils, kOwen, 125},
        {Framing::ascii, write_multiple_coils, kOwen, 125},
        {Framing::ascii, read_coils, kOwenWithoutCut, 976},
        {Framing::ascii, read_discrete_inputs, kOwenWithoutCut, 976},
        {Framing::ascii, write_multiple_coils, kOwenWithoutCut, 944},
        // what a request carries is in its response too: a buffer too small for either carries nothing
        {Framing::rtu, read_holding_registers, {.frame_buffer = 7, .max_items = 0}, 0},
        {Framing::rtu, read_holding_registers, {.frame_buffer = 8, .max_items = 0}, 1},
        {Framing::rtu, write_multiple_registers, {.frame_buffer = 10, .max_items = 0}, 0},
        {Framing::rtu, write_multiple_registers, {.frame_buffer = 11, .max_items = 0}, 1},
        {Framing::rtu, read_coils, {.frame_buffer = 0, .max_items = 7}, 7},
        {Framing::rtu, read_coils, {.frame_buffer = 100000, .max_items = 100000}, 2000},
    };
    for (const auto& row : rows)
        EXPECT_EQ(max_items(row.framing, row.function, row.limits), row.items)
            << name(row.framing) << ' ' << name(row.function) << ' ' << row.limits.frame_buffer;
}

TEST(MaxItems, WithoutABufferAllFramingsCarryTheSpecifications) {
    for (const Framing framing : {Framing::rtu, Framing::ascii, Framing::tcp}) {
        EXPECT_EQ(max_items(framing, read_coils), 2000U);
        EXPECT_EQ(max_items(framing, read_discrete_inputs), 2000U);
        EXPECT_EQ(max_items(framing, read_holding_registers), 125U);
        EXPECT_EQ(max_items(framing, read_input_registers), 125U);
        EXPECT_EQ(max_items(framing, write_multiple_coils), 1968U);
        EXPECT_EQ(max_items(framing, write_multiple_registers), 123U);
        EXPECT_EQ(max_items(framing, read_write_multiple_registers), 125U);
        EXPECT_EQ(max_items(framing, write_single_coil), 1U);
        EXPECT_EQ(max_items(framing, write_single_register), 1U);
        EXPECT_EQ(max_items(framing, mask_write_register), 1U);
        EXPECT_EQ(max_items(framing, diagnostics), 0U);
    }
}

// 61 registers make an ASCII response of 255 characters (docs/specification.md, section 3).
TEST(MaxItems, TheGreatestResponseFillsTheBuffer) {
    EXPECT_EQ(frame_length(Framing::ascii, response_pdu_length(read_holding_registers, 61)), 255U);
    EXPECT_GT(frame_length(Framing::ascii, response_pdu_length(read_holding_registers, 62)), 256U);
    EXPECT_EQ(frame_length(Framing::rtu, request_pdu_length(write_multiple_registers, 123)), 255U);
    EXPECT_EQ(request_pdu_length(read_write_multiple_registers, 125, 121), 252U);
}

TEST(Names, OfFramingsAndFaults) {
    EXPECT_EQ(name(Framing::rtu), "rtu");
    EXPECT_EQ(name(Framing::ascii), "ascii");
    EXPECT_EQ(name(Framing::tcp), "tcp");
    EXPECT_EQ(name(FrameFault::bad_header), "bad_header");
    EXPECT_EQ(name(read_holding_registers), "read holding registers");
    EXPECT_EQ(name(static_cast<Function>(0x63)), "function");
    EXPECT_EQ(name(ExceptionCode::illegal_data_address), "illegal data address");
    EXPECT_EQ(name(static_cast<ExceptionCode>(0x7F)), "exception");
    EXPECT_EQ(name(Area::input_register), "input_register");
}

}  // namespace frame_test
}  // namespace takt::wire
