#include "takt/publish/sample_feed.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/store/journal_record.hpp"

namespace takt::publish {
namespace {

// Names in a project have at most 255 bytes each, so an empty payload takes any sample.
constexpr std::size_t kPayloadBytes = 32'768;
static_assert(kPayloadBytes <= store::kMaxPayloadBytes);

}  // namespace

std::shared_ptr<const SeriesTable> series_of(const host::Configuration& configuration) {
    auto table = std::make_shared<SeriesTable>();
    table->reserve(configuration.slot_count());
    for (std::uint32_t i = 0; i < configuration.slot_count(); ++i) {
        const value::SlotId slot{i};
        const auto& info = configuration.info(slot);
        Series series{.variable = info.name, .type = info.type, .scaled = info.scaled};
        if (const auto* const variable = configuration.variable_of(slot)) series.unit = variable->unit;
        if (const auto* const device = configuration.device_of(slot)) series.device = device->name;
        if (const auto* const line = configuration.line_of(slot)) series.line = line->name;
        table->push_back(std::move(series));
    }
    return table;
}

SampleFeed::SampleFeed(std::shared_ptr<const SeriesTable> series, const std::vector<SelectedSlot>& selected,
                       SampleQueue& queue, Instant start)
    : series_(std::move(series)),
      selector_(selected, start),
      queue_(queue),
      payload_(kPayloadBytes),
      sink_([this](const SelectedSample& sample) { add(sample); }) {}

void SampleFeed::add(const SelectedSample& selected) {
    TAKT_ASSERT(selected.slot.value < series_->size());
    Sample sample{.series = selected.slot.value,
                  .value = selected.value,
                  .quality = selected.quality,
                  .reason = selected.reason,
                  .cause = selected.cause,
                  .wall_ns = wall_ns(selected.at)};
    if (selected.previous) sample.previous_wall_ns = wall_ns(*selected.previous);
    const auto& series = (*series_)[selected.slot.value];
    if (!payload_.add(series, sample)) {
        enqueue();
        const bool added = payload_.add(series, sample);
        TAKT_ASSERT(added);
    }
    first_wall_ns_ = payload_.samples() == 1 ? sample.wall_ns : std::min(first_wall_ns_, sample.wall_ns);
    newest_ = payload_.samples() == 1 ? selected.at : std::max(newest_, selected.at);
}

void SampleFeed::enqueue() {
    QueuedSamples queued{.payload = {},
                         .samples = payload_.samples(),
                         .first_wall_ns = first_wall_ns_,
                         .last_wall_ns = payload_.newest_wall_ns(),
                         .last_monotonic_ns = newest_.time_since_epoch().count()};
    queued.payload = payload_.take();
    wake_ = queue_.push(std::move(queued)) || wake_;
}

void SampleFeed::lose(std::uint64_t events, Instant first, Instant last) {
    if (collected()) enqueue();
    wake_ = queue_.push_loss(events, wall_ns(first), wall_ns(last)) || wake_;
}

bool SampleFeed::flush() {
    if (collected()) enqueue();
    return std::exchange(wake_, false);
}

}  // namespace takt::publish
