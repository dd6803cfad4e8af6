// A snapshot on its way: the face provides the memory, the I/O thread fills it in slices.
#pragma once

#include <memory>
#include <semaphore>

#include "engine/host_link.hpp"
#include "takt/host/snapshot.hpp"

namespace takt::host {

/// Shared by the face that waits and the I/O thread that fills it.
struct SnapshotBuffer {
    SnapshotParts parts;
    ConfigurationPtr made_for;  ///< the memory has the shape of this project
    EndpointNames endpoints;    ///< and of these endpoints
    Snapshot snapshot;
    /// Another project runs, or a list is longer than there is memory for: ask again.
    bool too_small = false;
    std::binary_semaphore ready{0};
};

/// Memory for a snapshot of `configuration`, so that filling it allocates nothing.
/// @param endpoints  HostLink::endpoint_names()
/// @param more       elements for lists whose lengths only the host knows: requests of a line beyond those of
///                   its plan, learnt ranges of a device
[[nodiscard]] std::shared_ptr<SnapshotBuffer> make_snapshot_buffer(const ConfigurationPtr& configuration,
                                                                   EndpointNames endpoints,
                                                                   const SnapshotParts& parts,
                                                                   std::size_t more);

/// `more` of the next buffer when one was too small.
[[nodiscard]] constexpr std::size_t more_memory(std::size_t more) {
    return 2 * more + 64;
}

/// Fills a buffer, a slice of bounded length for each call: one device, or the requests of one line.
class SnapshotFill final : public HostRequest {
public:
    explicit SnapshotFill(std::shared_ptr<SnapshotBuffer> buffer) : buffer_(std::move(buffer)) {}

    void serve(ProjectEngine& engine, Instant t, std::unique_ptr<HostRequest> self) override;
    void refuse(HostLink& link, std::unique_ptr<HostRequest> self) override;

    /// @returns false when the snapshot is complete
    bool fill_slice(ProjectEngine& engine, Instant t);

private:
    enum class Step : std::uint8_t { begin, locals, endpoints, devices, line, done };

    void begin(ProjectEngine& engine);
    void copy_locals(ProjectEngine& engine);
    void copy_endpoints(ProjectEngine& engine);
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
