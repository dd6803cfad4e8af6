// Samples through a journal at a fixed rate in real time: encoded, appended, synchronised, read,
// acknowledged.
#pragma once

#include <cstddef>
#include <cstdint>

#include "../working_folder.hpp"
#include "plant.hpp"

namespace takt::bench {

struct SpeedOptions {
    std::size_t per_second = 200'000;
    std::size_t variables = 1000;
    Kind kind = Kind::floating;
    int seconds = 10;
};

struct SpeedMeasured {
    double seconds = 0;  ///< wall time
    std::uint64_t samples = 0;
    std::uint64_t delivered = 0;  ///< read in order and acknowledged
    std::uint64_t syncs = 0;      ///< of segments
    std::uint64_t disk_bytes = 0;
    // Processor time of the thread, seconds.
    double encode = 0;        ///< samples to payloads
    double write = 0;         ///< append() and on_tick(): write, sync, cursors
    double read = 0;          ///< read(), decode_samples(), acknowledge()
    double longest_tick = 0;  ///< wall time of an on_tick()
    double most_late = 0;     ///< of a collection, behind the fixed rate

    [[nodiscard]] double processor() const { return encode + write + read; }
    /// What one core would take.
    [[nodiscard]] double per_core() const { return static_cast<double>(samples) / processor(); }
};

/// Throws Failure: the journal cannot be opened, or it returned other samples than it got.
[[nodiscard]] SpeedMeasured measure_speed(const SpeedOptions& options, const WorkingFolder& folder);

}  // namespace takt::bench
