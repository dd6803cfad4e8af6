// Scans over lines that the test opens instead of the operating system.
#include "takt/client/port_scan.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "loop_turn.hpp"

namespace takt::client {
namespace port_scan_test {

using namespace std::chrono_literals;

struct Recorder final : bus::ScanObserver {
    void on_device(const bus::FoundDevice& device) override { devices.push_back(device); }
    void on_trouble(const bus::ScanTrouble& trouble) override { troubles.push_back(trouble); }
    void on_absent_host() override { ++absent_hosts; }
    std::vector<bus::FoundDevice> devices;
    std::vector<bus::ScanTrouble> troubles;
    int absent_hosts = 0;
};

/// A connection attempt that is not decided yet.
class PendingDriver final : public line::Driver {
public:
    void poke() override {}
    [[nodiscard]] bool up() const override { return false; }
    [[nodiscard]] const std::string& name() const override { return name_; }
    [[nodiscard]] line::DriverCounters counters() const override { return {}; }

private:
    std::string name_;
};

class PortScanTest : public testing::Test {
protected:
    PortScanTest() : loop(*line::Loop::create()) {}

    PortScan::Options options() {
        PortScan::Options options;
        options.scan.scan.units = {UnitId{1}};
        options.open = [this](line::Loop&, const model::Line& line, Engine&,
                              const line::DriverOptions& driving) -> Result<std::unique_ptr<line::Driver>> {
            opened.push_back(line.port + ' ' + std::to_string(line.format.baud));
            if (line.transport == model::Transport::serial)
                return fail(Code::unsupported, "baud", line.format.baud);
            undecided.push_back(driving.on_link);
            return std::make_unique<PendingDriver>();
        };
        return options;
    }

    /// Every host refuses its connection.
    void run(PortScans& scans) {
        while (!scans.ended()) {
            if (!loop->run_until([&] { return scans.ended() || !undecided.empty(); }, 10s)) FAIL();
            if (undecided.empty()) continue;
            const auto on_link = std::move(undecided.front());
            undecided.pop_front();
            on_link(line::now(), false, fail(Code::cannot_open, "host", ECONNREFUSED).error());
        }
    }

    std::unique_ptr<line::Loop> loop;
    Recorder recorder;
    std::vector<std::string> opened;
    std::deque<line::LinkListener> undecided;
};

TEST_F(PortScanTest, TriesEverySettingOfAPort) {
    const auto targets =
        scan_targets(std::vector<std::string>{"rtu:///dev/ttyS9"},
                     {.bauds = {9600, 19200}, .parities = {wire::Parity::none}, .stop_bits = {1}});
    ASSERT_TRUE(targets);
    ASSERT_EQ(targets->size(), 1U);
    PortScans scans(*loop, recorder);
    scans.add(targets->front(), options());
    scans.begin();
    run(scans);
    EXPECT_EQ(opened, (std::vector<std::string>{"/dev/ttyS9 9600", "/dev/ttyS9 19200"}));
    EXPECT_EQ(recorder.troubles.size(), 2U);
    EXPECT_FALSE(scans.totals().reached);
    EXPECT_EQ(scans.totals().requests, 0U);
    EXPECT_EQ(scans.current(), nullptr);
}

TEST_F(PortScanTest, ScansAtMostThirtyTwoTargetsSideBySide) {
    const auto targets = scan_targets(std::vector<std::string>{"tcp://10.0.0.1-40"}, {});
    ASSERT_TRUE(targets);
    ASSERT_EQ(targets->size(), 40U);
    PortScans scans(*loop, recorder);
    for (const auto& target : *targets) scans.add(target, options());
    EXPECT_EQ(scans.totals().total, 40U);
    scans.begin();
    loop->run_until([&] { return opened.size() == PortScans::kSideBySide; }, 10s);
    takt::test::turn(*loop, 2);
    EXPECT_EQ(opened.size(), PortScans::kSideBySide);
    EXPECT_NE(scans.current(), nullptr);
    run(scans);
    EXPECT_EQ(opened.size(), 40U);
    EXPECT_EQ(recorder.absent_hosts, 40);
}

TEST_F(PortScanTest, MakesAnObserverForEachSetting) {
    const auto targets = scan_targets(std::vector<std::string>{"rtu:///dev/ttyS9?baud=9600&parity=none"}, {});
    ASSERT_TRUE(targets);
    auto observed = options();
    std::size_t observers = 0;
    observed.traffic = [&](const model::Line&) {
        ++observers;
        return nullptr;
    };
    PortScans scans(*loop, recorder);
    scans.add(targets->front(), observed);
    scans.begin();
    run(scans);
    EXPECT_EQ(observers, opened.size());
    EXPECT_GT(observers, 0U);
}

TEST(ScanTargets, NamesEachTargetOnce) {
    const auto once = scan_targets(std::vector<std::string>{"tcp://10.0.0.1", "tcp://10.0.0.1-3"}, {});
    ASSERT_TRUE(once);
    EXPECT_EQ(once->size(), 3U);
    EXPECT_TRUE(once->back().of_range);
    EXPECT_EQ(scan_targets(std::vector<std::string>{"10.0.0.1"}, {}).error().code, Code::syntax);
}

}  // namespace port_scan_test
}  // namespace takt::client
