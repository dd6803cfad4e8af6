// Records frames for the traffic taps of a host.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/host_link.hpp"
#include "sessions/record_codec.hpp"
#include "takt/base/inplace_string.hpp"
#include "takt/host/traffic.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::host {

/// Records the frames of one line or endpoint while a tap is open.
class TrafficPublisher final : public wire::TrafficObserver {
public:
    TrafficPublisher(HostLink& link, TrafficSource source, std::uint32_t generation)
        : link_(link), source_(source), generation_(generation) {
        record_.reserve(256);
    }
    void on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override;
    void on_fault(Instant t, wire::FrameFault fault, Bytes raw) override;
    void on_incident(Instant t, UnitId unit, wire::Incident incident, Duration after,
                     const std::optional<Mismatch>& instead) override;
    void on_peer(std::string_view peer) override { peer_.assign(peer); }

    void set_generation(std::uint32_t generation) { generation_ = generation; }
    /// Of the project that has the source now.
    void set_source(TrafficSource source, std::uint32_t generation) {
        source_ = source;
        generation_ = generation;
    }

private:
    /// @param view  without generation, source and peer
    void put(TrafficView view);

    HostLink& link_;
    TrafficSource source_;
    std::uint32_t generation_;
    InplaceString<64> peer_;
    std::vector<std::uint64_t> record_;  // scratch
};

}  // namespace takt::host
