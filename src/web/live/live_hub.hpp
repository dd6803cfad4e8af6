// The live values for all browsers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "live/live_values.hpp"
#include "live/stream_hub.hpp"
#include "takt/web/host_access.hpp"

namespace takt::web {

/// GET /stream: the events of one session of the host. Changes of values and the instants of reads at most
/// each kTick, the state each second. A stream whose browser is too slow loses its place in the ring and gets
/// a new snapshot. Without streams there is no session.
class LiveHub final : public StreamHub {
public:
    static constexpr std::size_t kFrames = 256;

    /// @param frames  in the ring
    LiveHub(HostAccess host, std::function<void()> poke, std::size_t frames = kFrames);
    ~LiveHub() override;

private:
    struct Ring;

    void tick() override;
    void close() override;
    void connect();
    void read_events();
    void take_state(Instant now);
    void begin_configuration(bool announced);
    void put_notice(const host::Event& event);
    void make_list();

    explicit LiveHub(HostAccess host, std::function<void()> poke, std::shared_ptr<Ring> ring);

    HostAccess host_;
    std::shared_ptr<Ring> ring_;
    std::unique_ptr<host::Session> session_;  // of the thread, as all below
    std::optional<LiveValues> values_;
    std::uint64_t missed_ = 0;
    int notices_ = 0;  // of this tick
    Instant next_second_;
};

/// "info", "warning" or "error"
[[nodiscard]] std::string_view severity_of(const host::Event& event);

/// The object of GET /status: report::status_json() with `outputs`.
/// @param snapshot  with values and statistics
[[nodiscard]] file::Json status_object(const report::Texts& texts, const host::Snapshot& snapshot,
                                       const HostAccess& host);

}  // namespace takt::web
