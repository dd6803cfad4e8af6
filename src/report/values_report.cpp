#include "takt/report/values_report.hpp"

#include <algorithm>
#include <cstdint>

#include "takt/report/event_report.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/text_table.hpp"

namespace takt::report {
namespace {

constexpr std::size_t kOtherRows = 3;  // of the screen: the heading, hidden rows, and the cursor
constexpr std::size_t kLeastRows = 6;  // of a screen

std::vector<std::string> row(const Texts& texts, const host::Snapshot& snapshot, value::SlotId id) {
    const auto& configuration = *snapshot.configuration;
    const auto& slot = snapshot.values[id.value];
    const auto& info = configuration.info(id);
    const bool aged = !info.local && slot.good_at;
    return {device_name(configuration, id), info.name, value_text(configuration, id, slot.value),
            aged ? milliseconds_text(std::max(Duration{}, snapshot.t - *slot.good_at)) : "",
            slot.quality == value::Quality::good ? "" : texts.quality(slot.quality, slot.reason)};
}

}  // namespace

std::vector<std::string> values_table(const Texts& texts, const host::Snapshot& snapshot,
                                      const Screen& screen) {
    using enum TextTable::Align;
    TextTable table({left, left, right, right, left});
    table.add({texts("app.device"), texts("app.variable"), texts("app.value"), texts("app.age"), ""});
    const std::size_t all = snapshot.values.size();
    const std::size_t most = std::max(screen.rows, kLeastRows) - kOtherRows;
    const std::size_t shown = all <= most ? all : most - 1;
    for (std::uint32_t id = 0; id < shown; ++id) table.add(row(texts, snapshot, {id}));
    auto lines = table.lines(screen.columns - 1);
    if (all > shown) lines.push_back(texts("app.more_rows", {{"count", std::to_string(all - shown)}}));
    return lines;
}

}  // namespace takt::report
