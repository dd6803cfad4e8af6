// Samples of a plant, encoded into payloads as an output encodes them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "takt/publish/sample_codec.hpp"

namespace takt::bench {

enum class Kind : std::uint8_t { floating, integer, boolean };
std::string_view name(Kind kind);

/// The payload limit of an output: SampleFeed.
inline constexpr std::size_t kPayloadBytes = 32'768;

/// Each variable changes in its turn; ten variables to a device.
class Plant {
public:
    using Sink = std::function<void(std::vector<std::uint8_t> payload, std::uint64_t samples)>;

    Plant(std::size_t variables, Kind kind);

    /// Encodes `count` samples that were read between `from_ns` and `to_ns`, as one collection of an output:
    /// `sink` gets each full payload and the last one.
    void collect(std::size_t count, std::int64_t from_ns, std::int64_t to_ns, const Sink& sink);

private:
    [[nodiscard]] value::Value next_value();
    void finish_payload(const Sink& sink);

    Kind kind_;
    std::vector<publish::Series> series_;
    std::vector<std::int64_t> read_ns_;  // of the last sample of each variable
    publish::SamplePayload payload_{kPayloadBytes};
    std::size_t next_ = 0;
    std::uint64_t random_ = 88172645463325252U;
};

}  // namespace takt::bench
