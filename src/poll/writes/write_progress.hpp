// The steps of a write.
#pragma once

#include <cstdint>

#include "takt/base/assert.hpp"

namespace takt::poll {

enum class WritePhase : std::uint8_t {
    queued,       ///< no step was begun
    reading_old,  ///< of a read-modify-write: until its write is submitted
    writing,
    verifying,  ///< the device confirmed the write; it is read back and compared
};

/// Where one write is: of a group, or of a command.
///
///     queued ─ begin() ─ reading_old ─ write() ─ writing ─ verify() ─ verifying
///
/// end() leads back to `queued` from everywhere: the write is settled, or waits to be repeated.
class WriteProgress {
public:
    [[nodiscard]] WritePhase phase() const { return phase_; }
    [[nodiscard]] bool queued() const { return phase_ == WritePhase::queued; }
    /// A transaction of it was submitted and has not ended.
    [[nodiscard]] bool in_flight() const { return in_flight_; }
    /// Its read-back is the next step.
    [[nodiscard]] bool awaits_read_back() const { return phase_ == WritePhase::verifying && !in_flight_; }
    /// A transaction of it may be submitted, other than the second one of a read-modify-write.
    [[nodiscard]] bool may_start() const { return queued() || awaits_read_back(); }

    void begin(bool reads_first) {
        TAKT_ASSERT(queued());
        enter(reads_first ? WritePhase::reading_old : WritePhase::writing, true);
    }
    /// The register was read; its write is submitted.
    void write() {
        TAKT_ASSERT(phase_ == WritePhase::reading_old && !in_flight_);
        enter(WritePhase::writing, true);
    }
    void verify() {
        TAKT_ASSERT(phase_ == WritePhase::writing);
        enter(WritePhase::verifying, false);
    }
    void read_back() {
        TAKT_ASSERT(awaits_read_back());
        in_flight_ = true;
    }
    void transaction_ended() { in_flight_ = false; }
    void end() { enter(WritePhase::queued, false); }

private:
    void enter(WritePhase phase, bool in_flight) {
        phase_ = phase;
        in_flight_ = in_flight;
    }

    WritePhase phase_ = WritePhase::queued;
    bool in_flight_ = false;
};

}  // namespace takt::poll
