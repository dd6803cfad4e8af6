// The disk of the gateway: it fails, fills up, is slow, and survives kills and power cuts as a real one does.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "complaints.hpp"
#include "simulated_disk.hpp"
#include "takt/sim/random.hpp"
#include "takt/store/journal_storage.hpp"

namespace takt::gatewaysim {

/// Sees each operation of the disk after it was carried out, up to the one of a crash, which counts as
/// failed.
/// @param error  of the system; 0: it succeeded
class DiskObserver {
public:
    /// The program begins to read what is there.
    virtual void on_listed() = 0;
    virtual void on_create(std::uint64_t segment, int error) = 0;
    virtual void on_append(std::uint64_t segment, Bytes bytes, int error) = 0;
    virtual void on_sync(std::uint64_t segment, int error) = 0;
    virtual void on_remove(std::uint64_t segment, int error) = 0;
    virtual void on_cursor_written(Bytes bytes, int error) = 0;
    virtual void on_cursor_synced(int error) = 0;

protected:
    ~DiskObserver() = default;
};

class Disk {
public:
    enum class Mood : std::uint8_t { good, fails, full, slow };

    Disk(std::uint64_t seed, DiskObserver& observer, Complaints& complaints);

    /// A port to the disk, for one run of the program.
    [[nodiscard]] std::unique_ptr<store::JournalStorage> connect();

    void set_mood(Mood mood);
    /// Changes a byte of a record that is on the disk.
    void damage_record(std::uint64_t segment, std::uint64_t sequence);
    /// The next operation that may fail does.
    void fail_once() { fail_once_ = true; }
    /// How long the operations since the last call took.
    [[nodiscard]] Duration take_busy_time() { return std::exchange(busy_, {}); }
    /// Operations that failed so far.
    [[nodiscard]] std::uint64_t failures() const { return failures_; }

    /// The power goes, or the program is killed, at one of its next operations.
    void arm_crash(int operations) { disk_.crash_at = disk_.operations() + operations; }
    void disarm_crash() { disk_.crash_at = -1; }
    [[nodiscard]] bool crashed() const { return disk_.crashed(); }

    void kill() { disk_ = disk_.after_kill(); }
    void cut_power();
    /// Changes bytes while the power is off.
    /// @returns the segment and the offset of a changed byte; nothing: there are none
    struct Damage {
        std::uint64_t segment = 0;
        std::uint64_t offset = 0;
    };
    [[nodiscard]] std::optional<Damage> damage_segment();
    void damage_cursor(const std::string& name, bool both);

    [[nodiscard]] std::map<std::uint64_t, std::vector<std::uint8_t>> contents() const {
        return disk_.contents();
    }
    /// The bytes of a slot; empty: it was not written.
    [[nodiscard]] std::vector<std::uint8_t> cursor(const std::string& name, unsigned slot);

private:
    friend class DiskPort;

    /// Draws the fate of an operation and sets the disk up for it. @returns the number of the error; 0: good
    int prepare(bool may_fail, bool grows);
    void settle(int error);

    sim::Random random_;
    DiskObserver& observer_;
    Complaints& complaints_;
    store::test::SimulatedDisk disk_;
    Mood mood_ = Mood::good;
    std::uint32_t failing_percent_ = 100;
    std::uint64_t left_ = 0;  // bytes until it is full, in this mood
    bool fail_once_ = false;
    std::uint64_t failures_ = 0;
    Duration busy_{};
    bool has_cursor_ = false;
};

}  // namespace takt::gatewaysim
