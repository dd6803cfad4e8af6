#include "journal/journal_writer.hpp"

#include <algorithm>
#include <cerrno>
#include <utility>

namespace takt::store {
namespace {

constexpr Duration kFirstBackOff = std::chrono::milliseconds(100);
constexpr Duration kLongestBackOff = std::chrono::seconds(5);
constexpr std::size_t kLongestWrite = 1U << 20;
constexpr std::ptrdiff_t kMostEmptySegments = 4;

// A journal that begins again after its files were removed must not use the numbers of the former one: a
// receiver drops a pair of epoch and number that it knows. Starts are rarer than one a second.
std::uint64_t first_epoch(std::int64_t wall_ns) {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(1, wall_ns / 1'000'000'000));
}

}  // namespace

JournalWriter::JournalWriter(JournalStorage& storage, const JournalOptions& options, KnownLosses& losses,
                             RecoveredSegments recovered)
    : storage_(&storage),
      losses_(&losses),
      options_(options),
      list_(std::move(recovered.list)),
      next_number_(recovered.next_number),
      torn_bytes_(recovered.torn_bytes),
      end_(list_.durable) {}

void JournalWriter::begin_epoch(Instant now, std::int64_t wall_ns, const StreamPosition& last,
                                const std::optional<JournalEnd>& end) {
    // A cursor ahead of the segments shows that durable records were lost: their numbers are not used again.
    if (last.sequence > end_.sequence) end_ = list_.durable = last;
    epoch_ = end_.sequence == 0 ? first_epoch(wall_ns) : end_.epoch + 1;
    if (end && end->samples > end_.samples)
        push_gap({.cause = end->cause,
                  .samples = end->samples - end_.samples,
                  .first_wall_ns = end->first_wall_ns,
                  .last_wall_ns = end->last_wall_ns});
    const std::int64_t first = end_.sequence == 0 ? wall_ns : end_.wall_ns;
    push_gap({.cause = options_.start, .first_wall_ns = first, .last_wall_ns = wall_ns});
    schedule(now);
}

Result<void> JournalWriter::append(Instant now, const JournalInput& input) {
    if (input.payload.size() > kMaxPayloadBytes)
        return fail(Code::too_long, static_cast<std::int64_t>(input.payload.size()), kMaxPayloadBytes);
    const std::size_t gap = open_gap_ ? kGapRecordBytes : 0;
    if (!has_room(gap + kRecordOverheadBytes + input.payload.size())) {
        append_loss(now, {.cause = cause_of_loss(),
                          .samples = input.samples,
                          .first_wall_ns = input.oldest_wall_ns.value_or(input.wall_ns),
                          .last_wall_ns = input.wall_ns});
        return fail(Code::queue_full, static_cast<std::int64_t>(options_.buffer_bytes));
    }
    close_gap();
    push({RecordType::samples, input.samples, end_.sequence + 1, end_.samples, input.wall_ns,
          input.monotonic_ns, epoch_},
         input.payload);
    schedule(now);
    return {};
}

void JournalWriter::append_loss(Instant now, const Gap& gap) {
    counts_.samples_lost += gap.samples;
    if (open_gap_ && open_gap_->cause != gap.cause && has_room(2 * kGapRecordBytes)) close_gap();
    if (!open_gap_) {
        open_gap_ = gap;
    } else {
        open_gap_->samples += gap.samples;
        open_gap_->first_wall_ns = std::min(open_gap_->first_wall_ns, gap.first_wall_ns);
        open_gap_->last_wall_ns = std::max(open_gap_->last_wall_ns, gap.last_wall_ns);
    }
    schedule(now);
}

// Without a failure a kill loses what was accepted since the last sync; the gap `restart` stands for it.
JournalEnd JournalWriter::end() const {
    JournalEnd end{.durable = list_.durable, .samples = list_.durable.samples};
    if (!failure_ || samples() == end.samples) return end;
    end.samples = samples();
    end.cause = cause_of_loss();
    end.first_wall_ns = pending_.empty() ? open_gap_->first_wall_ns : encoded_header(pending_).wall_ns;
    end.last_wall_ns = open_gap_ ? open_gap_->last_wall_ns : end_.wall_ns;
    end.first_wall_ns = std::min(end.first_wall_ns, end.last_wall_ns);
    return end;
}

void JournalWriter::push(const RecordHeader& header, Bytes payload) {
    encode_record(header, payload, pending_);
    end_ = end_of(header);
}

void JournalWriter::push_gap(const Gap& gap) {
    Gap numbered = gap;
    numbered.first_sequence = numbered.last_sequence = end_.sequence + 1;
    std::vector<std::uint8_t> payload;
    encode_gap(numbered, payload);
    losses_->add(end_.samples, gap.samples, gap.cause);
    push({RecordType::gap, gap.samples, end_.sequence + 1, end_.samples, gap.last_wall_ns, 0, epoch_},
         payload);
}

void JournalWriter::close_gap() {
    if (open_gap_) push_gap(*open_gap_);
    open_gap_.reset();
}

GapCause JournalWriter::cause_of_loss() const {
    if (!failure_) return GapCause::buffer_full;
    return failure_->numbers[0] == ENOSPC ? GapCause::disk_full : GapCause::disk_failed;
}

void JournalWriter::schedule(Instant now) {
    if (failure_) return;  // the time of the next attempt is set
    const bool urgent = pending_.size() >= options_.buffer_bytes / 2;
    due_ = std::min(due_, urgent ? now : after(now, options_.sync_interval));
}

Result<void> JournalWriter::flush(Instant now) {
    due_ = kNever;
    // While the disk fails the gap stays open, and takes what is lost next.
    if (open_gap_ && !failure_ && has_room(kGapRecordBytes)) close_gap();
    const auto written = write_pending();
    if (!written) {
        abandon(now, written.error());
        return written;
    }
    failure_.reset();
    back_off_ = {};
    if (open_gap_) schedule(now);
    return {};
}

Result<void> JournalWriter::write_pending() {
    while (written_ < pending_.size()) {
        if (!has_active_) TAKT_CHECK(open_segment());
        TAKT_CHECK(write_slice());
    }
    return sync();
}

/// Writes as many whole records as fit the active segment, or closes it.
Result<void> JournalWriter::write_slice() {
    const Bytes rest = Bytes(pending_).subspan(written_);
    const std::uint64_t room = active().limit - std::min(active().limit, active().bytes);
    const std::size_t limit = std::min<std::uint64_t>(room, kLongestWrite);
    std::size_t slice = 0;
    std::size_t last = 0;
    while (slice < rest.size() && slice + encoded_size(rest.subspan(slice)) <= limit) {
        last = slice;
        slice += encoded_size(rest.subspan(slice));
    }
    if (slice == 0) {
        TAKT_CHECK(sync());
        has_active_ = false;
        return {};
    }
    active().bytes += slice;  // after an error too: some of it may be there
    TAKT_CHECK(storage_->append(active().number, rest.first(slice)));
    if (!written_first_) written_first_ = encoded_header(rest);
    written_last_ = encoded_header(rest.subspan(last));
    written_ += slice;
    return {};
}

Result<void> JournalWriter::open_segment() {
    TAKT_CHECK(limit_empty_segments());
    make_room_on_disk();
    const std::uint64_t number = next_number_++;
    list_.segments.push_back({.number = number});
    has_active_ = true;
    TAKT_TRY(const auto limit, storage_->create(number));
    active().limit = std::min<std::uint64_t>(limit, options_.segment_bytes);
    return {};
}

Result<void> JournalWriter::sync() {
    if (written_ == 0) return {};
    TAKT_CHECK(storage_->sync(active().number));
    ++counts_.syncs;
    active().readable = active().bytes;
    if (!active().start) active().start = start_of(*written_first_);
    list_.durable = end_of(*written_last_);
    pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(written_));
    written_ = 0;
    written_first_.reset();
    return {};
}

/// The content of the segment is unknown from its last sync on: another segment takes those records again.
void JournalWriter::abandon(Instant now, const Error& error) {
    ++counts_.write_failures;
    failure_ = error;
    has_active_ = false;
    written_ = 0;
    written_first_.reset();
    back_off_ = std::clamp(back_off_ * 2, kFirstBackOff, kLongestBackOff);
    due_ = after(now, back_off_);
}

/// A disk that neither writes nor removes must not get another file with each attempt.
Result<void> JournalWriter::limit_empty_segments() {
    const auto is_empty = [](const Segment& segment) { return !segment.start; };
    if (std::ranges::count_if(list_.segments, is_empty) < kMostEmptySegments) return {};
    const auto first = std::ranges::find_if(list_.segments, is_empty);
    TAKT_CHECK(storage_->remove(first->number));
    list_.segments.erase(first);
    return {};
}

void JournalWriter::make_room_on_disk() {
    std::size_t index = 0;
    while (list_.total_bytes() + options_.segment_bytes > options_.quota_bytes &&
           index < list_.segments.size()) {
        const Segment segment = list_.segments[index];
        const StreamPosition end = list_.end_of_segment(segment);
        // The last record stays: its number is the reason why the next start does not use it again.
        const bool is_last = segment.start && end.sequence == list_.durable.sequence;
        const bool drops = segment.start && !is_last && end.sequence > acknowledged_;
        if (drops) announce_drop(end);
        if (is_last || !remove(index)) {
            ++index;
        } else if (drops) {
            ++counts_.dropped_segments;
            losses_->add(segment.start->samples, end.samples - segment.start->samples, GapCause::quota);
        }
    }
}

void JournalWriter::announce_drop(const StreamPosition& end) {
    if (end.sequence <= list_.quota_end.sequence) return;
    list_.quota_end = end;
    if (save_quota_end_) save_quota_end_();
}

bool JournalWriter::remove(std::size_t index) {
    if (!storage_->remove(list_.segments[index].number)) {
        ++counts_.remove_failures;
        return false;
    }
    list_.segments.erase(list_.segments.begin() + static_cast<std::ptrdiff_t>(index));
    return true;
}

void JournalWriter::clean(std::uint64_t acknowledged, std::int64_t wall_ns) {
    const std::size_t kept = has_active_ ? 1 : 0;
    for (std::size_t i = list_.segments.size() - std::min(kept, list_.segments.size()); i-- > 0;)
        if (!list_.segments[i].start) static_cast<void>(remove(i));
    while (const Segment* first = list_.first()) {
        const StreamPosition end = list_.end_of_segment(*first);
        const bool is_last = end.sequence == list_.durable.sequence;
        if (is_last || end.sequence > acknowledged || end.wall_ns > wall_ns) return;
        if (!remove(static_cast<std::size_t>(first - list_.segments.data()))) return;
    }
}

JournalStatus JournalWriter::status() const {
    JournalStatus status = counts_;
    status.failure = failure_;
    status.samples = samples();
    status.last_sequence = end_.sequence;
    status.durable_sequence = list_.durable.sequence;
    status.epoch = epoch_;
    status.disk_bytes = list_.total_bytes();
    status.segments = list_.segments.size();
    status.buffer_bytes = pending_.size();
    status.buffer_samples = samples() - list_.durable.samples;
    status.torn_bytes = torn_bytes_;
    return status;
}

}  // namespace takt::store
