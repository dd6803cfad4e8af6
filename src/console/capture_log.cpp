#include "takt/console/capture_log.hpp"

#include <algorithm>
#include <utility>

#include "takt/line/loop.hpp"

namespace takt::console {
namespace {

constexpr Duration kSettle = std::chrono::milliseconds(100);
constexpr std::size_t kChunk = 256 << 10;       // bytes of one write
constexpr std::size_t kMostOfPacket = 4 << 10;  // headers, names, comment and end of the file
constexpr int kMostRecords = 1'000'000;         // in a tick
constexpr std::size_t kMostPending = 100'000;

std::int64_t wall_offset_ns() {
    return std::chrono::duration_cast<Duration>(line::wall_clock({}).time_since_epoch()).count();
}

}  // namespace

CaptureLog::CaptureLog(CaptureFile file, TapSource source, FileReports reports)
    : source_(std::move(source)),
      reports_(std::move(reports)),
      file_(std::move(file)),
      capture_(source_.line_of, source_.overheard) {
    capture_.frames().begin_file(blocks_);
    ticker_.emplace("takt-tap", kTapPeriod, [this](bool ending) { turn(ending); });
}

CaptureLog::~CaptureLog() {
    ticker_.reset();
    if (reports_.on_lost && error_ != 0) reports_.on_lost(file_.path(), error_);
}

void CaptureLog::turn(bool ending) {
    take_all();
    add_settled(ending ? kNever : line::now() - kSettle);
    flush();
    if (!ending) return;
    const auto now_ns = wall_offset_ns() + line::now().time_since_epoch().count();
    capture_.frames().end_file(now_ns, blocks_);
    flush();
}

void CaptureLog::take_all() {
    offset_ns_ = wall_offset_ns();
    for (int count = 0; count < kMostRecords; ++count) {
        auto record = source_.next();
        if (const auto missed = source_.missed(); missed > missed_)
            capture_.frames().add_loss(missed - std::exchange(missed_, missed));
        if (!record) return;
        if (record->incident) continue;
        record->t = capture_.end_of(*record);
        pending_.push_back(*std::move(record));
        if (pending_.size() >= kMostPending) add_settled(kNever);
    }
}

void CaptureLog::add_settled(Instant until) {
    std::ranges::stable_sort(pending_, {}, &host::TrafficRecord::t);
    const auto end = std::ranges::upper_bound(pending_, until, {}, &host::TrafficRecord::t);
    std::for_each(pending_.begin(), end, [this](const auto& record) { add(record); });
    pending_.erase(pending_.begin(), end);
}

// A file ends before the packet that might not fit, because its interfaces are written with their packets.
void CaptureLog::add(const host::TrafficRecord& record) {
    const std::size_t longest = kMostOfPacket + 5 * record.raw.size() + record.pdu.size();
    if (in_file_ > 0 && file_.is_full(blocks_.size() + longest)) rotate();
    last_ns_ = record.t.time_since_epoch().count() + offset_ns_;
    capture_.add(record, last_ns_, blocks_);
    ++frames_;
    ++in_file_;
    if (blocks_.size() >= kChunk) flush();
}

void CaptureLog::rotate() {
    capture_.frames().end_file(last_ns_, blocks_);
    flush();
    const auto rotated = file_.rotate();
    const bool failed_before = std::exchange(rotation_failed_, !rotated);
    if (!rotated && !failed_before && reports_.on_not_rotated) reports_.on_not_rotated(rotated.error());
    blocks_.clear();
    in_file_ = 0;
    capture_.frames().begin_file(blocks_);
}

// Interfaces are lost with the packets: after a failure the file goes on with another section. That it fits
// does not end the failure.
void CaptureLog::flush() {
    if (blocks_.empty()) return;
    const auto written = file_.write(blocks_);
    blocks_.clear();
    const auto frames = std::exchange(frames_, 0);
    if (written) {
        failing_ = failing_ && frames == 0;
        return;
    }
    note(written.error());
    capture_.frames().begin_file(blocks_);
    capture_.frames().add_loss(frames);
}

void CaptureLog::note(const Error& error) {
    if (error_ == 0) error_ = static_cast<int>(error.numbers[0]);
    if (!std::exchange(failing_, true) && reports_.on_failed) reports_.on_failed(error);
}

}  // namespace takt::console
