// The properties of each function, and the effect of whole requests.
#include "takt/wire/function.hpp"

#include <gtest/gtest.h>

#include <string_view>

#include "bytes.hpp"
#include "takt/wire/broadcast.hpp"
#include "takt/wire/prepared_request.hpp"
#include "takt/wire/request_view.hpp"

namespace takt::wire {
namespace {

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

TEST(FunctionProperties, OfEveryCode) {
    for (unsigned code = 0; code < 256; ++code) {
        const Function function{static_cast<std::uint8_t>(code)};
        const auto row = properties(function);
        EXPECT_EQ(may_be_broadcast(function), row.broadcast) << code;
        EXPECT_EQ(counts_bits(function), row.counts_bits) << code;
        EXPECT_FALSE(row.returns_items && row.echoes) << code;
        if (row.broadcast) {
            EXPECT_EQ(row.effect, Effect::write) << code;
        }
        if (!is_known(function)) {
            EXPECT_EQ(row.effect, Effect::write) << "unknown functions count as writing";
            EXPECT_FALSE(row.broadcast || row.returns_items || row.echoes) << code;
        }
    }
}

static_assert(properties(Function::read_coils).returns_items);
static_assert(!properties(Function::mask_write_register).counts_bits);

}  // namespace
}  // namespace takt::wire
