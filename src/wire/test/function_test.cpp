// The properties of each function, and the effect of whole requests.
#include "takt/wire/function.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "bytes.hpp"
#include "takt/wire/broadcast.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/prepared_request.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::wire {
namespace function_test {

TEST(Effect, OfRequests) {
    struct Row {
        std::string_view request;
        Effect effect;
    };
    const Row rows[] = {
        {"01 00 00 00 01", Effect::read},
        {"02 00 00 00 01", Effect::read},
        {"03 00 00 00 01", Effect::read},
        {"04 00 00 00 01", Effect::read},
        {"05 00 00 FF 00", Effect::write},
        {"06 00 00 00 01", Effect::write},
        {"07", Effect::read},
        {"08 00 00 12 34", Effect::diagnostic},
        {"08 00 0B 00 00", Effect::diagnostic},
        {"08 00 01 00 00", Effect::write},
        {"08 00 03 0A 00", Effect::write},
        {"08 00 04 00 00", Effect::write},
        {"08 00 0A 00 00", Effect::write},
        {"08 00 14 00 00", Effect::write},
        {"08 00 02 00 00", Effect::diagnostic},
        {"08 00 12 00 00", Effect::diagnostic},
        {"08 00 05 00 00", Effect::write},
        {"08 00 13 00 00", Effect::write},
        {"08 00 15 00 04", Effect::write},
        {"08 01 00 00 00", Effect::write},
        {"08 01 0B 00 00", Effect::write},
        {"08 00", Effect::diagnostic},
        {"0B", Effect::diagnostic},
        {"0C", Effect::diagnostic},
        {"0F 00 00 00 01 01 01", Effect::write},
        {"10 00 00 00 01 02 00 01", Effect::write},
        {"11", Effect::read},
        {"14 07 06 00 04 00 01 00 02", Effect::read},
        {"15 09 06 00 04 00 01 00 01 00 01", Effect::write},
        {"16 00 00 00 F2 00 25", Effect::write},
        {"17 00 00 00 01 00 00 00 01 02 00 01", Effect::write},
        {"18 00 00", Effect::read},
        {"2B 0E 01 00", Effect::read},
        {"2B 0D 01", Effect::write},
        {"2B", Effect::diagnostic},
        {"00", Effect::write},
        {"41 00", Effect::write},
        {"83 02", Effect::write},
    };
    for (const auto& [request, expected] : rows) {
        const auto bytes = from_hex(request);
        EXPECT_EQ(RequestView(bytes).effect(), expected) << request;
        EXPECT_EQ(PreparedRequest(bytes).only_reads(), expected == Effect::read) << request;
    }
}

/// The numbers of the specification, typed from its sections and not from the table.
struct Specified {
    unsigned code;
    std::string_view name;
    std::string_view request;   // a valid one, as short as possible
    std::string_view response;  // the shortest normal response to it
    std::size_t most_items;
    std::size_t most_written;
    bool bits;
    bool broadcast;
    Area area;
};

// MODBUS Application Protocol V1.1b3, sections 6.1 to 6.19 and 6.21; broadcast: MODBUS over Serial Line
// V1.02, section 2.1.
const Specified kSpecified[] = {
    {0x01, "read coils", "01 0013 0001", "01 01 05", 2000, 0, true, false, Area::coil},
    {0x02, "read discrete inputs", "02 00C4 0001", "02 01 AC", 2000, 0, true, false, Area::discrete_input},
    {0x03, "read holding registers", "03 006B 0001", "03 02 022B", 125, 0, false, false,
     Area::holding_register},
    {0x04, "read input registers", "04 0008 0001", "04 02 000A", 125, 0, false, false, Area::input_register},
    {0x05, "write single coil", "05 00AC FF00", "05 00AC FF00", 1, 1, true, true, Area::coil},
    {0x06, "write single register", "06 0001 0003", "06 0001 0003", 1, 1, false, true,
     Area::holding_register},
    {0x07, "read exception status", "07", "07 6D", 0, 0, false, false, Area::holding_register},
    {0x08, "diagnostics", "08 0000 A537", "08 0000 A537", 0, 0, false, false, Area::holding_register},
    {0x0B, "get comm event counter", "0B", "0B FFFF 0108", 0, 0, false, false, Area::holding_register},
    {0x0C, "get comm event log", "0C", "0C 08 0000 0108 0121 2000", 0, 0, false, false,
     Area::holding_register},
    {0x0F, "write multiple coils", "0F 0013 0001 01 01", "0F 0013 0001", 1968, 1968, true, true, Area::coil},
    {0x10, "write multiple registers", "10 0001 0001 02 000A", "10 0001 0001", 123, 123, false, true,
     Area::holding_register},
    {0x11, "report server id", "11", "11 02 05 FF", 0, 0, false, false, Area::holding_register},
    {0x14, "read file record", "14 07 06 0004 0001 0001", "14 04 03 06 0DFE", 0, 0, false, false,
     Area::holding_register},
    {0x15, "write file record", "15 09 06 0004 0007 0001 06AF", "15 09 06 0004 0007 0001 06AF", 0, 0, false,
     true, Area::holding_register},
    {0x16, "mask write register", "16 0004 00F2 0025", "16 0004 00F2 0025", 1, 1, false, true,
     Area::holding_register},
    {0x17, "read/write multiple registers", "17 0003 0001 000E 0001 02 00FF", "17 02 00FE", 125, 121, false,
     false, Area::holding_register},
    {0x18, "read fifo queue", "18 04DE", "18 0004 0001 01B8", 0, 0, false, false, Area::holding_register},
    {0x2B, "encapsulated interface transport", "2B 0E 01 00", "2B 0E 01 01 00 00 00", 0, 0, false, false,
     Area::holding_register},
};

const Specified* specified(unsigned code) {
    const auto* const found = std::ranges::find(kSpecified, code, &Specified::code);
    return found == std::end(kSpecified) ? nullptr : found;
}

TEST(FunctionProperties, AreThoseOfTheSpecification) {
    for (unsigned code = 0; code < 256; ++code) {
        const Function function{static_cast<std::uint8_t>(code)};
        const auto& row = properties(function);
        const auto* const expected = specified(code);
        EXPECT_EQ(is_known(function), expected != nullptr) << code;
        EXPECT_EQ(name(function), expected != nullptr ? expected->name : "function");
        EXPECT_EQ(row.most_items, expected != nullptr ? expected->most_items : 0U) << code;
        EXPECT_EQ(row.most_written, expected != nullptr ? expected->most_written : 0U) << code;
        EXPECT_EQ(counts_bits(function), expected != nullptr && expected->bits) << code;
        EXPECT_EQ(may_be_broadcast(function), expected != nullptr && expected->broadcast) << code;
        EXPECT_EQ(area_of(function), expected != nullptr ? expected->area : Area::holding_register) << code;
        EXPECT_EQ(row.returns_items(), expected != nullptr && expected->most_items > expected->most_written)
            << code;
        EXPECT_EQ(row.only_reads_items(), code >= 1 && code <= 4) << code;
        EXPECT_EQ(row.only_writes_items(),
                  code == 5 || code == 6 || code == 0x0F || code == 0x10 || code == 0x16)
            << code;
        EXPECT_EQ(row.writes_single(), code == 5 || code == 6) << code;
        if (row.echoes() || expected == nullptr) {
            EXPECT_EQ(row.effect, Effect::write) << "unknown functions count as writing";
        }
    }
}

// Every length of the table, against the shortest request and response of each function.
TEST(FunctionProperties, GiveTheLengthsOfTheSpecification) {
    for (const auto& row : kSpecified) {
        SCOPED_TRACE(row.name);
        const Function function{static_cast<std::uint8_t>(row.code)};
        const auto& own = properties(function);
        const auto request = from_hex(row.request);
        const auto response = from_hex(row.response);
        EXPECT_TRUE(RequestView(request).well_formed());
        const PreparedRequest prepared(request);
        EXPECT_TRUE(decode_response(prepared.shape(), request, response)) << row.response;
        EXPECT_LE(response.size(), prepared.shape().response_length);
        if (prepared.shape().fixed_length) {
            EXPECT_EQ(response.size(), prepared.shape().response_length);
        }
        if (own.counts_request()) {
            EXPECT_EQ(request[own.request_bytes - 1U], request.size() - own.request_bytes);
        } else if (function != Function::encapsulated_interface) {
            EXPECT_EQ(request.size(), own.request_bytes);
        }
        EXPECT_EQ(request_pdu_length(function, 1, 1), row.most_items > 0 ? request.size() : 0U);
        EXPECT_EQ(response_pdu_length(function, 1), row.most_items > 0 ? response.size() : 0U);
        EXPECT_LE(own.most_response_bytes, kMaxPdu);
    }
}

// The longest request and response of each function with items fit into a PDU, and their limit is exact.
TEST(FunctionProperties, LimitsFitIntoAPdu) {
    for (const auto& row : kFunctions) {
        if (row.most_items == 0) continue;
        SCOPED_TRACE(name(row.function));
        EXPECT_LE(request_pdu_length(row.function, row.most_items, row.most_written), kMaxPdu);
        EXPECT_LE(response_pdu_length(row.function, row.most_items), row.most_response_bytes);
        EXPECT_EQ(max_items(Framing::tcp, row.function), row.most_items);
    }
    EXPECT_EQ(properties(Function::get_comm_event_log).most_response_bytes,
              8 + decltype(GetCommEventLogResponse::events)::capacity());
    EXPECT_EQ(properties(Function::read_fifo_queue).most_response_bytes,
              5 + 2 * decltype(ReadFifoQueueResponse::values)::capacity());
}

TEST(FunctionProperties, AreasHaveTheirReadAndWriteFunctions) {
    EXPECT_EQ(read_function(Area::coil), Function::read_coils);
    EXPECT_EQ(read_function(Area::discrete_input), Function::read_discrete_inputs);
    EXPECT_EQ(read_function(Area::holding_register), Function::read_holding_registers);
    EXPECT_EQ(read_function(Area::input_register), Function::read_input_registers);
    for (const bool bits : {true, false})
        for (const bool single : {true, false}) {
            const auto& row = properties(write_function(bits, single));
            EXPECT_EQ(row.counts_bits(), bits);
            EXPECT_EQ(row.writes_single(), single);
            EXPECT_TRUE(row.only_writes_items());
        }
}

TEST(WriteRequest, HoldsTheItems) {
    Bits bits;
    bits.push_back(true);
    const Registers one{7};
    const Registers two{7, 8};
    EXPECT_EQ(write_request(Function::write_single_coil, DataAddress{3}, bits, {}),
              Request(WriteSingleCoilRequest{DataAddress{3}, true}));
    EXPECT_EQ(write_request(Function::write_multiple_coils, DataAddress{3}, bits, {}),
              Request(WriteMultipleCoilsRequest{DataAddress{3}, bits}));
    EXPECT_EQ(write_request(Function::write_single_register, DataAddress{3}, {}, one),
              Request(WriteSingleRegisterRequest{DataAddress{3}, 7}));
    EXPECT_EQ(write_request(Function::write_multiple_registers, DataAddress{3}, {}, two),
              Request(WriteMultipleRegistersRequest{DataAddress{3}, two}));
    EXPECT_FALSE(write_request(Function::write_single_register, DataAddress{3}, {}, two));
    EXPECT_FALSE(write_request(Function::write_multiple_registers, DataAddress{3}, {}, {}));
    EXPECT_FALSE(write_request(Function::mask_write_register, DataAddress{3}, {}, one));
    EXPECT_FALSE(write_request(Function::read_holding_registers, DataAddress{3}, {}, one));
}

static_assert(properties(Function::read_coils).returns_items());
static_assert(!properties(Function::mask_write_register).counts_bits());
static_assert(kMaxReadBits == 2000 && kMaxWriteBits == 1968 && kMaxReadRegisters == 125);
static_assert(kMaxWriteRegisters == 123 && kMaxReadWriteRegisters == 121);

}  // namespace function_test
}  // namespace takt::wire
