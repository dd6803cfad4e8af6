#include "account.hpp"

#include <algorithm>
#include <ranges>
#include <utility>

namespace takt::gatewaysim {

const Unit* Run::unit_of(std::uint64_t number_in_stream) const {
    if (number_in_stream <= base) return nullptr;
    const std::uint64_t offset = number_in_stream - base - 1;
    const auto after = std::ranges::upper_bound(units, offset, {}, &Unit::offset);
    if (after == units.begin()) return nullptr;
    const Unit& unit = *(after - 1);
    return offset < unit.offset + unit.count() ? &unit : nullptr;
}

Run& Account::begin_run(Instant t) {
    Run run;
    run.number = static_cast<std::uint32_t>(runs_.size()) + 1;
    run.begin = t;
    return runs_.emplace_back(std::move(run));
}

Run* Account::run_of(std::uint64_t epoch) {
    for (Run& run : std::views::reverse(runs_))
        if (run.epoch == epoch) return &run;
    return nullptr;
}

Unit& Account::add(Unit unit) {
    Run& run = current();
    unit.offset = run.total;
    run.total += unit.count();
    return run.units.emplace_back(std::move(unit));
}

}  // namespace takt::gatewaysim
