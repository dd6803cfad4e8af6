#include "live/traffic_reader.hpp"

#include <utility>

#include "takt/report/states/traffic_text.hpp"
#include "takt/text/escape.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::web {
namespace {

constexpr std::size_t kMostSources = 4096;  // of forgotten generations too

std::string raw_text(const TrafficFrame& frame) {
    const auto& raw = frame.record.raw;
    if (!frame.ascii) return wire::hex(raw);
    return text::escape_line(std::string_view(reinterpret_cast<const char*>(raw.data()), raw.size()));
}

}  // namespace

TrafficReader::Source* TrafficReader::source_of(const host::TrafficRecord& record) {
    const Key key{record.generation, record.source.kind, record.source.index};
    if (const auto known = sources_.find(key); known != sources_.end()) return &known->second;
    const auto line = session_->line_of(record);
    if (!line) return nullptr;
    if (sources_.size() >= kMostSources) sources_.clear();
    Source source{.line = line->name, .framing = line->framing};
    for (const auto& device : line->devices) source.devices[device.address.value] = device.name;
    return &sources_.emplace(key, std::move(source)).first->second;
}

std::optional<TrafficFrame> TrafficReader::next() {
    while (auto record = session_->next_traffic()) {
        auto* const source = source_of(*record);
        if (!source) continue;
        TrafficFrame frame{.record = *std::move(record),
                           .line = source->line,
                           .ascii = source->framing == wire::Framing::ascii,
                           .mbap = source->framing == wire::Framing::tcp};
        const auto unit = frame.record.unit;
        if (const auto device = source->devices.find(unit.value); device != source->devices.end())
            frame.device = device->second;
        if (frame.record.incident) return frame;
        const bool of_line = frame.record.source.kind == host::TrafficSource::Kind::line;
        frame.request = of_line == (frame.record.direction == wire::Direction::sent);
        if (!frame.record.fault)
            frame.words = frame.request ? source->words.request(unit, frame.record.pdu, frame.record.raw)
                                        : source->words.response(unit, frame.record.pdu, frame.record.raw);
        return frame;
    }
    return std::nullopt;
}

file::Json TrafficFrame::json(const WallTime& clock, const report::Texts& texts) const {
    auto object = file::Json::object();
    object.set("t", clock.precise_ms(record.t));
    object.set("line", line);
    if (!device.empty()) object.set("device", device);
    object.set("unit", record.unit.value);
    if (record.incident) {
        object.set("incident", wire::name(*record.incident));
        if (record.after > Duration::zero())
            object.set("after_ms", record.after / std::chrono::milliseconds(1));
        if (record.instead) {
            auto instead = file::Json::object();
            instead.set("part", name(record.instead->part));
            instead.set("came", record.instead->came);
            instead.set("asked", record.instead->asked);
            object.set("instead", std::move(instead));
        }
        object.set("words", report::incident_text(texts, *record.incident, record.after, record.instead));
        return object;
    }
    object.set("direction", record.direction == wire::Direction::sent ? "tx" : "rx");
    if (!record.pdu.empty()) object.set("function", record.pdu[0] & 0x7F);
    object.set("words", record.fault ? report::fault_text(texts, *record.fault)
                                     : text::frame_text(texts.language(), words));
    object.set("raw", raw_text(*this));
    const bool exception = !record.pdu.empty() && (record.pdu[0] & 0x80) != 0;
    if (record.fault)
        object.set("fault", wire::name(*record.fault));
    else if (exception && !request)
        object.set("fault", "exception");
    return object;
}

}  // namespace takt::web
