// Requests as servers, their rules and gateways read them.
#include "takt/wire/request_view.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <string_view>

#include "bytes.hpp"
#include "generators.hpp"
#include "takt/wire/pdu.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::wire {
namespace request_view_test {

std::string text_of(const ItemAccess& access) {
    return std::string(name(access.area)) + (access.write ? " write " : " read ") +
           std::to_string(access.start) + " x " + std::to_string(access.count);
}

std::string accesses_of(const RequestView& request) {
    std::string text;
    for (const ItemAccess& access : request.accesses()) text += (text.empty() ? "" : ", ") + text_of(access);
    return text;
}

TEST(RequestView, AccessesAndValuesOfWellFormedRequests) {
    struct Row {
        std::string_view request;
        std::string_view accesses;
        std::string_view values;
    };
    const Row rows[] = {
        {"01 00 13 00 25", "coil read 19 x 37", ""},
        {"02 FF FF 07 D0", "discrete_input read 65535 x 2000", ""},
        {"03 00 6B 00 7D", "holding_register read 107 x 125", ""},
        {"04 00 08 00 01", "input_register read 8 x 1", ""},
        {"05 00 AC FF 00", "coil write 172 x 1", "FF 00"},
        {"05 00 AC 00 00", "coil write 172 x 1", "00 00"},
        {"06 00 01 00 03", "holding_register write 1 x 1", "00 03"},
        {"07", "", ""},
        {"08 00 00", "", ""},
        {"08 00 01 FF 00", "", ""},
        {"0B", "", ""},
        {"0C", "", ""},
        {"0F 00 13 00 0A 02 CD 01", "coil write 19 x 10", "CD 01"},
        {"10 00 01 00 02 04 00 0A 01 02", "holding_register write 1 x 2", "00 0A 01 02"},
        {"11", "", ""},
        {"14 07 06 00 04 00 01 00 02", "", ""},
        {"15 09 06 00 04 00 07 00 01 06 AF", "", ""},
        {"16 00 04 00 F2 00 25", "holding_register write 4 x 1", "00 F2 00 25"},
        {"17 00 03 00 06 00 0E 00 01 02 00 FF", "holding_register read 3 x 6, holding_register write 14 x 1",
         "00 FF"},
        {"18 04 DE", "holding_register read 1246 x 1", ""},
        {"2B 0E 01 00", "", ""},
        {"2B 0D", "", ""},
        {"2B 0D 01 02", "", ""},
    };
    for (const auto& [bytes, accesses, values] : rows) {
        const ExactBytes pdu(from_hex(bytes));
        const RequestView request(pdu);
        EXPECT_TRUE(request.well_formed()) << bytes;
        EXPECT_EQ(accesses_of(request), accesses) << bytes;
        EXPECT_EQ(to_hex(request.values()), values) << bytes;
    }
}

// Rules decide about these before they are answered.
TEST(RequestView, AccessesOfMalformedRequestsAreThoseThatTheBytesShow) {
    struct Row {
        std::string_view request;
        std::string_view accesses;
    };
    const Row rows[] = {
        {"01", ""},
        {"01 00 13 00", ""},
        {"01 00 13 00 00", "coil read 19 x 1"},
        {"01 00 13 07 D1", "coil read 19 x 2001"},
        {"02 00 13 00 01 00", "discrete_input read 19 x 1"},
        {"03 00 00 00 7E", "holding_register read 0 x 126"},
        {"04 00 00 FF FF", "input_register read 0 x 65535"},
        {"05 00 01", "coil write 1 x 1"},
        {"05 00 01 00 01", "coil write 1 x 1"},
        {"05 00 01 FF 00 00", "coil write 1 x 1"},
        {"06 00", ""},
        {"06 00 01 00", "holding_register write 1 x 1"},
        {"0F 00 01 00 08", "coil write 1 x 8"},
        {"0F 00 01 07 B1 F7 00", "coil write 1 x 1969"},
        {"0F 00 01 00 08 01 FF 00", "coil write 1 x 8"},
        {"10 00 01 00 02 04 00 0A 01", "holding_register write 1 x 2"},
        {"10 00 01 00 02 03 00 0A 01", "holding_register write 1 x 2"},
        {"10 00 01 00 00 00", "holding_register write 1 x 1"},
        {"16 00 04 00 F2 00", "holding_register write 4 x 1"},
        {"17 00 03 00", ""},
        {"17 00 03 00 06 00 0E 00", "holding_register read 3 x 6"},
        {"17 00 03 00 06 00 0E 00 01", "holding_register read 3 x 6, holding_register write 14 x 1"},
        {"17 00 03 00 7E 00 0E 00 01 02 00 FF",
         "holding_register read 3 x 126, holding_register write 14 x 1"},
        {"18 04", ""},
        {"18 04 DE 00", "holding_register read 1246 x 1"},
        {"07 00", ""},
        {"08", ""},
        {"08 00", ""},
        {"08 00 00 01", ""},
        {"08 00 01 FF", ""},
        {"08 00 13 00 00", ""},
        {"08 00 15 00 00", ""},
        {"14", ""},
        {"14 00", ""},
        {"14 08 06 00 04 00 01 00 02", ""},
        {"14 07 05 00 04 00 01 00 02", ""},
        {"14 07 06 00 04 00 01 00 00", ""},
        {"14 07 06 00 04 00 01 00 7D", ""},
        {"14 0E 06 00 04 00 01 00 7C 06 00 04 00 01 00 01", ""},
        {"15 09 06 00 04 00 07 00 02 06 AF", ""},
        {"15 07 06 00 04 00 07 00 00", ""},
        {"2B", ""},
        {"2B 0E", ""},
        {"2B 0E 05 00", ""},
        {"2B 0E 01 00 00", ""},
        {"00", ""},
        {"41 00 00 00 01", ""},
        {"83 00 00 00 01", ""},
    };
    for (const auto& [bytes, accesses] : rows) {
        const ExactBytes pdu(from_hex(bytes));
        const RequestView request(pdu);
        EXPECT_FALSE(request.well_formed()) << bytes;
        EXPECT_EQ(accesses_of(request), accesses) << bytes;
        EXPECT_TRUE(request.values().empty()) << bytes;
    }
}

TEST(RequestView, SubFunctionsAndTheirData) {
    struct Row {
        std::string_view request;
        std::optional<std::uint16_t> sub_function;
        std::string_view data;
    };
    const Row rows[] = {
        {"08 01 02 03", 0x0102, "03"}, {"08 01 02", 0x0102, ""}, {"08 01", {}, "01"}, {"08", {}, ""},
        {"2B 0E 01 00", 14, "01 00"},  {"2B 0D", 13, ""},        {"2B", {}, ""},      {"11 01", {}, "01"},
        {"41 01 02", {}, "01 02"},
    };
    for (const auto& [bytes, sub_function, data] : rows) {
        const ExactBytes pdu(from_hex(bytes));
        const RequestView request(pdu);
        EXPECT_EQ(request.sub_function(), sub_function) << bytes;
        EXPECT_EQ(to_hex(request.data()), data) << bytes;
    }
}

TEST(RequestView, FileParts) {
    const ExactBytes read(from_hex("14 0E 06 00 04 00 01 00 02 06 00 03 00 09 00 01"));
    FileParts parts = RequestView(read).file_parts();
    const FilePart first = parts.take();
    EXPECT_EQ(first.file, 4);
    EXPECT_EQ(first.record, 1);
    EXPECT_EQ(first.length, 2);
    EXPECT_TRUE(first.values.empty());
    EXPECT_EQ(parts.take().file, 3);
    EXPECT_TRUE(parts.empty());

    const ExactBytes write(from_hex("15 14 06 00 04 00 07 00 02 06 AF 04 BE 06 00 05 00 00 00 01 00 01"));
    ASSERT_TRUE(RequestView(write).well_formed());
    parts = RequestView(write).file_parts();
    EXPECT_EQ(to_hex(parts.take().values), "06 AF 04 BE");
    const FilePart last = parts.take();
    EXPECT_EQ(last.file, 5);
    EXPECT_EQ(to_hex(last.values), "00 01");
    EXPECT_TRUE(parts.empty());
}

TEST(RequestView, MovesToAnotherBuffer) {
    const ExactBytes pdu(from_hex("10 00 01 00 01 02 00 0A"));
    const auto copy = from_hex("10 00 01 00 01 02 00 0A");
    const RequestView moved = RequestView(pdu).moved_to(copy);
    EXPECT_EQ(moved.pdu().data(), copy.data());
    EXPECT_EQ(moved.values().data(), copy.data() + 6);
    EXPECT_EQ(accesses_of(moved), "holding_register write 1 x 1");
}

TEST(RequestView, OfNothing) {
    EXPECT_TRUE(RequestView().empty());
    EXPECT_TRUE(RequestView(Bytes{}).empty());
    EXPECT_FALSE(RequestView(Bytes{}).well_formed());
}

// Two decoders read requests, this one and that of the typed messages. They accept the same ones, with the
// same content.
RC_GTEST_PROP(RequestViewProperty, AgreesWithTypedRequests, ()) {
    for (int kind = 0; kind < kRequestKinds; ++kind) {
        const Request typed = any_request(kind);
        const Pdu pdu = *encode(typed);
        RC_ASSERT(RequestView(pdu.span()).well_formed());
        const ExactBytes bytes = damaged(pdu);
        if (Bytes(bytes).size() > kMaxPdu) continue;
        const RequestView view(bytes);
        const auto decoded = decode_request(bytes);
        RC_ASSERT(view.well_formed() == decoded.has_value());
        if (!decoded) continue;
        RC_ASSERT(view.function() == function_of(*decoded));
        if (const auto* read = std::get_if<ReadRequest>(&*decoded))
            RC_ASSERT(shape_of(view) == shape_of(*read));
    }
}

}  // namespace request_view_test
}  // namespace takt::wire
