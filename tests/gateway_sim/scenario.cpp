#include "scenario.hpp"

#include <algorithm>
#include <array>

#include "project_text.hpp"
#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/plan/plan.hpp"

namespace takt::gatewaysim {
namespace {

using namespace std::chrono_literals;
using sim::FaultKind;
using sim::Random;

/// How much goes wrong, in each part of the world by itself.
enum class Amount : std::uint8_t { none, little, much };

class ScenarioDrawer {
public:
    ScenarioDrawer(std::uint64_t seed, Duration length) : random_(Random(seed).fork(0x6A7E)) {
        made_.seed = seed;
        made_.begin = Instant{1000s};
        made_.end = made_.begin + std::max<Duration>(length, kQuiet + 10s);
        made_.quiet_from = made_.end - kQuiet;
    }

    Scenario draw() {
        read_project();
        if (!made_.error.empty()) return std::move(made_);
        draw_journal();
        draw_session();
        for (std::size_t i = 0; i < brokers_; ++i) made_.brokers.push_back(draw_broker());
        draw_means();
        draw_line_faults();
        constexpr std::array kSteps{100ms, 400ms, 2000ms};
        made_.fast_step = heavy_ ? 100ms : kSteps[random_.below(kSteps.size())];
        made_.ring_words = std::size_t{1} << (chance(40) ? 12U : 16U);
        made_.damage = chance(15);
        made_.retained_commands = chance(40);
        return std::move(made_);
    }

private:
    bool chance(std::uint32_t percent) { return random_.below(100) < percent; }
    Amount amount() {
        const auto drawn = random_.below(10);
        return drawn < 3 ? Amount::none : drawn < 8 ? Amount::little : Amount::much;
    }
    /// A mean distance; each kind is left out in a third of the runs.
    Duration mean(Amount amount, Duration least) {
        const bool left_out = random_.below(3) == 0;
        const auto drawn = random_.between(least, 3 * least);
        if (amount == Amount::none || left_out) return {};
        return amount == Amount::much ? drawn : 4 * drawn;
    }
    std::uint32_t rate(Amount amount, std::uint32_t most) {
        const bool left_out = random_.below(3) == 0;
        const auto drawn = 1 + random_.below(most);
        if (amount == Amount::none || left_out) return 0;
        return amount == Amount::much ? drawn : 1 + drawn / 8;
    }

    void read_project() {
        auto drawn = draw_project(random_.fork(1));
        made_.text = std::move(drawn.text);
        brokers_ = drawn.brokers;
        heavy_ = drawn.heavy;
        const auto loaded = file::load_text("project.yaml", made_.text);
        auto findings = loaded.findings;
        auto checked = model::interpret(loaded.document);
        findings.insert(findings.end(), checked.findings.begin(), checked.findings.end());
        for (const auto& finding : findings)
            if (finding.severity == model::Severity::error && made_.error.empty())
                made_.error = "line " + std::to_string(finding.location.line) + ": " + finding.path + ": " +
                              finding.code + " (" + finding.value + "; allowed: " + finding.allowed + ")";
        if (!made_.error.empty()) return;
        auto plan = plan::make_plan(checked.project);
        made_.configuration =
            std::make_shared<const host::Configuration>(1, std::move(checked.project), std::move(plan));
    }

    void draw_journal() {
        auto& journal = made_.journal;
        journal.segment_bytes = (64U << random_.below(3)) << 10U;
        journal.buffer_bytes = (128U << random_.below(2)) << 10U;
        journal.quota_bytes = journal.segment_bytes * (2 + random_.below(4));
        journal.sync_interval = random_.between(20ms, 300ms);
        journal.cursor_interval = random_.between(200ms, 2s);
        journal.retention = chance(50) ? Duration{} : random_.between(1s, 120s);
        constexpr std::array<std::size_t, 3> kInFlight{4, 64, 4096};
        journal.max_in_flight = kInFlight[random_.below(kInFlight.size())];
        constexpr std::array<std::size_t, 3> kQueues{std::size_t{33} << 10U, std::size_t{64} << 10U,
                                                     std::size_t{256} << 10U};
        made_.queue_bytes = kQueues[random_.below(kQueues.size())];
    }

    void draw_session() {
        const auto& output = made_.configuration->project().outputs.at(0);
        auto& session = made_.session;
        using Choice = model::MqttVersionChoice;
        session.versions = output.mqtt.version == Choice::v5       ? publish::MqttVersions::only_5
                           : output.mqtt.version == Choice::v3_1_1 ? publish::MqttVersions::only_3_1_1
                                                                   : publish::MqttVersions::automatic;
        session.window = output.mqtt.in_flight;
        session.keep_alive = 5s;
        session.connect_timeout = 4s;
        session.answer_timeout = 5s;
        session.first_pause = 500ms;
        session.longest_pause = 6s;
        session.refused_pause = 2s;
        session.taken_over_pause = 4s;
        session.stable_after = 5s;
        session.return_after = 20s;
        session.seed = random_.next();
    }

    BrokerTraits draw_broker() {
        BrokerTraits broker;
        const auto version = random_.below(10);
        const auto wanted = made_.session.versions;
        broker.speaks_5 = version < 8 || wanted == publish::MqttVersions::only_5;
        broker.speaks_3_1_1 = version < 6 || !broker.speaks_5 || wanted == publish::MqttVersions::only_3_1_1;
        broker.closes_on_5 = chance(50);
        draw_limits(broker.limits);
        broker.least_delay = random_.between(200us, 5ms);
        broker.most_delay =
            broker.least_delay + (chance(heavy_ ? 50 : 20) ? random_.between(0ms, 400ms) : 10ms);
        const auto messages = amount();
        broker.lost_puback = rate(messages, 20'000);
        broker.repeated_puback = rate(messages, 50'000);
        broker.late_puback = rate(messages, 200'000);
        broker.refused = rate(messages, 20'000);
        broker.impossible = chance(10) ? rate(messages, 10'000) : 0;
        broker.cut = rate(messages, 10'000);
        broker.repeated_command = rate(messages, 300'000);
        const auto connections = amount();
        broker.not_accepted = rate(connections, 400'000);
        broker.no_answer = rate(connections, 300'000);
        broker.cut_early = rate(connections, 300'000);
        broker.suback_fails = rate(connections, 200'000);
        broker.stale_early = chance(50) ? 1'000'000 : 0;
        return broker;
    }

    void draw_limits(publish::MqttConnected& limits) {
        if (chance(30)) limits.receive_maximum = static_cast<std::uint16_t>(1 + random_.below(20));
        if (chance(10)) limits.maximum_packet = chance(50) ? 430 : 512;
        if (chance(10)) limits.maximum_qos = static_cast<std::uint8_t>(random_.below(2));
        limits.retain_available = !chance(10);
        if (chance(10)) limits.server_keep_alive = 7;
    }

    void draw_means() {
        auto& means = made_.means;
        const auto process = amount();
        means.kill = mean(process, 15s);
        means.power_cut = mean(process, 20s);
        means.orderly_stop = mean(process, 30s);
        means.clock_jump = mean(amount(), 15s);
        const auto disk = amount();
        means.disk_fails = mean(disk, 15s);
        means.disk_full = mean(disk, 20s);
        means.disk_slow = mean(disk, 15s);
        means.single_failure = mean(disk, 5s);
        // After a stall, records are large: some of them are delivered in part when the quota takes them.
        const auto stalls = heavy_ && chance(50) ? Amount::much : amount();
        means.sampler_stalls = mean(stalls, 15s);
        means.output_stalls = mean(stalls, 15s);
        const auto brokers = heavy_ && chance(50) ? Amount::much : amount();
        means.broker_away = mean(brokers, 15s);
        means.broker_forgets = mean(brokers, 20s);
        means.half_open = mean(brokers, 15s);
        means.cut = mean(brokers, 5s);
        means.taken_over = mean(brokers, 40s);
        means.command = chance(80) ? random_.between(100ms, 3s) : Duration{};
    }

    void draw_line_faults() {
        auto& faults = made_.line_faults;
        const auto line = amount();
        for (const auto kind :
             {FaultKind::lost_request, FaultKind::lost_response, FaultKind::busy, FaultKind::bit_error})
            faults.set(kind, rate(line, 20'000));
        for (const auto kind : {FaultKind::device_dead, FaultKind::link_down, FaultKind::tcp_reset})
            faults.every(kind, mean(line, 20s));
    }

    Random random_;
    Scenario made_;
    std::size_t brokers_ = 1;
    bool heavy_ = false;
};

}  // namespace

Scenario draw_scenario(std::uint64_t seed, Duration length) {
    return ScenarioDrawer(seed, length).draw();
}

}  // namespace takt::gatewaysim
