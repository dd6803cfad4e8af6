// Which items of each area a device has: range probes of its areas over any connection.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/bus/range_probe.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::bus {

/// The connection that a probe asks through. Blocks its caller; that is why it is no engine.
class ProbeConnection {
public:
    /// Sends a request; repeats what fails by chance.
    /// @returns the code of an exception response, 0 for a normal response; timed_out, bad_checksum,
    ///          unexpected_reply; any other error is trouble of the connection
    [[nodiscard]] virtual Result<int> transact(const wire::PreparedRequest& request) = 0;
    /// Keeps the connection, or restores it, for that time.
    virtual void pause(Duration time) = 0;
    /// The user ended the probe.
    [[nodiscard]] virtual bool interrupted() const = 0;

protected:
    ~ProbeConnection() = default;
};

struct DeviceProbeConfig {
    std::vector<wire::Area> areas;  ///< empty: all four
    std::uint16_t first = 0;        ///< addresses, both included; first <= last
    std::uint16_t last = 65535;
    std::optional<std::uint16_t> step;  ///< nothing: step_within() of max_requests
    std::size_t max_requests = 4096;    ///< for each area
};

/// 1 where half of `max_requests` are as many as the addresses. Otherwise the smallest power of two, at most
/// 0x4000, with which the grid takes at most an eighth of them: likely addresses and the ends of runs need
/// the rest.
[[nodiscard]] std::uint16_t step_within(std::size_t max_requests, std::uint16_t first, std::uint16_t last);

struct AreaProbe {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t step = 1;
    model::ItemRange searched{0, 65535};  ///< the addresses of the search
    ProbeResult result;

    /// Every address was examined, or the device does not have the area.
    [[nodiscard]] bool complete() const;
    /// Items in the ranges found.
    [[nodiscard]] std::size_t items() const;
    /// Addresses of the search, and those of them that were examined.
    [[nodiscard]] std::size_t addresses() const;
    [[nodiscard]] std::size_t tested() const;
    /// The longest run of addresses that were not examined; nothing: all were.
    [[nodiscard]] std::optional<model::ItemRange> longest_gap() const;
};

struct ProbeFindings {
    std::vector<AreaProbe> areas;
    std::vector<wire::Area> not_begun;        ///< wanted areas that the probe did not reach
    std::map<int, std::uint64_t> exceptions;  ///< responses by exception code; busy devices are asked again
    std::optional<Error> lost;                ///< the connection failed for good
    std::optional<Error> no_answer;           ///< the device did not respond at all; no area was probed
    bool stopped = false;                     ///< the probe ended early

    [[nodiscard]] bool complete() const;
    [[nodiscard]] std::size_t requests() const;
    [[nodiscard]] bool any_readable() const;
    /// Registers of the longest read that the device accepts in every area of registers; nothing: no read was
    /// refused for its length, or each of more than one register was.
    [[nodiscard]] std::optional<std::uint16_t> longest_register_read() const;
    /// An area of registers accepts reads of one register alone.
    [[nodiscard]] bool one_register_only() const;
};

/// Called after each request.
struct ProbeProgress {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;   ///< of the request
    std::size_t asked = 0;     ///< requests of this area
    std::size_t expected = 0;  ///< at least so many
};
using ProbeProgressSink = std::function<void(const ProbeProgress&)>;

/// Probes the areas in the order holding registers, input registers, coils, discrete inputs. One item of each
/// is read first: a device that responds to none of them is not probed, as each request would time out.
[[nodiscard]] ProbeFindings probe_device(const DeviceProbeConfig& config, ProbeConnection& connection,
                                         const ProbeProgressSink& progress = {});

}  // namespace takt::bus
