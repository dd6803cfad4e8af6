// Answers against the request they are to answer (hostile-inputs 48..51).
#include <gtest/gtest.h>

#include "bytes.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::wire {
namespace response_test {

const Request kReadThree = ReadRequest{Function::read_holding_registers, {0x6B}, 3};
const Request kReadCoils = ReadRequest{Function::read_coils, {0x13}, 19};

TEST(DecodeResponse, RejectsResponsesToOtherRequests) {
    struct Row {
        Request request;
        std::string_view answer;
        Code code;
    };
    const Row rows[] = {
        {kReadThree, "", Code::too_short},
        {kReadThree, "04 06 02 2B 00 64 00 7F", Code::unexpected_reply},
        {kReadThree, "84 02", Code::unexpected_reply},
        {kReadThree, "03 04 02 2B 00 64", Code::malformed},
        {kReadThree, "03 08 02 2B 00 64 00 7F 00 00", Code::malformed},
        {kReadThree, "03 06 02 2B 00 64 00", Code::too_short},
        {kReadThree, "03 06 02 2B 00 64 00 7F 00", Code::too_long},
        {kReadThree, "83", Code::too_short},
        {kReadCoils, "01 02 CD 6B", Code::malformed},
        {kReadCoils, "01 04 CD 6B 05 00", Code::malformed},
        {WriteSingleCoilRequest{{1}, true}, "05 00 02 FF 00", Code::unexpected_reply},
        {WriteSingleCoilRequest{{1}, true}, "05 00 01 00 00", Code::unexpected_reply},
        {WriteSingleCoilRequest{{1}, true}, "05 00 01 FF FF", Code::malformed},
        {WriteSingleRegisterRequest{{1}, 7}, "06 00 01 00 08", Code::unexpected_reply},
        {WriteSingleRegisterRequest{{1}, 7}, "06 00 00 00 07", Code::unexpected_reply},
        {WriteMultipleCoilsRequest{{1}, Bits(9)}, "0F 00 01 00 08", Code::unexpected_reply},
        {WriteMultipleRegistersRequest{{1}, {1, 2}}, "10 00 02 00 02", Code::unexpected_reply},
        {WriteMultipleRegistersRequest{{1}, {1, 2}}, "10 00 01 00 00", Code::out_of_range},
        {MaskWriteRegisterRequest{{1}, 2, 3}, "16 00 01 00 02 00 04", Code::unexpected_reply},
        {ReadWriteMultipleRegistersRequest{{0}, 2, {0}, {1}}, "17 02 00 00", Code::malformed},
        {DiagnosticsRequest{0, {1, 2}}, "08 00 00 01 03", Code::unexpected_reply},
        {DiagnosticsRequest{0, {1, 2}}, "08 00 01 01 02", Code::unexpected_reply},
        {ReadFileRecordRequest{{{4, 1, 2}}}, "14 04 03 06 0D FE", Code::malformed},
        {ReadFileRecordRequest{{{4, 1, 1}}}, "14 08 03 06 0D FE 03 06 0D FE", Code::malformed},
        {WriteFileRecordRequest{{{4, 1, 1}}, {5}}, "15 09 06 00 04 00 01 00 01 00 06",
         Code::unexpected_reply},
        {ReadDeviceIdRequest{1, 0}, "2B 0E 02 01 00 00 00", Code::unexpected_reply},
        {ReadDeviceIdRequest{1, 0}, "2B 0D 02 01", Code::unexpected_reply},
        {EncapsulatedRequest{13, {}}, "2B 0C", Code::unexpected_reply},
    };
    for (const auto& [request, answer, code] : rows) {
        const auto response = decode_response(request, ExactBytes(from_hex(answer)));
        ASSERT_FALSE(response.has_value()) << answer;
        EXPECT_EQ(name(response.error().code), name(code)) << answer;
    }
}

TEST(DecodeResponse, ReportsAnyExceptionCode) {
    for (const int code : {0, 1, 2, 6, 11, 0x7F, 0xFF}) {
        const ByteVector pdu{0x83, static_cast<std::uint8_t>(code)};
        EXPECT_EQ(
            decode_response(kReadThree, pdu),
            Response(ExceptionResponse{Function::read_holding_registers, static_cast<ExceptionCode>(code)}));
    }
}

TEST(DecodeResponse, CutsBitsToTheQuantity) {
    const auto response = decode_response(kReadCoils, from_hex("01 03 CD 6B FD"));
    const Bits& values = std::get<ReadBitsResponse>(*response).values;
    EXPECT_EQ(values.size(), 19U);
    EXPECT_EQ(to_hex(values.bytes()), "CD 6B 05");
}

TEST(PreparedRequest, HasTheLengthOfItsLongestResponse) {
    struct Row {
        Request request;
        std::size_t length;
    };
    const Row rows[] = {
        {ReadRequest{Function::read_coils, {0}, 9}, 4},
        {ReadRequest{Function::read_discrete_inputs, {0}, 2000}, 252},
        {ReadRequest{Function::read_holding_registers, {0}, 125}, 252},
        {ReadRequest{Function::read_input_registers, {0}, 1}, 4},
        {WriteSingleCoilRequest{}, 5},
        {WriteSingleRegisterRequest{}, 5},
        {ReadExceptionStatusRequest{}, 2},
        {DiagnosticsRequest{0, {1, 2, 3, 4}}, 7},
        {GetCommEventCounterRequest{}, 5},
        {GetCommEventLogRequest{}, 72},
        {WriteMultipleCoilsRequest{{0}, Bits(1)}, 5},
        {WriteMultipleRegistersRequest{{0}, {1}}, 5},
        {ReportServerIdRequest{}, 253},
        {ReadFileRecordRequest{{{4, 1, 2}, {3, 9, 2}}}, 14},
        {WriteFileRecordRequest{{{4, 7, 3}}, {1, 2, 3}}, 15},
        {MaskWriteRegisterRequest{}, 7},
        {ReadWriteMultipleRegistersRequest{{0}, 6, {0}, {1}}, 14},
        {ReadFifoQueueRequest{}, 67},
        {ReadDeviceIdRequest{}, 253},
        {EncapsulatedRequest{}, 253},
    };
    for (const auto& [request, length] : rows)
        EXPECT_EQ(prepare(request)->shape().response_length, length)
            << static_cast<int>(function_of(request));
}

}  // namespace response_test
}  // namespace takt::wire
