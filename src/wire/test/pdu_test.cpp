// The examples of the specification (MODBUS Application Protocol V1.1b3, section 6), and what must be
// refused.
#include "takt/wire/pdu.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"
#include "encode_response.hpp"

namespace takt::wire {
namespace pdu_test {

std::string zeros(std::size_t bytes) {
    std::string text;
    for (std::size_t i = 0; i < bytes; ++i) text += "00";
    return text;
}

Bits bits_of(std::string_view digits) {
    Bits bits;
    for (const char digit : digits) bits.push_back(digit == '1');
    return bits;
}

TEST(PduRequests, OfTheSpecificationBothWays) {
    struct Row {
        std::string_view hex;
        Request request;
    };
    const Row rows[] = {
        {"01 00 13 00 13", ReadRequest{Function::read_coils, {0x13}, 19}},
        {"02 00 C4 00 16", ReadRequest{Function::read_discrete_inputs, {0xC4}, 22}},
        {"03 00 6B 00 03", ReadRequest{Function::read_holding_registers, {0x6B}, 3}},
        {"04 00 08 00 01", ReadRequest{Function::read_input_registers, {8}, 1}},
        {"05 00 AC FF 00", WriteSingleCoilRequest{{0xAC}, true}},
        {"05 00 AC 00 00", WriteSingleCoilRequest{{0xAC}, false}},
        {"06 00 01 00 03", WriteSingleRegisterRequest{{1}, 3}},
        {"07", ReadExceptionStatusRequest{}},
        {"08 00 00 A5 37", DiagnosticsRequest{0, {0xA5, 0x37}}},
        {"08 00 0A 00 00", DiagnosticsRequest{10, {0, 0}}},
        {"08 00 14 00 00", DiagnosticsRequest{20, {0, 0}}},
        {"0B", GetCommEventCounterRequest{}},
        {"0C", GetCommEventLogRequest{}},
        {"0F 00 13 00 0A 02 CD 01", WriteMultipleCoilsRequest{{0x13}, bits_of("1011001110")}},
        {"10 00 01 00 02 04 00 0A 01 02", WriteMultipleRegistersRequest{{1}, {0x0A, 0x0102}}},
        {"11", ReportServerIdRequest{}},
        {"14 0E 06 00 04 00 01 00 02 06 00 03 00 09 00 02", ReadFileRecordRequest{{{4, 1, 2}, {3, 9, 2}}}},
        {"15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D",
         WriteFileRecordRequest{{{4, 7, 3}}, {0x06AF, 0x04BE, 0x100D}}},
        {"16 00 04 00 F2 00 25", MaskWriteRegisterRequest{{4}, 0xF2, 0x25}},
        {"17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF",
         ReadWriteMultipleRegistersRequest{{3}, 6, {14}, {0xFF, 0xFF, 0xFF}}},
        {"18 04 DE", ReadFifoQueueRequest{{0x04DE}}},
        {"2B 0E 01 00", ReadDeviceIdRequest{1, 0}},
        {"2B 0D 01 02 03", EncapsulatedRequest{13, {1, 2, 3}}},
    };
    for (const auto& [hex, request] : rows) {
        EXPECT_EQ(to_hex(encode(request)->span()), hex);
        EXPECT_EQ(decode_request(ExactBytes(from_hex(hex))), request) << hex;
        EXPECT_EQ(static_cast<int>(function_of(request)), from_hex(hex)[0]);
    }
}

TEST(PduResponses, OfTheSpecificationBothWays) {
    struct Row {
        std::string_view hex;
        Response response;
    };
    const Row rows[] = {
        {"01 03 CD 6B 05", ReadBitsResponse{Function::read_coils, bits_of("101100111101011010100000")}},
        {"02 03 AC DB 35",
         ReadBitsResponse{Function::read_discrete_inputs, bits_of("001101011101101110101100")}},
        {"03 06 02 2B 00 00 00 64",
         ReadRegistersResponse{Function::read_holding_registers, {0x022B, 0, 0x64}}},
        {"04 02 00 0A", ReadRegistersResponse{Function::read_input_registers, {0x0A}}},
        {"05 00 AC FF 00", WriteSingleCoilResponse{{0xAC}, true}},
        {"06 00 01 00 03", WriteSingleRegisterResponse{{1}, 3}},
        {"07 6D", ReadExceptionStatusResponse{0x6D}},
        {"08 00 00 A5 37", DiagnosticsResponse{0, {0xA5, 0x37}}},
        {"08 00 04", DiagnosticsResponse{4, {}}},
        {"0B FF FF 01 08", GetCommEventCounterResponse{0xFFFF, 0x0108}},
        {"0C 08 00 00 01 08 01 21 20 00", GetCommEventLogResponse{0, 0x0108, 0x0121, {0x20, 0}}},
        {"0F 00 13 00 0A", WriteMultipleResponse{Function::write_multiple_coils, {0x13}, 10}},
        {"10 00 01 00 02", WriteMultipleResponse{Function::write_multiple_registers, {1}, 2}},
        {"11 03 01 02 FF", ReportServerIdResponse{{1, 2, 0xFF}}},
        {"14 0C 05 06 0D FE 00 20 05 06 33 CD 00 40",
         ReadFileRecordResponse{{2, 2}, {0x0DFE, 0x20, 0x33CD, 0x40}}},
        {"15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D",
         WriteFileRecordResponse{{{4, 7, 3}}, {0x06AF, 0x04BE, 0x100D}}},
        {"16 00 04 00 F2 00 25", MaskWriteRegisterResponse{{4}, 0xF2, 0x25}},
        {"17 04 00 FE 0A CD", ReadRegistersResponse{Function::read_write_multiple_registers, {0xFE, 0x0ACD}}},
        {"18 00 06 00 02 01 B8 12 84", ReadFifoQueueResponse{{0x01B8, 0x1284}}},
        {"2B 0E 01 01 FF 02 02 00 02 41 42 01 01 43",
         ReadDeviceIdResponse{1, 1, true, 2, {{0, 2}, {1, 1}}, {'A', 'B', 'C'}}},
        {"2B 0D 07", EncapsulatedResponse{13, {7}}},
        {"81 01", ExceptionResponse{Function::read_coils, ExceptionCode::illegal_function}},
        {"E3 0B",
         ExceptionResponse{static_cast<Function>(0x63), ExceptionCode::gateway_target_failed_to_respond}},
    };
    for (const auto& [hex, response] : rows) {
        EXPECT_EQ(to_hex(encode(response)->span()), hex);
        EXPECT_EQ(decode_response(ExactBytes(from_hex(hex))), response) << hex;
        EXPECT_EQ(static_cast<int>(function_of(response)), from_hex(hex)[0] & 0x7F);
    }
}

// Hostile-inputs 6, 7, 16, 17, 19, 20, 22, 24.
TEST(PduRequests, RefusesWhatIsNotExactlyARequest) {
    struct Row {
        std::string hex;
        Error error;
    };
    const Row rows[] = {
        {"", {Code::too_short, {}, {0, 1}}},
        {"00", {Code::unsupported, {}, {0}}},
        {"09", {Code::unsupported, {}, {9}}},
        {"83 00 00 00 01", {Code::unsupported, {}, {0x83}}},
        {"03 00 00 00", {Code::too_short, {}, {4, 5}}},
        {"03 00 00 00 01 03 00 00 00 01", {Code::too_long, {}, {10, 5}}},
        {"01 00 00 00 00", {Code::out_of_range, {}, {0, 1, 2000}}},
        {"01 00 00 07 D1", {Code::out_of_range, {}, {2001, 1, 2000}}},
        {"02 00 00 07 D1", {Code::out_of_range, {}, {2001, 1, 2000}}},
        {"03 00 00 00 00", {Code::out_of_range, {}, {0, 1, 125}}},
        {"03 00 00 00 7E", {Code::out_of_range, {}, {126, 1, 125}}},
        {"04 00 00 FF FF", {Code::out_of_range, {}, {65535, 1, 125}}},
        {"05 00 00 00 01", {Code::malformed, {}, {1}}},
        {"05 00 00 FF 01", {Code::malformed, {}, {0xFF01}}},
        {"05 00 00 FF", {Code::too_short, {}, {4, 5}}},
        {"06 00 00 00", {Code::too_short, {}, {4, 5}}},
        {"06 00 00 00 00 00", {Code::too_long, {}, {6, 5}}},
        {"07 00", {Code::too_long, {}, {2, 1}}},
        {"08 00", {Code::too_short, {}, {2, 3}}},
        {"08 00 00 01", {Code::malformed, {}, {1, 0}}},
        {"08 00 01", {Code::too_short, {}, {3, 5}}},
        {"08 00 0A 00 00 00 00", {Code::too_long, {}, {7, 5}}},
        {"08 00 13 00 00", {Code::unsupported, {}, {8, 19}}},
        {"08 00 15 00 00", {Code::unsupported, {}, {8, 21}}},
        {"0B 00", {Code::too_long, {}, {2, 1}}},
        {"0C 00", {Code::too_long, {}, {2, 1}}},
        {"0F 00 00 00 00 00", {Code::out_of_range, {}, {0, 1, 1968}}},
        {"0F 00 00 07 B1 F7" + zeros(247), {Code::out_of_range, {}, {1969, 1, 1968}}},
        {"0F 00 00 00 09 01 FF", {Code::malformed, {}, {1, 2}}},
        {"0F 00 00 00 08 02 FF 00", {Code::malformed, {}, {2, 1}}},
        {"0F 00 00 00 09 02 FF", {Code::too_short, {}, {7, 8}}},
        {"0F 00 00 00 09 02 FF 01 00", {Code::too_long, {}, {9, 8}}},
        {"10 00 00 00 00 00", {Code::out_of_range, {}, {0, 1, 123}}},
        {"10 00 00 00 7C F8" + zeros(247), {Code::out_of_range, {}, {124, 1, 123}}},
        {"10 00 00 00 02 02 00 00", {Code::malformed, {}, {2, 4}}},
        {"10 00 00 00 01 02 00", {Code::too_short, {}, {7, 8}}},
        {"10 00 00 00 01 02 00 00 00", {Code::too_long, {}, {9, 8}}},
        {"10 00 00 00 01", {Code::too_short, {}, {5, 6}}},
        {"11 00", {Code::too_long, {}, {2, 1}}},
        {"14 00", {Code::out_of_range, {}, {0, 7, 245}}},
        {"14 07 05 00 04 00 01 00 02", {Code::malformed, {}, {5, 6}}},
        {"14 07 06 00 04 00 01 FF FE", {Code::out_of_range, {}, {0xFFFE, 1, 124}}},
        {"14 07 06 00 04 00 01 00 00", {Code::out_of_range, {}, {0, 1, 124}}},
        {"14 0E 06 00 04 00 01 00 7B 06 00 04 00 01 00 01", {Code::out_of_range, {}, {254, 2, 253}}},
        {"14 08 06 00 04 00 01 00 02 00", {Code::malformed, {}, {1, 0}}},
        {"14 07 06 00 04 00 01 00", {Code::too_short, {}, {8, 9}}},
        {"14 07 06 00 04 00 01 00 02 00", {Code::too_long, {}, {10, 9}}},
        {"15 09 05 00 04 00 07 00 01 06 AF", {Code::malformed, {}, {5, 6}}},
        {"15 09 06 00 04 00 07 00 02 06 AF", {Code::malformed, {}, {2, 4}}},
        {"15 0B 06 00 04 00 07 00 01 06 AF 00 00", {Code::too_short, {}, {13, 18}}},
        {"15 09 06 00 04 00 07 FF FE 06 AF", {Code::out_of_range, {}, {0xFFFE, 1, 124}}},
        {"16 00 04 00 F2 00", {Code::too_short, {}, {6, 7}}},
        {"17 00 00 00 7E 00 00 00 01 02 00 00", {Code::out_of_range, {}, {126, 1, 125}}},
        {"17 00 00 00 01 00 00 00 7A F4" + zeros(243), {Code::out_of_range, {}, {122, 1, 121}}},
        {"17 00 00 00 00 00 00 00 01 02 00 00", {Code::out_of_range, {}, {0, 1, 125}}},
        {"17 00 00 00 01 00 00 00 01 04 00 00 00 00", {Code::malformed, {}, {4, 2}}},
        {"17 00 00 00 01 00 00 00 01 02 00", {Code::too_short, {}, {11, 12}}},
        {"18 00", {Code::too_short, {}, {2, 3}}},
        {"18 00 00 00", {Code::too_long, {}, {4, 3}}},
        {"2B", {Code::too_short, {}, {1, 2}}},
        {"2B 0E 05 00", {Code::out_of_range, {}, {5, 1, 4}}},
        {"2B 0E 00 00", {Code::out_of_range, {}, {0, 1, 4}}},
        {"2B 0E 01", {Code::too_short, {}, {3, 4}}},
        {"2B 0E 01 00 00", {Code::too_long, {}, {5, 4}}},
        {"2B 0D" + zeros(252), {Code::too_long, {}, {254, 253}}},
    };
    for (const auto& [hex, error] : rows) {
        const auto request = decode_request(ExactBytes(from_hex(hex)));
        ASSERT_FALSE(request.has_value()) << hex;
        EXPECT_EQ(request.error(), error) << hex << ": " << name(request.error().code) << ' '
                                          << request.error().numbers[0] << ' ' << request.error().numbers[1];
    }
}

// Addresses are the slave's affair (hostile-inputs, 18).
TEST(PduRequests, DoNotJudgeAddresses) {
    EXPECT_TRUE(decode_request(from_hex("03 FF FF 00 7D")).has_value());
    EXPECT_TRUE(decode_request(from_hex("14 07 06 00 00 FF FF 00 01")).has_value());
}

TEST(PduRequests, AreNotEncodedBeyondTheirLimits) {
    Registers registers;
    registers.resize(124);
    const Request requests[] = {
        ReadRequest{Function::read_coils, {0}, 0},
        ReadRequest{Function::read_coils, {0}, 2001},
        ReadRequest{Function::read_input_registers, {0}, 126},
        ReadRequest{Function::write_single_coil, {0}, 1},
        WriteMultipleCoilsRequest{{0}, Bits()},
        WriteMultipleCoilsRequest{{0}, Bits(1969)},
        WriteMultipleRegistersRequest{{0}, {}},
        WriteMultipleRegistersRequest{{0}, registers},
        ReadWriteMultipleRegistersRequest{{0}, 126, {0}, {1}},
        ReadWriteMultipleRegistersRequest{{0}, 1, {0}, registers},
        ReadWriteMultipleRegistersRequest{{0}, 1, {0}, {}},
        DiagnosticsRequest{19, {0, 0}},
        DiagnosticsRequest{1, {}},
        DiagnosticsRequest{0, {0}},
        ReadFileRecordRequest{},
        ReadFileRecordRequest{{{1, 0, 0}}},
        ReadFileRecordRequest{{{1, 0, 125}}},
        ReadFileRecordRequest{{{1, 0, 100}, {1, 0, 24}}},
        WriteFileRecordRequest{{{1, 0, 2}}, {1}},
        WriteFileRecordRequest{{{1, 0, 123}}, registers},
        ReadDeviceIdRequest{5, 0},
        EncapsulatedRequest{14, {}},
    };
    for (const auto& request : requests)
        EXPECT_FALSE(encode(request).has_value())
            << static_cast<int>(function_of(request)) << " index " << &request - requests;
}

TEST(PduResponses, RefusesWhatIsNoResponse) {
    struct Row {
        std::string hex;
        Code code;
    };
    const Row rows[] = {
        {"", Code::too_short},
        {"83", Code::too_short},
        {"83 02 00", Code::too_long},
        {"63 00", Code::unsupported},
        {"01 00", Code::out_of_range},
        {"01 FB" + zeros(251), Code::out_of_range},
        {"01 02 00", Code::too_short},
        {"01 01 00 00", Code::too_long},
        {"03 00", Code::out_of_range},
        {"03 03 00 00 00", Code::malformed},
        {"03 FC" + zeros(251), Code::out_of_range},
        {"05 00 00 00 01", Code::malformed},
        {"07", Code::too_short},
        {"0B 00 00 00", Code::too_short},
        {"0C 05 00 00 00 00 00", Code::out_of_range},
        {"0C 47" + zeros(71), Code::out_of_range},
        {"0C 07 00 00 00 00 00 00", Code::too_short},
        {"10 00 00 00 01 00", Code::too_long},
        {"11 05 00", Code::too_short},
        {"11 FC" + zeros(251), Code::out_of_range},
        {"14 03 01 06 00", Code::out_of_range},
        {"14 04 03 05 00 00", Code::malformed},
        {"14 04 05 06 00 00", Code::malformed},
        {"14 04 00 06 00 00", Code::malformed},
        {"14 05 02 06 00 00 00", Code::malformed},
        {"10 00 03 00 00", Code::out_of_range},
        {"10 00 03 20 02", Code::out_of_range},
        {"0F 00 03 07 D1", Code::out_of_range},
        {"18 00 40 00 20" + zeros(64), Code::out_of_range},
        {"18 00 04 00 02 00 00 00 00", Code::malformed},
        {"18 00 06 00 02 00 00", Code::too_short},
        {"2B 0E 05 01 00 00 00", Code::out_of_range},
        {"2B 0E 01 01 01 00 00", Code::malformed},
        {"2B 0E 01 01 00 00 01", Code::too_short},
        {"2B 0E 01 01 00 00 01 00 05 41", Code::too_short},
        {"2B 0E 01 01 00 00 7C" + zeros(246), Code::out_of_range},
        {"2B 0E 01 01 00 00 00 00", Code::too_long},
    };
    for (const auto& [hex, code] : rows) {
        const auto response = decode_response(ExactBytes(from_hex(hex)));
        ASSERT_FALSE(response.has_value()) << hex;
        EXPECT_EQ(name(response.error().code), name(code)) << hex;
    }
    // 36 sub-responses of one register: more than a request can ask for
    std::string many = "14 90";
    for (int i = 0; i < 36; ++i) many += "03 06 00 00";
    EXPECT_EQ(decode_response(from_hex(many)).error().code, Code::malformed);
}

TEST(Bits, KeepNothingBeyondTheirSize) {
    const Bits bits = Bits::from_bytes(from_hex("FF FF"), 9);
    EXPECT_EQ(to_hex(bits.bytes()), "FF 01");
    EXPECT_EQ(bits, bits_of("111111111"));
    EXPECT_FALSE(bits == bits_of("11111111"));
    Bits changed = bits;
    changed.set(8, false);
    EXPECT_FALSE(changed[8]);
    EXPECT_EQ(to_hex(changed.bytes()), "FF 00");
}

}  // namespace pdu_test
}  // namespace takt::wire
