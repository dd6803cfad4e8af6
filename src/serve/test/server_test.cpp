#include "takt/serve/server.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <array>

#include "support.hpp"

namespace takt::serve {
namespace server_test {

std::string ask(Server& server, const std::string& pdu, std::uint8_t unit = 1) {
    Context context;
    context.unit = UnitId{unit};
    const auto request = bytes(pdu);
    const Answer answer = server.handle(context, wire::RequestView(request));
    return answer.kind == Answer::Kind::response ? hex(answer.pdu.span()) : "-";
}

void set_bits(BitBank bank, std::uint16_t start, std::string_view values) {
    for (std::size_t i = 0; i < values.size(); ++i)
        bank.set(static_cast<std::uint16_t>(start + i), values[i] == '1');
}

// The examples of MODBUS Application Protocol V1.1b3, section 6.
TEST(Server, AnswersTheExamplesOfTheSpecification) {
    Storage storage;
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    set_bits(units[0].banks.coils, 19, "1011001111010110101");
    set_bits(units[0].banks.discrete_inputs, 196, "0011010111011011101011");
    storage.holding[0x6B] = 0x022B;
    storage.holding[0x6C] = 0;
    storage.holding[0x6D] = 0x64;
    storage.input[8] = 10;
    Server server(units);
    EXPECT_EQ(ask(server, "01 0013 0013"), "01 03 CD 6B 05");
    EXPECT_EQ(ask(server, "02 00C4 0016"), "02 03 AC DB 35");
    EXPECT_EQ(ask(server, "03 006B 0003"), "03 06 02 2B 00 00 00 64");
    EXPECT_EQ(ask(server, "04 0008 0001"), "04 02 00 0A");
    EXPECT_EQ(ask(server, "05 00AC FF00"), "05 00 AC FF 00");
    EXPECT_TRUE(units[0].banks.coils.get(0xAC));
    EXPECT_EQ(ask(server, "05 00AC 0000"), "05 00 AC 00 00");
    EXPECT_FALSE(units[0].banks.coils.get(0xAC));
    EXPECT_EQ(ask(server, "06 0001 0003"), "06 00 01 00 03");
    EXPECT_EQ(storage.holding[1], 3);
    EXPECT_EQ(ask(server, "0F 0013 000A 02 CD01"), "0F 00 13 00 0A");
    EXPECT_EQ(ask(server, "01 0013 000A"), "01 02 CD 01");
    EXPECT_EQ(ask(server, "10 0001 0002 04 000A 0102"), "10 00 01 00 02");
    EXPECT_EQ(storage.holding[1], 10);
    EXPECT_EQ(storage.holding[2], 0x0102);
    storage.holding[4] = 0x12;
    EXPECT_EQ(ask(server, "16 0004 00F2 0025"), "16 00 04 00 F2 00 25");
    EXPECT_EQ(storage.holding[4], 0x17);
    EXPECT_EQ(ask(server, "17 0003 0003 000E 0003 06 00FF 00FE 00FD"), "17 06 00 03 00 17 00 05");
    EXPECT_EQ(storage.holding[15], 0xFE);
    EXPECT_EQ(ask(server, "17 0003 0002 0003 0002 04 1234 5678"), "17 04 12 34 56 78")
        << "writes, then reads";
}

struct Refusal {
    const char* request;
    const char* answer;
    const char* what;
};

// hostile-inputs 6, 7, 16-21.
constexpr Refusal kRefusals[] = {
    {"00", "80 01", "function 0"},
    {"09 0000", "89 01", "unknown function"},
    {"07", "87 01", "not served"},
    {"08 0000 1234", "88 01", "not served"},
    {"08 00", "88 01", "the function is judged before the length"},
    {"2B 0D 00", "AB 01", "CANopen"},
    {"2B 0E 01 00", "AB 01", "device identification"},
    {"83 0000 0001", "83 01", "a response's function"},
    {"FF", "FF 01", "a response's function"},
    {"03 0000 0000", "83 03", "quantity 0"},
    {"03 0000 007E", "83 03", "126 registers"},
    {"04 FFFF 007E", "84 03", "the quantity is judged before the address"},
    {"01 0000 07D1", "81 03", "2001 coils"},
    {"02 0000 0000", "82 03", "quantity 0"},
    {"03 0000", "83 03", "too short"},
    {"03", "83 03", "too short"},
    {"03 0000 0001 00", "83 03", "surplus bytes"},
    {"03 0000 0001 06 0001 0003", "83 03", "a hidden second request"},
    {"05 0000 0001", "85 03", "neither on nor off"},
    {"05 0000 FF01", "85 03", "neither on nor off"},
    {"05 FFFF 1234", "85 03", "the value is judged before the address"},
    {"06 0000", "86 03", "too short"},
    {"0F 0000 0000 00", "8F 03", "quantity 0"},
    {"0F 0000 0009 01 FF", "8F 03", "byte count of 9 coils is 2"},
    {"0F 0000 0008 02 FF FF", "8F 03", "byte count of 8 coils is 1"},
    {"10 0000 0002 02 0001", "90 03", "byte count of 2 registers is 4"},
    {"10 0000 0001 02 00", "90 03", "a byte less than the byte count"},
    {"10 0000 0001 02 000100", "90 03", "a byte more than the byte count"},
    {"16 0000 FFFF", "96 03", "too short"},
    {"17 0000 0000 0000 0001 02 0001", "97 03", "reads nothing"},
    {"17 0000 007E 0000 0001 02 0001", "97 03", "reads 126"},
    {"17 0000 0001 0000 0000 00", "97 03", "writes nothing"},
    {"03 0400 0001", "83 02", "behind the bank"},
    {"03 03FF 0002", "83 02", "one behind the bank"},
    {"03 FFFF 0002", "83 02", "beyond 65535"},
    {"05 0400 FF00", "85 02", "behind the bank"},
    {"06 0400 0001", "86 02", "behind the bank"},
    {"10 03FF 0002 04 0001 0001", "90 02", "one behind the bank"},
    {"16 0400 FFFF 0000", "96 02", "behind the bank"},
    {"17 0400 0001 0000 0001 02 1234", "97 02", "bad read range: nothing is written"},
    {"17 0000 0001 0400 0001 02 1234", "97 02", "bad write range"},
};

TEST(Server, RefusesWithTheRightExceptionAndChangesNothing) {
    Storage storage;
    const Storage before = storage;
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    Server server(units);
    for (const auto& [request, answer, what] : kRefusals)
        EXPECT_EQ(ask(server, request), answer) << request << ": " << what;
    EXPECT_EQ(storage, before);
}

TEST(Server, GreatestQuantities) {
    Storage storage(65536);
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    Server server(units);
    const auto length = [&](const std::string& request) { return bytes(ask(server, request)).size(); };
    EXPECT_EQ(length("01 0000 07D0"), 252u);
    EXPECT_EQ(length("03 FF83 007D"), 252u);
    EXPECT_EQ(ask(server, "03 FF84 007D"), "83 02");
    std::string many = "10 0000 007B F6";
    for (int i = 0; i < 123; ++i) many += " 0007";
    EXPECT_EQ(ask(server, many), "10 00 00 00 7B");
    EXPECT_EQ(storage.holding[122], 7);
    std::string too_many = "10 0000 007C F6";  // one more than fits
    for (int i = 0; i < 123; ++i) too_many += " 0007";
    EXPECT_EQ(ask(server, too_many), "90 03");
    std::string coils = "0F 0000 07B0 F6";
    for (int i = 0; i < 246; ++i) coils += " FF";
    EXPECT_EQ(ask(server, coils), "0F 00 00 07 B0");
    EXPECT_EQ(ask(server, "01 07A8 0010"), "01 02 FF 00");
    EXPECT_EQ(ask(server, "0F 0000 07B1 F7" + std::string(247 * 2, 'F')), "8F 03");
}

TEST(Server, ReadOnlyRangesRefuseWrites) {
    Storage storage;
    constexpr AddressRange kFixed[] = {{10, 19}};
    Banks banks = storage.banks();
    banks.holding_registers.read_only = kFixed;
    banks.coils.read_only = kFixed;
    std::array units{Unit{UnitId{1}, banks, nullptr}};
    Server server(units);
    EXPECT_EQ(ask(server, "03 000A 0001"), "03 02 00 0A");
    EXPECT_EQ(ask(server, "06 000A 0001"), "86 02");
    EXPECT_EQ(ask(server, "10 0009 0002 04 0001 0001"), "90 02");
    EXPECT_EQ(ask(server, "16 0013 0000 0000"), "96 02");
    EXPECT_EQ(ask(server, "05 000A FF00"), "85 02");
    EXPECT_EQ(ask(server, "17 0000 0001 000A 0001 02 0001"), "97 02");
    EXPECT_EQ(ask(server, "17 000A 0001 0014 0001 02 0001"), "17 02 00 0A");
    EXPECT_EQ(storage.holding[9], 9);
    EXPECT_EQ(storage.holding[20], 1);
}

// Coils over holding registers, as 0x and 4x in some devices; input registers that are the holding ones.
TEST(Server, OverlaidAreas) {
    Storage storage(8);
    constexpr AddressRange kFixed[] = {{3, 3}};
    Banks banks = storage.banks();
    banks.coils = {.first = 100, .count = 64, .overlay = BitOverlay{wire::Area::holding_register, 2}};
    banks.holding_registers.read_only = kFixed;
    banks.input_registers.values = storage.holding;
    std::array units{Unit{UnitId{1}, banks, nullptr}};
    Server server(units);
    EXPECT_EQ(ask(server, "01 0064 0014"), "01 03 02 00 03") << "registers 2 and 3";
    EXPECT_EQ(ask(server, "05 0067 FF00"), "05 00 67 FF 00");
    EXPECT_EQ(storage.holding[2], 0x000A);
    EXPECT_EQ(ask(server, "04 0002 0001"), "04 02 00 0A");
    EXPECT_EQ(ask(server, "05 0074 FF00"), "85 02") << "register 3 is read only";
    EXPECT_EQ(ask(server, "0F 0070 0005 01 1F"), "8F 02") << "and so are bits that touch it";
    EXPECT_EQ(ask(server, "0F 0084 0010 02 3412"), "0F 00 84 00 10");
    EXPECT_EQ(storage.holding[4], 0x1234);
    EXPECT_EQ(ask(server, "01 0063 0001"), "81 02");
    EXPECT_EQ(ask(server, "01 00A3 0002"), "81 02") << "behind the last one";
    units[0].banks.holding_registers.values = std::span(storage.holding).first(5);
    EXPECT_EQ(ask(server, "01 0094 0001"), "81 02") << "there is no register 5 any more";
}

TEST(Server, ValueLimitsAreException3BehindTheAddress) {
    Storage storage(8);
    constexpr ValueLimits kLimits[] = {{{0, 1}, 10, 20}, {{2, 2}, -5, 5}, {{6, 6}, 0, 7}};
    Banks banks = storage.banks();
    banks.holding_registers.limits = kLimits;
    banks.coils = {.first = 0, .count = 128, .overlay = BitOverlay{}};
    std::array units{Unit{UnitId{1}, banks, nullptr}};
    Server server(units);
    const Storage before = storage;
    EXPECT_EQ(ask(server, "06 0000 0009"), "86 03");
    EXPECT_EQ(ask(server, "06 0001 0015"), "86 03");
    EXPECT_EQ(ask(server, "06 0002 FFFA"), "86 03");
    EXPECT_EQ(ask(server, "06 0008 0000"), "86 02");
    EXPECT_EQ(ask(server, "10 0000 0003 06 000A 0014 0006"), "90 03");
    EXPECT_EQ(ask(server, "10 0006 0003 06 000A 0014 0006"), "90 02") << "the address comes first";
    EXPECT_EQ(ask(server, "16 0000 0000 0009"), "96 03");
    EXPECT_EQ(ask(server, "17 0000 0001 0000 0001 02 0009"), "97 03");
    EXPECT_EQ(ask(server, "05 0063 FF00"), "85 03") << "a bit that would make register 6 fourteen";
    EXPECT_EQ(storage, before);
    EXPECT_EQ(ask(server, "10 0000 0003 06 000A 0014 FFFB"), "10 00 00 00 03");
    EXPECT_EQ(ask(server, "16 0000 0000 000B"), "16 00 00 00 00 00 0B");
    EXPECT_EQ(storage.holding[0], 11);
}

TEST(Server, HooksSeeTheValuesOfWrites) {
    struct Watch final : UnitHooks {
        std::optional<wire::ExceptionCode> before(const Context&, const Access& access) override {
            if (access.write) lines.push_back(hex(access.values));
            return {};
        }
        void written(const Context&, const Access& access) override { lines.push_back(hex(access.values)); }
        std::vector<std::string> lines;
    } watch;
    Storage storage(64);
    std::array units{Unit{UnitId{1}, storage.banks(), &watch}};
    Server server(units);
    const auto seen = [&](const std::string& request) {
        watch.lines.clear();
        ask(server, request);
        EXPECT_EQ(watch.lines.size(), 2u);
        EXPECT_EQ(watch.lines.front(), watch.lines.back());
        return watch.lines.front();
    };
    EXPECT_EQ(seen("05 0001 FF00"), "01");
    EXPECT_EQ(seen("05 0001 0000"), "00");
    EXPECT_EQ(seen("06 0001 1234"), "12 34");
    EXPECT_EQ(seen("0F 0002 0009 02 CD01"), "CD 01");
    EXPECT_EQ(seen("10 0001 0002 04 000A 0102"), "00 0A 01 02");
    EXPECT_EQ(seen("16 0001 00F2 0025"), "00 07") << "what comes of it";
    EXPECT_EQ(seen("17 0003 0002 0003 0002 04 1234 5678"), "12 34 56 78");
}

TEST(Server, ChoosesTheUnit) {
    Storage first, second;
    first.holding[0] = 0x1111;
    second.holding[0] = 0x2222;
    std::array units{Unit{UnitId{5}, first.banks(), nullptr}, Unit{UnitId{6}, second.banks(), nullptr}};
    Server server(units);
    Server with_default(units, UnitId{6});
    const std::string read = "03 0000 0001";
    EXPECT_EQ(ask(server, read, 5), "03 02 11 11");
    EXPECT_EQ(ask(server, read, 6), "03 02 22 22");
    EXPECT_EQ(ask(server, read, 0), "03 02 11 11");
    EXPECT_EQ(ask(server, read, 255), "03 02 11 11");
    EXPECT_EQ(ask(with_default, read, 0), "03 02 22 22");
    EXPECT_EQ(ask(server, read, 7), "83 0A");
    EXPECT_TRUE(server.serves(UnitId{5}));
    EXPECT_FALSE(server.serves(UnitId{0}));
    EXPECT_FALSE(server.serves(UnitId{255}));
    units[1].id = UnitId{255};
    EXPECT_EQ(ask(server, read, 255), "03 02 22 22") << "a unit of that very number comes first";
}

TEST(Server, BroadcastsWriteEverywhereAndAreNeverAnswered) {
    Storage first, second(8);
    std::array units{Unit{UnitId{5}, first.banks(), nullptr}, Unit{UnitId{6}, second.banks(), nullptr}};
    Server server(units);
    Context context;
    context.broadcast = true;
    const char* requests[] = {"06 0003 ABCD",      "10 0004 0001 02 1234",
                              "05 0001 FF00",      "0F 0002 0002 01 03",
                              "16 0005 0000 7777", "06 0010 4444",
                              "03 0000 0001",      "17 0000 0001 0000 0001 02 9999",
                              "06 0000",           "99",
                              "86 0000 0001"};
    for (const char* request : requests) {
        const auto pdu = bytes(request);
        EXPECT_EQ(server.handle(context, wire::RequestView(pdu)).kind, Answer::Kind::silence) << request;
    }
    for (const Storage* storage : {&first, &second}) {
        EXPECT_EQ(storage->holding[3], 0xABCD);
        EXPECT_EQ(storage->holding[4], 0x1234);
        EXPECT_EQ(storage->holding[5], 0x7777);
        EXPECT_EQ(storage->holding[0], 0);
        EXPECT_EQ(storage->coils[0], 0b1110);
    }
    EXPECT_EQ(first.holding[16], 0x4444) << "done where the address exists";
}

class Journal final : public UnitHooks {
public:
    std::optional<wire::ExceptionCode> before(const Context& context, const Access& access) override {
        add("before", context, access);
        if (bank) bank->set(0, static_cast<std::uint16_t>(context.time.time_since_epoch().count()));
        return refusal;
    }
    void written(const Context& context, const Access& access) override { add("written", context, access); }

    std::vector<std::string> lines;
    std::optional<wire::ExceptionCode> refusal;
    RegisterBank* bank = nullptr;

private:
    void add(const char* what, const Context& context, const Access& access) {
        lines.push_back(std::string(what) + " " + std::string(context.peer) + " " +
                        std::string(wire::name(access.area)) + " " + std::to_string(access.start) + "+" +
                        std::to_string(access.count) + (access.write ? " w" : " r"));
    }
};

TEST(Server, HooksSeeEveryAccessAndMayRefuse) {
    Storage storage;
    Journal journal;
    std::array units{Unit{UnitId{1}, storage.banks(), &journal}};
    journal.bank = &units[0].banks.holding_registers;
    Server server(units);
    Context context;
    context.unit = UnitId{1};
    context.time = Instant{} + Duration(77);
    context.peer = "peer";
    const auto handle = [&](const char* pdu) {
        return hex(server.handle(context, wire::RequestView(bytes(pdu))).pdu.span());
    };

    EXPECT_EQ(handle("03 0000 0001"), "03 02 00 4D")
        << "values may be brought up to date before they are read";
    EXPECT_EQ(handle("06 0002 0005"), "06 00 02 00 05");
    EXPECT_EQ(handle("17 0002 0001 0003 0002 04 0001 0002"), "17 02 00 05");
    EXPECT_EQ(handle("03 2000 0001"), "83 02");
    EXPECT_EQ(journal.lines,
              (std::vector<std::string>{
                  "before peer holding_register 0+1 r", "before peer holding_register 2+1 w",
                  "written peer holding_register 2+1 w", "before peer holding_register 3+2 w",
                  "before peer holding_register 2+1 r", "written peer holding_register 3+2 w"}));
    journal.refusal = wire::ExceptionCode::server_device_busy;
    const Storage before = storage;
    EXPECT_EQ(handle("06 0002 0009"), "86 06");
    EXPECT_EQ(handle("17 0002 0001 0003 0002 04 0007 0008"), "97 06");
    EXPECT_EQ(handle("0F 0000 0008 01 FF"), "8F 06");
    EXPECT_EQ(storage, before);
}

// Buffers of exactly the request's size: the address sanitizer sees a read beyond it.
RC_GTEST_PROP(Server, AnyBytesGetAWellFormedAnswerAndARefusalChangesNothing, ()) {
    Storage storage(40);
    std::array units{Unit{UnitId{1}, storage.banks(), nullptr}};
    Server server(units);
    const auto function = *rc::gen::weightedOneOf<std::uint8_t>(
        {{4, rc::gen::element<std::uint8_t>(1, 2, 3, 4, 5, 6, 15, 16, 22, 23)},
         {1, rc::gen::arbitrary<std::uint8_t>()}});
    auto request = *rc::gen::resize(
        30, rc::gen::container<std::vector<std::uint8_t>>(rc::gen::weightedOneOf<std::uint8_t>(
                {{3, rc::gen::inRange<std::uint8_t>(0, 9)}, {1, rc::gen::arbitrary<std::uint8_t>()}})));
    request.insert(request.begin(), function);
    request.shrink_to_fit();
    const Storage before = storage;
    Context context;
    context.unit = UnitId{1};
    const Answer answer = server.handle(context, wire::RequestView(request));
    RC_ASSERT(answer.kind == Answer::Kind::response);
    if (answer.pdu[0] == function && function < 0x80) {
        RC_ASSERT(wire::decode_response(answer.pdu.span()).has_value());
        return;
    }
    RC_ASSERT(answer.pdu.size() == 2u);
    RC_ASSERT(answer.pdu[0] == (function | 0x80));
    RC_ASSERT(answer.pdu[1] >= 1);
    RC_ASSERT(answer.pdu[1] <= 3);
    RC_ASSERT(storage == before);
}

}  // namespace server_test
}  // namespace takt::serve
