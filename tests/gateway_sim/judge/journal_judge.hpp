// What is on the disk, and whether it had to be so.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "../clock.hpp"
#include "../complaints.hpp"
#include "../disk.hpp"
#include "../scenario.hpp"
#include "account.hpp"
#include "records.hpp"

namespace takt::gatewaysim {

/// What the broker has acknowledged, as far as the program knows.
class Deliveries {
public:
    /// @returns what must not count as delivered although the cursor is behind it; nothing: all is well
    [[nodiscard]] virtual std::optional<std::string> unfinished(std::uint64_t sequence,
                                                                std::uint64_t samples) const = 0;
    /// The stream ends after these samples: what came later never was.
    virtual void on_cut(std::uint64_t samples) = 0;
    /// The cursor is lost: the stream begins after these samples, with the oldest record. What the quota
    /// removed before is not known to anything on the disk.
    virtual void on_cursor_lost(std::uint64_t samples) = 0;

protected:
    ~Deliveries() = default;
};

class JournalJudge final : public DiskObserver {
public:
    JournalJudge(Account& account, const Clock& clock, const Scenario& scenario, Complaints& complaints)
        : account_(account), clock_(clock), scenario_(scenario), complaints_(complaints) {}
    void set_deliveries(Deliveries& deliveries) { deliveries_ = &deliveries; }

    /// The program begins with this disk. @param damaged  bytes were changed while it did not run
    void on_run_begin(Disk& disk, bool damaged);
    /// A record on the disk was changed while the program runs.
    void on_decay(std::uint64_t sequence);
    void on_pushed(Unit& unit);

    void on_listed() override;
    void on_create(std::uint64_t segment, int error) override;
    void on_append(std::uint64_t segment, Bytes bytes, int error) override;
    void on_sync(std::uint64_t segment, int error) override;
    void on_remove(std::uint64_t segment, int error) override;
    void on_cursor_written(Bytes bytes, int error) override;
    void on_cursor_synced(int error) override;

    enum class State : std::uint8_t { written, durable };
    struct Entry {
        RecordFacts facts;
        std::uint64_t segment = 0;
        State state = State::written;
        bool present = true;      ///< the disk has it, in a segment that was not removed
        bool unreadable = false;  ///< its segment is there, but its bytes changed
        bool doubtful = false;    ///< the sync of its segment failed
    };
    /// nullptr: there is no such record
    [[nodiscard]] const Entry* record(std::uint64_t sequence) const;
    /// The record with this sample, or with this sample after it if it has none; nullptr: there is none.
    [[nodiscard]] const Entry* record_of_sample(std::uint64_t number) const;
    [[nodiscard]] std::uint64_t last_sequence() const { return entries_.size(); }
    /// Whether the segment of a record had bytes that are no record when the run began.
    [[nodiscard]] bool is_torn(std::uint64_t sequence) const {
        return record(sequence) != nullptr && torn_.contains(record(sequence)->segment);
    }
    /// Samples of the stream that are durable.
    [[nodiscard]] std::uint64_t durable_samples() const { return durable_samples_; }
    [[nodiscard]] std::uint64_t durable_sequence() const { return durable_sequence_; }
    /// The disk was damaged in this or an earlier run.
    [[nodiscard]] bool was_damaged() const { return damaged_; }

private:
    void find_recovered();
    void take(const ReadRecord& record, std::uint64_t segment);
    void begin_epoch(const RecordFacts& first);
    void check_restart(const RecordFacts& first);
    void check_samples(const RecordFacts& facts, Bytes payload);
    void check_gap(const RecordFacts& facts);
    void check_cause(const RecordFacts& facts, const Unit& first, bool could_fit);
    void check_removal(std::uint64_t segment);
    void note_kept();
    void note_state(std::uint16_t cause);
    void fail(std::string_view rule, std::string expected, std::string seen) {
        complaints_.add(rule, clock_.now, std::move(expected), std::move(seen));
    }

    Account& account_;
    const Clock& clock_;
    const Scenario& scenario_;
    Complaints& complaints_;
    Deliveries* deliveries_ = nullptr;

    std::vector<Entry> entries_;                       // by sequence number, from 1 on
    std::map<std::uint64_t, std::uint64_t> segments_;  // number to bytes
    std::set<std::uint64_t> torn_;                     // with other bytes than records
    std::uint64_t durable_sequence_ = 0;
    std::uint64_t durable_samples_ = 0;
    std::uint64_t kept_sequence_ = 0;  // durable without a doubt
    std::uint64_t kept_samples_ = 0;
    std::uint64_t recovered_ = 0;  // the last record that was on the disk when the run began
    CursorFacts cursor_;           // durable
    CursorFacts written_cursor_;   // not synchronised
    bool damaged_ = false;
    bool cursor_damaged_ = false;
    std::size_t durable_units_ = 0;        // of the current run
    std::uint64_t not_durable_bytes_ = 0;  // likewise
    /// Why a full buffer would be full, from an instant on.
    std::vector<std::pair<Instant, std::uint16_t>> states_{{Instant{}, kBufferFull}};
};

}  // namespace takt::gatewaysim
