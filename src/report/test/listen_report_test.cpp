// The texts of a heard line, its JSON and its project, which is loaded again.
#include "takt/report/times/listen_report.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "hex.hpp"
#include "takt/capture/line_listener.hpp"
#include "takt/host/project_file.hpp"

namespace takt::report {
namespace listen_report_test {

using namespace std::chrono_literals;

/// Prints each event of a listener.
class Events final : public capture::ListenObserver {
public:
    void on_exchange(const capture::Exchange& exchange) override {
        if (silent) return;
        text += exchange_line(texts, names, "T", exchange) + '\n';
        json.push_back(exchange_json(names, "T", exchange));
    }
    void on_stray(const capture::LineFrame& frame) override {
        text += stray_line(texts, names, "T", frame) + '\n';
        json.push_back(stray_json("T", frame));
    }
    void on_damaged(const capture::DamagedBytes& damaged) override {
        text += damaged_line(texts, "T", damaged) + '\n';
        json.push_back(damaged_json("T", damaged));
    }
    Texts texts{text::Language::english};
    HeardNames names;
    std::string text;
    std::vector<file::Json> json;
    bool silent = false;
};

class ListenReport : public testing::Test {
protected:
    void send(Duration t, std::uint8_t unit, std::string_view pdu) {
        const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{unit}, 0, takt::test::from_hex(pdu));
        listener.on_bytes(Instant(t), frame.span());
    }
    void exchange(Duration t, std::uint8_t unit, std::string_view request, std::string_view response) {
        send(t, unit, request);
        send(t + 5ms, unit, response);
    }
    [[nodiscard]] ListenRun run() const {
        return {.port = "/dev/ttyS1",
                .connection = {.port = "/dev/ttyS1", .format = {9600, 8, wire::Parity::none, 1}},
                .statistics = listener.statistics(),
                .names = events.names};
    }
    Events events;
    capture::LineListener listener{{}, events};
};

TEST_F(ListenReport, LinesOfEvents) {
    exchange(0ms, 1, "03 0000 0002", "03 04 0001 0002");
    exchange(100ms, 1, "03 0000 0002", "83 02");
    send(200ms, 0, "06 0001 0005");
    send(300ms, 2, "03 0000 0001");
    send(600ms, 2, "03 0000 0001");
    listener.on_tick(Instant(2s));
    send(3s, 2, "03 02 0000");
    listener.on_bytes(Instant(4s), takt::test::from_hex("01 02 03"));
    listener.end();
    EXPECT_EQ(events.text,
              "T  unit 1 read holding registers 0..1 → 2 values: 1 2; 5.00 ms\n"
              "T  unit 1 read holding registers 0..1 → exception 2 illegal data address; 5.00 ms\n"
              "T  unit 0 write single register 1 = 5; broadcast\n"
              "T  unit 2 read holding registers 0; no response\n"
              "T  unit 2 read holding registers 0; no response; repeated\n"
              "T  unit 2 read holding registers → 1 value: 0; response without a request\n"
              "T  damaged, bytes: 3: 01 02 03\n");
    EXPECT_EQ(events.json[1].dump(),
              R"({"event":"exchange","time":"T","unit":1,"device":null,"function":3,"start":0,"quantity":2,)"
              R"("outcome":"exception","exception":2,"response_ms":5.0,"overlaps":false,"repeats":false,)"
              R"("request":"03 00 00 00 02","response":"83 02","values":{}})");
}

TEST_F(ListenReport, TheSummaryHasDevicesMastersAndRequests) {
    for (int i = 0; i < 20; ++i) {
        exchange(i * 100ms, 1, "03 0000 0002", "03 04 0001 0002");
        send(i * 100ms + 50ms, 9, "04 0007 0001");
    }
    const auto text = listen_summary(events.texts, run(), 200);
    EXPECT_NE(text.find("/dev/ttyS1: 9600 8N1, RTU, time 1950 ms"), std::string::npos) << text;
    EXPECT_NE(text.find("never answers"), std::string::npos) << text;
    EXPECT_NE(text.find("1: cycle 100 ms (100 ms – 100 ms), different requests 2, all requests 40"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("0x03 0..1"), std::string::npos) << text;
    const auto json = listen_json(run());
    EXPECT_EQ(json.find("baud")->dump(), "9600");
    EXPECT_EQ(json.find("requests")->dump(), "40");
}

TEST_F(ListenReport, TheProjectCanBeLoaded) {
    for (int i = 0; i < 20; ++i) {
        exchange(i * 100ms, 1, "03 0000 0028", "03 50" + std::string(160, '0'));
        if (i % 5 == 0) exchange(i * 100ms + 20ms, 1, "01 0010 0003", "01 01 00");
        exchange(i * 100ms + 40ms, 250, "03 0000 0001", "03 02 0000");
    }
    exchange(3s, 1, "10 0026 0002 04 00000000", "10 0026 0002");
    exchange(4s, 2, "06 0001 0000", "06 0001 0000");
    for (const auto language :
         {text::Language::english, text::Language::russian, text::Language::ukrainian}) {
        const auto text = listen_project(Texts(language), std::array{run()});
        const auto loaded = host::load_project_text("test", text);
        ASSERT_FALSE(loaded.has_errors()) << text;
        const auto& devices = loaded.project.lines.at(0).devices;
        ASSERT_EQ(devices.size(), 2U) << text;
        EXPECT_EQ(devices[0].poll_period, 100ms);
        EXPECT_EQ(devices[0].registers_per_request, 40);
        ASSERT_EQ(devices[0].variables.size(), 43U);
        EXPECT_EQ(devices[0].variables[0].period, 500ms);
        EXPECT_EQ(devices[0].variables[0].start(), 16);
        EXPECT_EQ(devices[0].variables[3 + 38].write, wire::Function::write_multiple_registers);
        EXPECT_EQ(devices[0].readable[3], (std::vector<model::ItemRange>{{0, 39}}));
        EXPECT_EQ(devices[1].variables.at(0).write, wire::Function::write_single_register);
        EXPECT_NE(text.find(": 250"), std::string::npos) << "the unit that no device may have";
    }
    const auto slow = host::load_project_text("test", listen_project(events.texts, std::array{run()}, 4));
    EXPECT_EQ(slow.project.lines.at(0).devices[0].poll_period, 400ms);
}

TEST_F(ListenReport, TheProjectOfACaptureHasAllItsLines) {
    for (int i = 0; i < 20; ++i) exchange(i * 100ms, 1, "03 0000 0001", "03 02 0000");
    auto first = run();
    first.line = "heating";
    auto second = run();
    second.line = "two\nlines";
    const auto text = listen_project(events.texts, std::array{first, second});
    const auto loaded = host::load_project_text("test", text);
    ASSERT_FALSE(loaded.has_errors()) << text;
    ASSERT_EQ(loaded.project.lines.size(), 2U);
    EXPECT_EQ(loaded.project.lines[1].devices.at(0).name, "line 2 unit 1");
    EXPECT_EQ(loaded.project.lines[1].devices[0].variables.at(0).name, "line2_unit1_holding_0");
    EXPECT_NE(text.find("  # heating\n"), std::string::npos) << text;
}

TEST_F(ListenReport, TheProjectOfAllUnitsStaysWithinTheLimitsOfAFile) {
    events.silent = true;
    Duration time{};
    for (int unit = 1; unit <= 247; ++unit)
        for (int start = 0; start < 4 * 125; start += 125)
            exchange(time += 100ms, static_cast<std::uint8_t>(unit), fmt::format("03 {:04X} 007D", start),
                     "03 FA" + std::string(500, '0'));
    const auto text = listen_project(events.texts, std::array{run()});
    const auto loaded = host::load_project_text("test", text);
    ASSERT_FALSE(loaded.has_errors()) << loaded.findings.front().code;
    const auto& devices = loaded.project.lines.at(0).devices;
    ASSERT_EQ(devices.size(), 247U);
    for (const auto& device : devices) EXPECT_EQ(device.variables.size(), 80U);
    EXPECT_NE(text.find("left out: 420"), std::string::npos);
}

}  // namespace listen_report_test
}  // namespace takt::report
