// Frames of lines and listeners that work without a host.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "takt/host/broadcast_ring.hpp"
#include "takt/host/traffic.hpp"
#include "takt/line/traffic_factory.hpp"
#include "takt/model/line.hpp"

namespace takt::host {

class HostLink;

/// A ring of frames: observers write on their thread and never wait, readers read on others. When the ring is
/// full the oldest frames are overwritten; each reader counts those that it missed.
class TrafficTap {
public:
    TrafficTap();
    ~TrafficTap();
    TrafficTap(const TrafficTap&) = delete;
    TrafficTap& operator=(const TrafficTap&) = delete;

    /// Makes observers of listeners; the tap outlives them. All observers work on one thread.
    [[nodiscard]] line::TrafficFactory factory();

    /// Reads from the begin on. One thread at a time uses a reader. It may outlive the tap.
    class Reader {
    public:
        [[nodiscard]] std::optional<TrafficRecord> next();
        [[nodiscard]] std::uint64_t missed() const { return cursor_.missed; }
        [[nodiscard]] std::optional<model::Line> line_of(const TrafficRecord& record) const;

    private:
        friend class TrafficTap;
        explicit Reader(std::shared_ptr<const HostLink> link);

        std::shared_ptr<const HostLink> link_;
        BroadcastRing::Cursor cursor_;
        std::vector<std::uint64_t> record_;  // scratch
    };
    [[nodiscard]] Reader reader() const { return Reader(link_); }

private:
    std::shared_ptr<HostLink> link_;
};

}  // namespace takt::host
