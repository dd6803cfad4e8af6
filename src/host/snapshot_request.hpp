// A snapshot on its way: the face provides the memory, the I/O thread fills it in slices.
#pragma once

#include <memory>
#include <semaphore>

#include "host_link.hpp"
#include "takt/host/snapshot.hpp"

namespace takt::host {

/// Shared by the face that waits and the I/O thread that fills it.
struct SnapshotBuffer {
    SnapshotParts parts;
    Snapshot snapshot;
    bool too_small = false;  ///< the running plan has more requests than there is memory for
    std::binary_semaphore ready{0};
};

/// Memory for a snapshot of `configuration`, so that filling it allocates nothing.
/// @param more_requests  for each line, beyond those of its plan
[[nodiscard]] std::shared_ptr<SnapshotBuffer> make_snapshot_buffer(const ConfigurationPtr& configuration,
                                                                   const SnapshotParts& parts,
                                                                   std::size_t more_requests);

/// Fills a buffer, a slice of bounded length for each call: one device, or the requests of one line.
class SnapshotFill final : public HostRequest {
public:
    explicit SnapshotFill(std::shared_ptr<SnapshotBuffer> buffer) : buffer_(std::move(buffer)) {}

    void serve(ProjectEngine& engine, Instant t, std::unique_ptr<HostRequest> self) override;
    void refuse(HostLink& link, std::unique_ptr<HostRequest> self) override;

    /// @returns false when the snapshot is complete
    bool fill_slice(ProjectEngine& engine, Instant t);

private:
    enum class Step : std::uint8_t { begin, locals, devices, line, done };

    void begin(ProjectEngine& engine);
    void copy_locals(ProjectEngine& engine);
    void copy_device(ProjectEngine& engine);
    void copy_line(ProjectEngine& engine, Instant t);
    void copy_slot(ProjectEngine& engine, value::SlotId slot);

    std::shared_ptr<SnapshotBuffer> buffer_;
    Step step_ = Step::begin;
    std::size_t line_ = 0;
    std::size_t device_ = 0;
    std::size_t variable_ = 0;  // of the line: the first of the device
};

}  // namespace takt::host
