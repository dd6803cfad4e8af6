#include "takt/console/traffic_log.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/os/open.hpp"
#include "takt/os/rotating_file.hpp"
#include "takt/report/states/traffic_text.hpp"
#include "takt/text/escape.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::console {
namespace {

constexpr unsigned kOldFiles = 3;

std::string gap_line(std::uint64_t missed) {
    return fmt::format("[{} frames were not written: the disk is full or too slow]\n", missed);
}

Result<std::unique_ptr<os::Sink>> sink_of(const std::string& path, std::size_t file_bytes,
                                          FileReports::OnError on_not_rotated) {
    struct stat status{};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
        TAKT_TRY(auto file, os::open_anew(path));
        return std::make_unique<os::DescriptorSink>(std::move(file));
    }
    return os::RotatingFile::open(path, {.file_bytes = file_bytes,
                                         .old_files = kOldFiles,
                                         .anew = true,
                                         .on_not_rotated = std::move(on_not_rotated)});
}

}  // namespace

Result<std::unique_ptr<TrafficLog>> TrafficLog::open(const std::string& path, FileReports reports,
                                                     std::size_t file_bytes, text::Language language) {
    if (path == "-")
        return std::make_unique<TrafficLog>(std::make_unique<os::DescriptorSink>(STDERR_FILENO), language);
    TAKT_TRY(auto sink, sink_of(path, file_bytes, std::move(reports.on_not_rotated)));
    return std::unique_ptr<TrafficLog>(new TrafficLog(std::move(sink), path, std::move(reports), language));
}

TrafficLog::TrafficLog(std::unique_ptr<os::Sink> sink, text::Language language)
    : TrafficLog(std::move(sink), {}, {}, language) {}

TrafficLog::TrafficLog(std::unique_ptr<os::Sink> sink, std::string path, FileReports reports,
                       text::Language language)
    : texts_(language),
      path_(std::move(path)),
      reports_(std::move(reports)),
      output_(std::move(sink), {.gap_line = gap_line, .on_failure = [this](int error) {
                                    if (!reports_.on_failed) return;
                                    reports_.on_failed(fail(Code::io_failed, path_, error).error());
                                }}) {}

TrafficLog::~TrafficLog() {
    output_.finish();
    if (reports_.on_lost && output_.error() != 0) reports_.on_lost(path_, output_.error());
}

void TrafficLog::put(std::string_view line) {
    output_.put(text::escape_line(line) + '\n');
}

void TrafficLog::put_lost(std::uint64_t count) {
    output_.put(gap_line(count));
}

LineTraffic::LineTraffic(TrafficLog& log, const model::Line& line, Side side)
    : log_(log),
      line_(line.name),
      port_(line.port),
      side_(side),
      ascii_(line.framing == wire::Framing::ascii) {
    for (const auto& device : line.devices) devices_[device.address.value] = device.name;
}

void LineTraffic::on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) {
    const bool sent = direction == wire::Direction::sent;
    const bool request = sent == (side_ == Side::master);
    const auto words = request ? words_.request(unit, pdu, raw) : words_.response(unit, pdu, raw);
    log_.put(fmt::format("[{}] TRA : {}::{}:({}) {}: {} | {}", iso_time(t), line_, name_of(unit), port_,
                         sent ? "Tx" : "Rx", bytes_text(raw),
                         text::frame_text(log_.texts().language(), words)));
}

/// ASCII without its CR LF.
std::string LineTraffic::bytes_text(Bytes raw) const {
    const bool ended = ascii_ && raw.size() > 2 && raw.back() == '\n';
    const std::string bytes = ascii_ ? std::string(raw.begin(), raw.end() - (ended ? 2 : 0)) : wire::hex(raw);
    return fmt::format("[{:04}] {}", raw.size(), bytes);
}

std::string LineTraffic::name_of(UnitId unit) const {
    const auto& name = devices_[unit.value];
    return name.empty() ? text::frame_text(log_.texts().language(), fmt::format("unit {}", unit.value))
                        : name;
}

void LineTraffic::on_fault(Instant t, wire::FrameFault fault, Bytes raw) {
    const auto& texts = log_.texts();
    log_.put(fmt::format("[{}] TRA : {}::({}) {}{}", iso_time(t), line_, port_,
                         raw.empty() ? std::string() : "Rx: " + bytes_text(raw) + " | ",
                         texts("fault.dropped", {{"reason", report::fault_text(texts, fault)}})));
}

void LineTraffic::on_incident(Instant t, UnitId unit, wire::Incident incident, Duration after,
                              const std::optional<Mismatch>& instead) {
    const bool of_line = incident == wire::Incident::connected || incident == wire::Incident::disconnected;
    log_.put(fmt::format("[{}] TRA : {}::{}({}) {}", iso_time(t), line_,
                         of_line ? std::string() : name_of(unit) + ':', port_,
                         report::incident_text(log_.texts(), incident, after, instead)));
}

line::TrafficFactory traffic_factory(TrafficLog* log, LineTraffic::Side side) {
    if (!log) return {};
    return [log, side](const model::Line& line) { return std::make_shared<LineTraffic>(*log, line, side); };
}

void TapLog::put(const host::TrafficRecord& record, const LineOf& line_of) {
    const Key key{record.generation, record.source.kind, record.source.index};
    auto source = sources_.find(key);
    if (source == sources_.end()) {
        const auto line = line_of(record);
        if (!line) return;
        const bool of_line = record.source.kind == host::TrafficSource::Kind::line;
        const auto side = of_line ? LineTraffic::Side::master : LineTraffic::Side::slave;
        source = sources_.try_emplace(key, log_, *line, side).first;
    }
    if (record.incident)
        return source->second.on_incident(record.t, record.unit, *record.incident, record.after,
                                          record.instead);
    if (record.fault) return source->second.on_fault(record.t, *record.fault, record.raw);
    source->second.on_frame(record.t, record.direction, record.unit, record.pdu, record.raw);
}

TapLogger::TapLogger(TrafficLog& log, TapSource source)
    : log_(log),
      source_(std::move(source)),
      tap_(log),
      ticker_("takt-tap", kTapPeriod, [this](bool) { turn(); }) {}

void TapLogger::turn() {
    while (const auto record = source_.next()) {
        if (const auto missed = source_.missed(); missed > missed_)
            log_.put_lost(missed - std::exchange(missed_, missed));
        tap_.put(*record, source_.line_of);
    }
}

}  // namespace takt::console
