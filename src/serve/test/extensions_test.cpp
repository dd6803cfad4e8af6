// The functions that a unit has by its extensions.
#include <gtest/gtest.h>

#include <array>
#include <map>

#include "support.hpp"
#include "takt/serve/diagnostics.hpp"
#include "takt/serve/fifos.hpp"
#include "takt/serve/files.hpp"
#include "takt/serve/identification.hpp"
#include "takt/serve/serial_slave.hpp"

namespace takt::serve {
namespace extensions_test {

/// Function 65 returns its data, 66 waits, 67 does not answer.
class Custom final : public Extension {
public:
    bool handle(Unit&, const Context& context, const wire::RequestView& request, Answer& answer) override {
        const std::uint8_t function = request.pdu()[0];
        if (function < 65 || function > 67) return false;
        ++calls;
        if (context.broadcast) ++broadcasts;
        if (function == 65) answer.pdu.assign(request.pdu());
        if (function == 66) answer = Answer::pending(7);
        if (function == 67) answer.kind = Answer::Kind::silence;
        return true;
    }
    int calls = 0;
    int broadcasts = 0;
};

constexpr DiagnosticsOptions kAllRights{true, true, {}};

/// A unit with everything.
struct Rig {
    explicit Rig(const DiagnosticsOptions& options = kAllRights) : diagnostics(options, &log) {
        files[0] = {4, records, false};
        files[1] = {3, fixed, true};
        fifos[0] = {0x04DE, queue};
        fifos[1] = {1, {}};
        fifos[2] = {2, long_queue};
        extensions = {&diagnostics, &identification, &file_records, &queues, &custom};
        units[0] = {UnitId{1}, storage.banks(), nullptr, extensions};
    }
    std::string ask(const std::string& pdu, bool broadcast = false) {
        const auto request = bytes(pdu);
        Context context;
        context.unit = UnitId{static_cast<std::uint8_t>(broadcast ? 0 : 1)};
        context.broadcast = broadcast;
        server.on_line_event(LineEvent::message);
        const Answer answer = server.handle(context, wire::RequestView(request));
        if (answer.kind == Answer::Kind::pending) return "pending " + std::to_string(answer.token);
        return answer.kind == Answer::Kind::response ? hex(answer.pdu.span()) : "-";
    }
    unsigned counter(const std::string& sub_function) {
        const std::string answer = ask("08 " + sub_function + " 0000");
        EXPECT_EQ(answer.size(), 14u) << answer;
        return static_cast<unsigned>(std::stoul(answer.substr(9, 2) + answer.substr(12, 2), nullptr, 16));
    }

    Storage storage;
    EventLog log;
    Diagnostics diagnostics;
    std::array<IdentificationObject, 5> objects{
        {{0, "Takt"}, {1, "T-1"}, {2, "1.0"}, {5, "model"}, {0x80, "own"}}};
    std::array<std::uint8_t, 3> server_id{'T', 'a', 'k'};
    Identification identification{objects, server_id};
    std::array<std::uint16_t, 20> records{0, 0x0DFE, 0x0020};
    std::array<std::uint16_t, 12> fixed{0, 0, 0, 0, 0, 0, 0, 0, 0, 0x33CD, 0x0040};
    std::array<File, 2> files;
    Files file_records{files};
    std::array<std::uint16_t, 2> queue{0x01B8, 0x1284};
    std::array<std::uint16_t, 32> long_queue{};
    std::array<Fifo, 3> fifos;
    Fifos queues{fifos};
    Custom custom;
    std::array<Extension*, 5> extensions{};
    std::array<Unit, 1> units;
    Server server{units};
};

struct Row {
    const char* request;
    const char* answer;
};

// Examples of MODBUS Application Protocol V1.1b3, section 6, and its rules for the rest; hostile-inputs
// 22-25.
constexpr Row kRows[] = {
    {"08 0000 A537", "08 00 00 A5 37"},
    {"08 0000", "08 00 00"},
    {"08 0000 01020304", "08 00 00 01 02 03 04"},
    {"08 0000 010203", "88 03"},
    {"08 00", "88 03"},
    {"08", "88 03"},
    {"08 0002 0000", "08 00 02 00 00"},
    {"08 0002 0001", "88 03"},
    {"08 0002", "88 03"},
    {"08 0002 000000", "88 03"},
    {"08 0003 0A00", "08 00 03 0A 00"},
    {"08 0003 0D00", "88 03"},
    {"08 0001 1234", "88 03"},
    {"08 0004 0001", "88 03"},
    {"08 0005 0000", "88 01"},
    {"08 0009 0000", "88 01"},
    {"08 0013 0000", "88 01"},
    {"08 0015 0000", "88 01"},
    {"08 0014 0000", "08 00 14 00 00"},
    {"07 00", "87 03"},
    {"0B 00", "8B 03"},
    {"0C 00", "8C 03"},
    {"11", "11 04 54 61 6B FF"},
    {"11 00", "91 03"},
    {"14 0E 06 0004 0001 0002 06 0003 0009 0002", "14 0C 05 06 0D FE 00 20 05 06 33 CD 00 40"},
    {"14 00", "94 03"},
    {"14 06 06 0004 0001 00", "94 03"},
    {"14 07 05 0004 0001 0002", "94 03"},
    {"14 07 06 0004 0001 0000", "94 03"},
    {"14 07 06 0004 0001 FFFE", "94 03"},
    {"14 07 06 0004 0001 007D", "94 03"},
    {"14 08 06 0004 0001 0002", "94 03"},
    {"14 07 06 0004 0001 0002 00", "94 03"},
    {"14 0E 06 0004 0001 003E 06 0004 0001 003F", "94 03"},
    {"14 07 06 0009 0001 0001", "94 02"},
    {"14 07 06 0004 0013 0002", "94 02"},
    {"14 07 06 0004 FFFF 0001", "94 02"},
    {"14 0E 06 0009 0001 0001 06 0004 0001 0000", "94 03"},
    {"15 0D 06 0004 0007 0003 06AF 04BE 100D", "15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D"},
    {"15 09 06 0003 0000 0001 0001", "95 02"},
    {"15 0B 06 0004 0000 0001 00010002", "95 03"},
    {"15 09 06 0004 0000 0002 0001", "95 03"},
    {"15 12 06 0004 0000 0001 7777 06 0004 0014 0001 8888", "95 02"},
    {"18 04DE", "18 00 06 00 02 01 B8 12 84"},
    {"18 0001", "18 00 02 00 00"},
    {"18 0002", "98 03"},
    {"18 0003", "98 02"},
    {"18 04", "98 03"},
    {"18 04DE 00", "98 03"},
    {"2B", "AB 03"},
    {"2B 0D 00", "AB 01"},
    {"2B 0E 01", "AB 03"},
    {"2B 0E 00 00", "AB 03"},
    {"2B 0E 05 00", "AB 03"},
    {"2B 0E 04 03", "AB 02"},
    {"2B 0E 04 01", "2B 0E 04 83 00 00 01 01 03 54 2D 31"},
    {"2B 0E 01 00", "2B 0E 01 83 00 00 03 00 04 54 61 6B 74 01 03 54 2D 31 02 03 31 2E 30"},
    {"2B 0E 01 80", "2B 0E 01 83 00 00 03 00 04 54 61 6B 74 01 03 54 2D 31 02 03 31 2E 30"},
    {"2B 0E 02 02", "2B 0E 02 83 00 00 02 02 03 31 2E 30 05 05 6D 6F 64 65 6C"},
    {"2B 0E 03 05", "2B 0E 03 83 00 00 02 05 05 6D 6F 64 65 6C 80 03 6F 77 6E"},
    {"41 010203", "41 01 02 03"},
    {"42", "pending 7"},
    {"43", "-"},
    {"44", "C4 01"},
    {"C1", "C1 01"},
};

TEST(Extensions, AnswerAsTheSpecificationSays) {
    Rig rig;
    for (const auto& [request, answer] : kRows) EXPECT_EQ(rig.ask(request), answer) << request;
    EXPECT_EQ(rig.records[7], 0x06AF);
    EXPECT_EQ(rig.records[9], 0x100D);
    EXPECT_EQ(rig.records[0], 0) << "a request of which one part is refused writes nothing";
}

TEST(Extensions, WithoutThemTheirFunctionsAreUnknown) {
    Storage storage;
    std::array units{Unit{UnitId{1}, storage.banks()}};
    Server server(units);
    for (const std::string function : {"07", "08", "0B", "0C", "11", "14", "15", "18", "2B", "41"}) {
        const auto request = bytes(function);
        const Answer answer = server.handle({{}, UnitId{1}, false, {}, {}}, wire::RequestView(request));
        EXPECT_EQ(hex(answer.pdu.span()), hex(exception_to(request[0], wire::ExceptionCode{1}).span()));
    }
    Diagnostics silent;
    Extension* const extensions[]{&silent};
    units[0].extensions = extensions;
    const auto log = bytes("0C");
    EXPECT_EQ(hex(server.handle({{}, UnitId{1}, false, {}, {}}, wire::RequestView(log)).pdu.span()), "8C 01");
}

TEST(Diagnostics, ReadsTheExceptionStatus) {
    Rig rig;
    rig.diagnostics.set_exception_status(0x6D);
    EXPECT_EQ(rig.ask("07"), "07 6D");
    Rig with_coils(DiagnosticsOptions{false, false, std::uint16_t{1020}});
    with_coils.storage.coils[1020 / 8] = 0b1010'0000;
    EXPECT_EQ(with_coils.ask("07"), "07 0A") << "coils 1020..1023; those behind the bank are 0";
}

TEST(Diagnostics, Counts) {
    Rig rig;
    rig.ask("03 0000 0001");
    rig.ask("03 0000 0000");  // exception 3
    rig.ask("43");            // not answered
    rig.ask("06 0000 0001", true);
    rig.server.on_line_event(LineEvent::error);
    rig.server.on_line_event(LineEvent::error);
    rig.server.on_line_event(LineEvent::overrun);
    rig.server.on_line_event(LineEvent::message);  // of another unit
    EXPECT_EQ(rig.counter("000B"), 6u);
    EXPECT_EQ(rig.counter("000C"), 2u);
    EXPECT_EQ(rig.counter("000D"), 1u);
    EXPECT_EQ(rig.counter("000E"), 8u) << "with the four questions so far";
    EXPECT_EQ(rig.counter("000F"), 2u);
    EXPECT_EQ(rig.counter("0010"), 0u);
    EXPECT_EQ(rig.counter("0011"), 0u);
    EXPECT_EQ(rig.counter("0012"), 1u);
    EXPECT_EQ(rig.ask("08 0014 0000"), "08 00 14 00 00");
    EXPECT_EQ(rig.counter("0012"), 0u);
    rig.diagnostics.set_diagnostic_register(0xBEEF);
    EXPECT_EQ(rig.counter("0002"), 0xBEEFu);
    EXPECT_EQ(rig.ask("08 000A 0000"), "08 00 0A 00 00");
    EXPECT_EQ(rig.counter("0002"), 0u);
    EXPECT_EQ(rig.counter("000C"), 0u);
}

TEST(Diagnostics, CountsBusyAndItsHooksExceptions) {
    struct Busy final : UnitHooks {
        std::optional<wire::ExceptionCode> before(const Context&, const Access&) override { return code; }
        void written(const Context&, const Access&) override {}
        wire::ExceptionCode code{6};
    } busy;
    Rig rig;
    rig.units[0].hooks = &busy;
    EXPECT_EQ(rig.ask("03 0000 0001"), "83 06");
    busy.code = wire::ExceptionCode{7};
    EXPECT_EQ(rig.ask("03 0000 0001"), "83 07");
    EXPECT_EQ(rig.counter("0010"), 1u);
    EXPECT_EQ(rig.counter("0011"), 1u);
}

TEST(Diagnostics, EventCounterCountsWhatWasDone) {
    Rig rig;
    EXPECT_EQ(rig.ask("0B"), "0B 00 00 00 00");
    rig.ask("03 0000 0001");
    rig.ask("06 0000 0001");
    rig.ask("03 0000 0000");
    EXPECT_EQ(rig.ask("0B"), "0B 00 00 00 02");
    EXPECT_EQ(rig.ask("0B"), "0B 00 00 00 02");
    rig.ask("08 0001 0000");
    EXPECT_EQ(rig.ask("0B"), "0B 00 00 00 00");
}

TEST(Diagnostics, EventLogHasTheLatestFirst) {
    Rig rig;
    rig.ask("03 0000 0001");
    rig.server.on_line_event(LineEvent::error);
    rig.ask("03 0000 0000");
    rig.ask("06 0000 0001", true);
    // status, 2 events, 4 messages; own question, broadcast, exception sent, question, error, answer,
    // question
    EXPECT_EQ(rig.ask("0C"), "0C 0D 00 00 00 02 00 04 80 C0 41 80 82 40 80");
    rig.ask("08 0001 FF00");
    EXPECT_EQ(rig.ask("0C"), "0C 08 00 00 00 00 00 01 80 00") << "cleared, then restarted";
    for (int i = 0; i < 100; ++i) rig.server.on_line_event(LineEvent::error);
    const std::string full = rig.ask("0C");
    EXPECT_EQ(full.substr(0, 5), "0C 46");
    EXPECT_EQ(bytes(full).size(), 2u + 6 + 64);
    EXPECT_EQ(full.substr(24, 8), "80 82 82");
}

// hostile-inputs 25
TEST(Diagnostics, ListenOnlyAndRestartAreRights) {
    Rig without(DiagnosticsOptions{});
    EXPECT_EQ(without.ask("08 0004 0000"), "88 01");
    EXPECT_EQ(without.ask("08 0001 0000"), "88 01");
    EXPECT_FALSE(without.diagnostics.listens_only());
    Rig rig;
    EXPECT_EQ(rig.ask("08 0004 0000"), "-");
    EXPECT_TRUE(rig.diagnostics.listens_only());
    EXPECT_EQ(rig.ask("03 0000 0001"), "-");
    EXPECT_EQ(rig.ask("06 0000 1234"), "-");
    EXPECT_EQ(rig.ask("06 0001 1234", true), "-");
    EXPECT_EQ(rig.ask("08 0000 1234"), "-");
    EXPECT_EQ(rig.storage.holding[0], 0);
    EXPECT_EQ(rig.storage.holding[1], 1);
    EXPECT_EQ(rig.ask("08 0001 0000", true), "-");
    EXPECT_TRUE(rig.diagnostics.listens_only()) << "a broadcast does not restart";
    EXPECT_EQ(rig.ask("08 0001 0000"), "-") << "restarts, and is not answered";
    EXPECT_FALSE(rig.diagnostics.listens_only());
    EXPECT_EQ(rig.ask("03 0000 0001"), "03 02 00 00");
    EXPECT_EQ(rig.ask("08 0001 0000"), "08 00 01 00 00") << "an ordinary restart is";
}

TEST(Extensions, Broadcasts) {
    Rig rig;
    EXPECT_EQ(rig.ask("15 09 06 0004 0000 0001 5555", true), "-");
    EXPECT_EQ(rig.records[0], 0x5555);
    EXPECT_EQ(rig.ask("41 01", true), "-");
    EXPECT_EQ(rig.custom.broadcasts, 1);
    EXPECT_EQ(rig.ask("08 000A 0000", true), "-");
    EXPECT_EQ(rig.ask("18 04DE", true), "-");
    EXPECT_GT(rig.counter("000E"), 4u) << "not cleared by a broadcast";
}

/// All objects of a stream, asked for as long as more follow.
std::map<std::size_t, std::string> collect(Server& server, unsigned code, int& questions) {
    std::map<std::size_t, std::string> objects;
    wire::ReadDeviceIdRequest request{static_cast<std::uint8_t>(code), 0};
    for (questions = 1; questions < 400; ++questions) {
        const auto pdu = wire::encode(request);
        const auto answer = server.handle({{}, UnitId{1}, false, {}, {}}, wire::RequestView(pdu->span()));
        const auto decoded = wire::decode_response(request, answer.pdu.span());
        const auto* response = decoded ? std::get_if<wire::ReadDeviceIdResponse>(&*decoded) : nullptr;
        if (!response) return {};
        std::size_t at = 0;
        for (const auto& [id, length] : response->objects) {
            EXPECT_TRUE(
                objects.try_emplace(id, response->text.begin() + at, response->text.begin() + at + length)
                    .second);
            at += length;
        }
        if (!response->more_follows) return objects;
        EXPECT_FALSE(response->objects.empty()) << "more-follows makes progress";
        request.object = response->next_object;
    }
    return objects;
}

// hostile-inputs 24
TEST(Identification, StreamsInPiecesUpToItsLevel) {
    std::vector<std::string> texts;
    for (unsigned i = 0; i < 256; ++i) texts.emplace_back(i * 37 % 245, static_cast<char>('a' + i % 26));
    texts[200] = std::string(IdentificationObject::kMostText, 'z');
    struct Level {
        unsigned objects;
        std::array<std::size_t, 4> expected;  // objects, by code
    };
    for (const auto& [count, expected] :
         {Level{3, {0, 3, 3, 3}}, Level{7, {0, 3, 7, 7}}, Level{256, {0, 3, 128, 256}}}) {
        std::vector<IdentificationObject> objects;
        for (unsigned i = 0; i < count; ++i) objects.push_back({static_cast<std::uint8_t>(i), texts[i]});
        Identification identification(objects);
        Extension* const extensions[]{&identification};
        Storage storage;
        std::array units{Unit{UnitId{1}, storage.banks(), nullptr, extensions}};
        Server server(units);
        for (unsigned code = 1; code <= 3; ++code) {
            int questions = 0;
            const auto collected = collect(server, code, questions);
            EXPECT_EQ(collected.size(), expected[code]) << count << " objects, code " << code;
            for (const auto& [id, text] : collected) EXPECT_EQ(text, texts[id]);
        }
    }
}

TEST(SerialSlave, CustomFunctionsAndDiagnosticsOverTheLine) {
    using namespace std::chrono_literals;
    Rig rig;
    SerialConfig config;
    config.format = {115200, 8, wire::Parity::none, 1};
    SerialSlave slave(config, rig.server);
    Instant now{};
    slave.on_link(now, true);
    const auto exchange = [&](const std::string& text) {
        std::string sent;
        now += 20ms;
        slave.on_bytes(now, bytes(text));
        for (; slave.next_wakeup() != kNever; sent += hex(slave.transmit(now))) {
            now = slave.next_wakeup();
            slave.on_tick(now);
        }
        return sent;
    };
    EXPECT_EQ(exchange(rtu(1, "41 010203")), rtu(1, "41 010203")) << "only the silence ends the frame";
    EXPECT_EQ(exchange(rtu(1, "08 0000 01020304")), rtu(1, "08 0000 01020304"));
    EXPECT_EQ(exchange(rtu(1, "18 04DE")), rtu(1, "18 0006 0002 01B8 1284"));
    EXPECT_EQ(exchange("01 03 00 00 00 01 00 00"), "");
    EXPECT_EQ(exchange(rtu(1, "08 000C 0000")), rtu(1, "08 000C 0001")) << "a bad CRC is counted";
    EXPECT_EQ(exchange(rtu(7, "03 0000 0001")), "");
    EXPECT_EQ(exchange(rtu(1, "08 000B 0000")), rtu(1, "08 000B 0006"));
    EXPECT_EQ(exchange(rtu(1, "2B 0E 04 01")), rtu(1, "2B 0E 04 83 00 00 01 01 03 542D31"));
    EXPECT_EQ(exchange(rtu(1, "08 0004 0000")), "");
    EXPECT_EQ(exchange(rtu(1, "03 0000 0001")), "");
    EXPECT_EQ(exchange(rtu(1, "08 0001 0000")), "");
    EXPECT_EQ(exchange(rtu(1, "03 0001 0001")), rtu(1, "03 02 0001"));
}

}  // namespace extensions_test
}  // namespace takt::serve
