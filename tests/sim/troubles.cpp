#include "troubles.hpp"

#include <algorithm>
#include <array>

namespace takt::simtest {
namespace {

using namespace std::chrono_literals;
using sim::FaultKind;

/// Of a million answers of one device in three: one answer in 400, in 40, or in 4 is late.
constexpr std::array kLate{2'500U, 25'000U, 250'000U};

sim::FaultRates rates(const model::Line& model, const Run& settings, std::size_t line) {
    auto random = sim::Random(settings.seed).fork(0xFA + line);
    auto kind = settings.faults.kind;
    const auto drawn = random.below(20);
    if (kind == FaultChoice::Kind::by_seed)
        kind = drawn < 3    ? FaultChoice::Kind::none
               : drawn < 12 ? FaultChoice::Kind::few
                            : FaultChoice::Kind::many;
    if (kind == FaultChoice::Kind::none) return {};
    if (kind == FaultChoice::Kind::given) return settings.faults.rates;
    const bool many = kind == FaultChoice::Kind::many;
    sim::FaultRates made;
    for (std::size_t i = 0; i < sim::kFaultKinds; ++i) {
        const auto fault = static_cast<FaultKind>(i);
        if (is_close(fault)) continue;  // see add_closes()
        const bool left_out = random.below(3) == 0;
        const auto rate = many ? 1000 + random.below(9000) : 100 + random.below(900);
        const auto mean = random.between(many ? 20s : 100s, many ? 120s : 600s);
        const bool misleads = fault == FaultKind::past_response || fault == FaultKind::duplicate_response;
        const bool spared = misleads && !settings.merciless;
        if (left_out || spared || !possible(fault, model.framing, model.is_serial())) continue;
        if (is_timed(fault))
            made.every(fault, mean);
        else
            made.set(fault, fault == FaultKind::connect_refused ? 300'000 : rate);
    }
    return made;
}

// Half of the servers end their connections, in one way or in all of them. Drawn by itself.
void add_closes(sim::FaultRates& rates, const model::Line& model, const Run& settings, std::size_t line) {
    using Kind = FaultChoice::Kind;
    auto random = sim::Random(settings.seed).fork(0xC105 + line);
    if (model.is_serial() || settings.faults.kind == Kind::given || settings.faults.kind == Kind::none)
        return;
    const auto way = random.below(10);
    const bool all = way == 4;
    if (way == 0 || all) rates.set(FaultKind::close_after_response, all ? 50'000 : 1'000'000);
    if (way == 1 || all) rates.set(FaultKind::close_at_random, 2'000 + random.below(60'000));
    if (way == 2 || all) rates.set(FaultKind::close_on_request, 50'000 + random.below(200'000));
    if (way == 3 || all) rates.every(FaultKind::close_when_idle, random.between(100ms, 5s));
}

// Drawn by itself, so that all else stays as without it.
void add_lateness(sim::FaultPlan& plan, const model::Line& model, const Run& settings, std::size_t line) {
    auto random = sim::Random(settings.seed).fork(0x1A7E + line);
    const auto kind = settings.faults.kind;
    for (std::size_t d = 0; d < model.devices.size(); ++d) {
        plan.out_of_order.push_back(random.below(3) == 0);
        const bool late = random.below(3) == 0;
        const auto rate = kLate[random.below(kLate.size())];
        plan.devices.push_back(plan.rates);
        const auto without = static_cast<std::size_t>(FaultKind::late_response);
        if (kind == FaultChoice::Kind::given || plan.rates.per_million[without] == 0) continue;
        if (late) plan.devices.back().set(FaultKind::late_response, rate);
    }
}

}  // namespace

Adapter adapter_of(const model::Line& line, std::uint64_t seed, std::size_t index) {
    constexpr std::array<std::size_t, 4> kChunks{1, 3, 8, 14};
    auto random = sim::Random(seed).fork(0xEC00 + index);
    Adapter adapter;
    if (!line.is_serial()) return adapter;
    adapter.echoes = random.below(6) == 0;
    if (random.below(6) == 0) adapter.chunk = kChunks[random.below(kChunks.size())];
    return adapter;
}

sim::FaultPlan fault_plan(const model::Project& project, const Run& settings, std::size_t line,
                          Instant quiet_from) {
    const model::Line& modelled = project.lines[line];
    auto random = sim::Random(settings.seed).fork(0xFB + line);
    sim::FaultPlan plan;
    plan.seed = random.next();
    plan.rates = rates(modelled, settings, line);
    add_closes(plan.rates, modelled, settings, line);
    plan.merciless = settings.merciless;
    if (settings.merciless) add_lateness(plan, modelled, settings, line);
    plan.dead = {1s, 20s};
    const bool several =
        modelled.framing == wire::Framing::tcp &&
        std::ranges::any_of(modelled.devices, [](const auto& each) { return each.in_flight > 1; });
    plan.derive_timeouts = project.derive_timeouts && !several;
    plan.timeout_margin = project.timeout_margin;
    plan.quiet_from = quiet_from;
    for (const auto& device : modelled.devices) {
        const Duration most = modelled.is_serial() ? device.turnaround.value_or(5ms) : device.round_trip;
        const auto shape = static_cast<sim::Turnaround::Shape>(random.below(3));
        const Duration least = shape == sim::Turnaround::Shape::constant ? most : most / 4;
        plan.turnarounds.emplace_back(sim::Turnaround{shape, least, most});
    }
    return plan;
}

}  // namespace takt::simtest
