// The scan of one target, setting by setting, with scripted lines and time moved by hand.
#include "takt/bus/target_scan.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "takt/model/target_url.hpp"
#include "takt/wire/frame.hpp"

namespace takt::bus {
namespace target_scan_test {

using namespace std::chrono_literals;
using ByteVector = std::vector<std::uint8_t>;

struct Recorder final : ScanObserver {
    void on_device(const FoundDevice& device) override { findings.devices.push_back(device); }
    void on_trouble(const ScanTrouble& trouble) override { findings.troubles.push_back(trouble); }
    void on_absent_host() override { ++findings.absent_hosts; }
    ScanFindings findings;
};

model::Line serial_line(std::uint32_t baud) {
    model::Line line;
    line.name = line.port = "/dev/ttyS1";
    line.format = {.baud = baud, .data_bits = 8, .parity = wire::Parity::none, .stop_bits = 1};
    return line;
}

ScanTarget port(std::initializer_list<std::uint32_t> bauds) {
    ScanTarget target;
    for (const auto baud : bauds) target.settings.push_back(serial_line(baud));
    return target;
}

ScanTarget host(bool of_range) {
    model::Line line;
    line.name = "10.0.0.7:502";
    line.transport = model::Transport::tcp;
    line.framing = wire::Framing::tcp;
    line.port = "10.0.0.7";
    return {{line}, of_range};
}

/// Opens each line, with units that answer 0x1234 to every read, and closes it again.
class Shell {
public:
    explicit Shell(ScanTarget target, bool first_only = false) {
        TargetScan::Options options{.first_only = first_only, .on_setting_finished = [this] { ++finished; }};
        options.scan.units = {UnitId{1}, UnitId{2}, UnitId{3}};
        options.scan.identify = false;
        scan.emplace(std::move(target), std::move(options), recorder);
    }

    void begin() {
        bus::LineConfig config;
        config.framing = scan->line().framing;
        config.format = scan->line().format;
        scan->begin_setting(config);
    }

    const ScanFindings& run() {
        while (!scan->ended()) {
            begin();
            if (const auto error = open_error(scan->line())) {
                scan->on_open_failed(*error);
                continue;
            }
            scan->on_driver_link(true, {});
            scan->on_link(now, true);
            move_bytes();
            scan->end_setting();
        }
        recorder.findings.reached = scan->reached();
        recorder.findings.complete = true;
        return recorder.findings;
    }

    std::function<std::optional<Error>(const model::Line&)> open_error = [](const auto&) {
        return std::optional<Error>();
    };
    std::function<bool(const model::Line&, std::uint8_t unit)> present = [](const auto&, auto) {
        return false;
    };
    Recorder recorder;
    int finished = 0;
    std::optional<TargetScan> scan;
    Instant now{};

private:
    void move_bytes() {
        std::multimap<Instant, ByteVector> coming;
        while (!scan->setting_finished()) {
            for (Bytes out = scan->transmit(now); !out.empty(); out = scan->transmit(now))
                if (present(scan->line(), out[0])) {
                    const auto answer = wire::encode_frame(wire::Framing::rtu, UnitId{out[0]}, 0,
                                                           ByteVector{0x03, 0x02, 0x12, 0x34});
                    coming.emplace(now + 20ms, ByteVector(answer.begin(), answer.end()));
                }
            const Instant wakeup = scan->next_wakeup();
            now = std::max(now, coming.empty() ? wakeup : std::min(wakeup, coming.begin()->first));
            ASSERT_NE(now, kNever);
            if (!coming.empty() && coming.begin()->first <= now)
                scan->on_bytes(now, coming.extract(coming.begin()).mapped());
            else
                scan->on_tick(now);
        }
    }
};

TEST(TargetScan, TriesEverySettingAndReportsTheLineOfEachDevice) {
    Shell shell(port({9600, 19200, 38400}));
    shell.present = [](const model::Line& line, std::uint8_t unit) {
        return line.format.baud == 19200 && unit != 2;
    };
    const auto& findings = shell.run();
    ASSERT_EQ(findings.devices.size(), 2U);
    EXPECT_EQ(findings.devices[0].unit.unit, UnitId{1});
    EXPECT_EQ(model::settings_text(findings.devices[1].line), "19200 8N1");
    EXPECT_EQ(shell.finished, 3) << "once for each setting";
    EXPECT_EQ(shell.scan->done(), 9U);
    EXPECT_EQ(shell.scan->total(), 9U);
    EXPECT_EQ(shell.scan->requests(), 3U + (1 + 2 + 2) + 3) << "a device is asked twice";
    EXPECT_EQ(outcome_of(findings), ScanOutcome::found);
}

TEST(TargetScan, LeavesAPortAfterTheFirstSettingWithADevice) {
    Shell shell(port({9600, 19200, 38400}), true);
    shell.present = [](const model::Line& line, std::uint8_t) { return line.format.baud >= 19200; };
    EXPECT_EQ(shell.run().devices.size(), 3U);
    EXPECT_EQ(shell.scan->setting(), 3U) << "the third was not begun";
    EXPECT_EQ(shell.finished, 2);
}

TEST(TargetScan, NothingThereIsNoTrouble) {
    Shell shell(port({9600}));
    const auto& findings = shell.run();
    EXPECT_TRUE(findings.devices.empty());
    EXPECT_TRUE(findings.troubles.empty());
    EXPECT_EQ(outcome_of(findings), ScanOutcome::nothing);
}

TEST(TargetScan, ASettingThatThePortDoesNotHaveIsSkipped) {
    Shell shell(port({9600, 500000, 19200}));
    shell.open_error = [](const model::Line& line) {
        return line.format.baud == 500000
                   ? std::optional(fail(Code::unsupported, "/dev/ttyS1", 500000).error())
                   : std::nullopt;
    };
    shell.present = [](const model::Line& line, std::uint8_t unit) {
        return line.format.baud == 19200 && unit == 3;
    };
    const auto& findings = shell.run();
    ASSERT_EQ(findings.troubles.size(), 1U);
    EXPECT_EQ(findings.troubles[0].line.format.baud, 500000U);
    EXPECT_EQ(findings.devices.size(), 1U);
    EXPECT_EQ(first_failure(findings), nullptr);
    EXPECT_EQ(outcome_of(findings), ScanOutcome::found);
}

TEST(TargetScan, APortThatCannotBeOpenedIsLeft) {
    Shell shell(port({9600, 19200}));
    const auto error = fail(Code::cannot_open, "/dev/ttyS1", 13).error();
    shell.open_error = [&](const auto&) { return std::optional(error); };
    const auto& findings = shell.run();
    ASSERT_EQ(findings.troubles.size(), 1U);
    EXPECT_EQ(findings.troubles[0].error, error);
    EXPECT_EQ(outcome_of(findings), ScanOutcome::failed);
    EXPECT_EQ(*first_failure(findings), error);
}

TEST(TargetScan, AHostThatAcceptsNoConnection) {
    const auto refused = fail(Code::cannot_open, "10.0.0.7:502", 111).error();
    for (const bool of_range : {false, true}) {
        Shell shell(host(of_range));
        shell.begin();
        shell.scan->on_driver_link(false, refused);
        EXPECT_TRUE(shell.scan->setting_finished());
        EXPECT_EQ(shell.finished, 1);
        shell.scan->end_setting();
        EXPECT_TRUE(shell.scan->ended());
        EXPECT_FALSE(shell.scan->reached());
        EXPECT_EQ(shell.recorder.findings.absent_hosts, of_range ? 1U : 0U);
        EXPECT_EQ(shell.recorder.findings.troubles.size(), of_range ? 0U : 1U);
    }
}

TEST(TargetScan, AHostThatHangsUpAgainAndAgainIsLeft) {
    Shell shell(host(false));
    shell.begin();
    int lost = 0;
    for (; !shell.scan->setting_finished() && lost < 100; ++lost) {
        shell.scan->on_driver_link(true, {});
        shell.scan->on_driver_link(false, {});
    }
    EXPECT_EQ(lost, 9);
    EXPECT_TRUE(shell.scan->reached());
    ASSERT_EQ(shell.recorder.findings.troubles.size(), 1U);
    EXPECT_EQ(shell.recorder.findings.troubles[0].error, fail(Code::connection_lost, "10.0.0.7:502").error());
    shell.scan->end_setting();
    EXPECT_TRUE(shell.scan->ended());
}

TEST(TargetScan, ATargetWithoutSettingsHasEnded) {
    Shell shell({});
    EXPECT_TRUE(shell.scan->ended());
    EXPECT_EQ(shell.scan->total(), 0U);
    EXPECT_EQ(shell.scan->requests(), 0U);
}

TEST(ScanOutcome, OfDevicesFailuresAndInterruptions) {
    const ScanTrouble failure{ScanTrouble::Kind::error, {}, fail(Code::busy, "/dev/ttyS1").error(), 0};
    const ScanTrouble garbled{ScanTrouble::Kind::garbled, {}, {}, 7};
    const struct {
        bool device, failed, reached, complete;
        ScanOutcome outcome;
    } cases[] = {
        {true, false, true, true, ScanOutcome::found},    {true, true, true, true, ScanOutcome::partly},
        {false, false, true, true, ScanOutcome::nothing}, {false, true, true, true, ScanOutcome::partly},
        {false, true, false, true, ScanOutcome::failed},  {true, false, true, false, ScanOutcome::partly},
        {false, true, false, false, ScanOutcome::partly},
    };
    for (const auto& c : cases) {
        ScanFindings findings;
        findings.troubles.push_back(garbled);
        if (c.device) findings.devices.emplace_back();
        if (c.failed) findings.troubles.push_back(failure);
        findings.reached = c.reached;
        findings.complete = c.complete;
        EXPECT_EQ(outcome_of(findings), c.outcome) << c.device << c.failed << c.reached << c.complete;
    }
}

}  // namespace target_scan_test
}  // namespace takt::bus
