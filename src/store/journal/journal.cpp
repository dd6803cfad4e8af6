#include "takt/store/journal.hpp"

#include <algorithm>
#include <cerrno>
#include <deque>
#include <limits>
#include <utility>

#include "journal/journal_destination.hpp"
#include "journal/journal_end.hpp"
#include "journal/journal_writer.hpp"
#include "takt/base/assert.hpp"

namespace takt::store {
namespace {

constexpr std::size_t kMaxNameBytes = 64;
constexpr Duration kCleanInterval = std::chrono::minutes(1);
constexpr Duration kSurveyInterval = std::chrono::milliseconds(20);  // 12 MB/s at most
constexpr Duration kSurveyAgain = std::chrono::seconds(1);           // after an error

bool is_in(std::uint64_t value, std::uint64_t least, std::uint64_t greatest) {
    return value >= least && value <= greatest;
}

Result<void> check(const JournalOptions& options) {
    const bool sizes = is_in(options.segment_bytes, 64U << 10, 1U << 30) &&
                       is_in(options.buffer_bytes, 128U << 10, 256U << 20) &&
                       options.quota_bytes >= 2 * std::uint64_t{options.segment_bytes};
    const bool times = options.sync_interval > Duration::zero() &&
                       options.cursor_interval > Duration::zero() && options.retention >= Duration::zero();
    if (!sizes || !times || options.max_in_flight == 0) return fail(Code::out_of_range);
    return {};
}

bool is_name(std::string_view name) {
    return is_in(name.size(), 1, kMaxNameBytes) && std::ranges::all_of(name, [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
           });
}

Result<void> check(std::span<const std::string_view> names) {
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (!is_name(names[i])) return fail(Code::malformed, names[i]);
        if (std::ranges::count(names.first(i), names[i]) != 0) return fail(Code::busy, names[i]);
    }
    return {};
}

}  // namespace

struct Journal::State {
    State(JournalStorage& port, const JournalOptions& given, RecoveredSegments recovered)
        : storage(port),
          options(given),
          writer(port, given, losses, std::move(recovered)),
          survey(writer.segments(), port, losses),
          end_file(port) {
        writer.on_quota_end([this] { save_quota_end(); });
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    void save_cursors(Instant now);
    void note_end(Instant now);
    void save_quota_end();
    [[nodiscard]] bool has_unsaved_cursor() const {
        return std::ranges::any_of(destinations, &JournalDestination::has_unsaved);
    }
    [[nodiscard]] std::uint64_t acknowledged() const;
    void clean(std::int64_t wall_ns);
    [[nodiscard]] const StreamPosition& first_waiting() const;
    void begin_survey(Instant now);
    void continue_survey(Instant now);
    [[nodiscard]] JournalDestination& at(DestinationId id) {
        TAKT_ASSERT(id.index < destinations.size());
        return destinations[id.index];
    }

    JournalStorage& storage;
    JournalOptions options;
    KnownLosses losses;
    JournalWriter writer;
    LossSurvey survey;
    JournalEndFile end_file;
    std::deque<JournalDestination> destinations;
    Instant survey_due = kNever;
    Instant cursors_due = kNever;
    Instant end_due = kNever;
    Instant clean_due = kNever;
    std::uint64_t cursor_failures = 0;
};

void Journal::State::save_cursors(Instant now) {
    cursors_due = kNever;
    for (JournalDestination& destination : destinations) {
        if (!destination.has_unsaved() || destination.save()) continue;
        ++cursor_failures;
        cursors_due = after(now, options.cursor_interval);
    }
}

// After an error the next note has it. While the disk fails, what is lost grows between two attempts.
void Journal::State::note_end(Instant now) {
    end_due = writer.failure() ? after(now, options.cursor_interval) : kNever;
    static_cast<void>(end_file.write(writer.end()));
}

// After an error it is saved with the next state of the cursor.
void Journal::State::save_quota_end() {
    for (JournalDestination& destination : destinations)
        if (destination.needs_quota_end() && !destination.save()) ++cursor_failures;
}

std::uint64_t Journal::State::acknowledged() const {
    std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
    for (const JournalDestination& destination : destinations)
        least = std::min(least, destination.durable_sequence());
    return least;
}

/// Before the oldest record that a destination has not acknowledged.
const StreamPosition& Journal::State::first_waiting() const {
    const auto position_of = [](const JournalDestination& destination) -> const StreamPosition& {
        return destination.state().position;
    };
    return position_of(*std::ranges::min_element(
        destinations, {},
        [&](const JournalDestination& destination) { return position_of(destination).sequence; }));
}

void Journal::State::begin_survey(Instant now) {
    if (destinations.empty()) return;
    survey.begin(first_waiting());
    continue_survey(now);
}

void Journal::State::continue_survey(Instant now) {
    const auto read = survey.step();
    survey_due = survey.done() ? kNever : after(now, read ? kSurveyInterval : kSurveyAgain);
}

void Journal::State::clean(std::int64_t wall_ns) {
    const auto& failure = writer.failure();
    // New records are worth more than acknowledged ones that stay for a replay.
    const bool disk_full = failure && failure->numbers[0] == ENOSPC;
    const std::int64_t retained =
        disk_full ? std::numeric_limits<std::int64_t>::max() : wall_ns - options.retention.count();
    writer.clean(acknowledged(), retained);
}

Journal::Journal(std::unique_ptr<State> state) : state_(std::move(state)) {}
Journal::Journal(Journal&&) noexcept = default;
Journal& Journal::operator=(Journal&&) noexcept = default;
Journal::~Journal() = default;

Result<Journal> Journal::open(JournalStorage& storage, const JournalOptions& options,
                              std::span<const std::string_view> destinations, Instant now,
                              std::int64_t wall_ns) {
    TAKT_CHECK(check(options));
    TAKT_CHECK(check(destinations));
    TAKT_TRY(auto recovered, recover_segments(storage));
    Journal journal(std::make_unique<State>(storage, options, std::move(recovered)));
    State& state = *journal.state_;
    StreamPosition last = state.writer.segments().durable;
    if (last.sequence == 0) last.wall_ns = wall_ns;  // no sample is older
    StreamPosition quota_end;
    for (const std::string_view name : destinations) {
        auto& added = state.destinations.emplace_back(state.writer.segments(), storage, state.losses,
                                                      std::string(name));
        TAKT_CHECK(added.load());
        if (added.state().position.sequence > last.sequence) last = added.state().position;
        if (added.state().quota_end.sequence > quota_end.sequence) quota_end = added.state().quota_end;
    }
    const auto end = state.end_file.load().value_or(std::nullopt);  // unreadable: as if it were missing
    if (end && end->durable.sequence > last.sequence) last = end->durable;
    state.writer.set_quota_end(quota_end);
    state.writer.begin_epoch(now, wall_ns, last, end);
    for (JournalDestination& destination : state.destinations) TAKT_CHECK(destination.start(last));
    state.begin_survey(now);
    state.clean_due = after(now, kCleanInterval);
    if (!end) state.note_end(now);
    return journal;
}

Result<void> Journal::append(Instant now, const JournalInput& input) {
    return state_->writer.append(now, input);
}

void Journal::append_loss(Instant now, const JournalLoss& loss) {
    JournalWriter& writer = state_->writer;
    writer.append_loss(now, {.cause = loss.buffer_full ? writer.cause_of_loss() : GapCause::source_lost,
                             .samples = loss.samples,
                             .first_wall_ns = loss.first_wall_ns,
                             .last_wall_ns = loss.last_wall_ns});
}

Instant Journal::next_wakeup() const {
    return std::min({state_->writer.next_wakeup(), state_->cursors_due, state_->end_due, state_->clean_due,
                     state_->survey_due});
}

void Journal::on_tick(Instant now, std::int64_t wall_ns) {
    State& state = *state_;
    if (now < next_wakeup()) return;
    if (now >= state.cursors_due) state.save_cursors(now);
    if (now >= state.survey_due) state.continue_survey(now);
    if (now >= state.writer.next_wakeup()) {
        state.writer.set_acknowledged(state.acknowledged());
        static_cast<void>(state.writer.flush(now));  // the writer keeps the error for the status
        state.note_end(now);
    } else if (now >= state.end_due) {
        state.note_end(now);
    }
    if (state.cursors_due == kNever && state.has_unsaved_cursor())
        state.cursors_due = after(now, state.options.cursor_interval);
    state.clean(wall_ns);
    state.clean_due = after(now, kCleanInterval);
}

Result<void> Journal::close(Instant now) {
    for (JournalDestination& destination : state_->destinations) destination.withdraw_announcement();
    state_->save_cursors(now);
    const auto flushed = state_->writer.flush(now);
    state_->note_end(now);
    if (!flushed) static_cast<void>(state_->end_file.sync());
    return flushed;
}

Result<std::optional<JournalEntry>> Journal::read(DestinationId destination) {
    return state_->at(destination).read(state_->options.max_in_flight);
}

Result<void> Journal::acknowledge(Instant now, DestinationId destination, std::uint64_t sequence) {
    TAKT_CHECK(state_->at(destination).acknowledge(sequence));
    state_->losses.forget(state_->first_waiting().samples);
    state_->cursors_due = std::min(state_->cursors_due, after(now, state_->options.cursor_interval));
    return {};
}

Result<void> Journal::reject(DestinationId destination, std::uint64_t sequence, std::uint64_t samples,
                             std::uint64_t gaps) {
    return state_->at(destination).reject(sequence, samples, gaps);
}

void Journal::rewind(DestinationId destination) {
    state_->at(destination).rewind();
}

Result<std::uint64_t> Journal::go_back(Instant now, DestinationId destination, std::uint64_t sequence) {
    TAKT_TRY(const auto entry, replay(sequence)->next());
    if (!entry) return std::uint64_t{0};
    const auto& header = entry->header;
    const StreamPosition start{.sequence = (entry->gap ? entry->gap->first_sequence : header.sequence) - 1,
                               .samples = header.samples_before,
                               .wall_ns = header.wall_ns,
                               .epoch = header.epoch};
    auto& reader = state_->at(destination);
    const auto before = reader.state().position;
    if (start.sequence >= before.sequence) return std::uint64_t{0};
    reader.go_back(start);
    state_->begin_survey(now);
    state_->cursors_due = std::min(state_->cursors_due, after(now, state_->options.cursor_interval));
    return before.samples - start.samples;
}

std::uint64_t Journal::acknowledged(DestinationId destination) const {
    return state_->at(destination).state().position.sequence;
}

std::uint64_t Journal::durable_cursor(DestinationId destination) const {
    return state_->at(destination).durable_sequence();
}

DestinationCounters Journal::counters(DestinationId destination) const {
    return state_->at(destination).counters(state_->writer.samples(), state_->writer.open_samples());
}

std::optional<std::int64_t> Journal::oldest_waiting_ns(DestinationId destination) {
    return state_->at(destination).oldest_waiting_ns();
}

std::unique_ptr<JournalStream> Journal::replay(std::uint64_t sequence) const {
    return std::make_unique<JournalReplay>(state_->writer.segments(), state_->storage, sequence);
}

std::uint64_t Journal::sequence_before(std::int64_t wall_ns) const {
    std::uint64_t sequence = 0;
    for (const Segment& segment : state_->writer.segments().segments) {
        if (!segment.start) continue;
        if (segment.start->wall_ns >= wall_ns && sequence != 0) break;
        sequence = segment.start->sequence + 1;
    }
    return sequence;
}

JournalStatus Journal::status() const {
    JournalStatus status = state_->writer.status();
    status.cursor_failures = state_->cursor_failures;
    status.set_aside = state_->storage.set_aside();
    return status;
}

}  // namespace takt::store
