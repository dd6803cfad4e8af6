// Messages of the stream, as their subscribers read them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/publish/sample.hpp"

namespace takt::gatewaysim {

struct SeenSample {
    std::uint64_t number = 0;
    std::string variable;
    file::Json fields;  ///< value, quality, time, …
};

struct SeenGap {
    std::uint64_t number = 0;  ///< of the first missing sample
    std::string cause;
    std::uint64_t samples = 0;
    std::string first;
    std::string last;
    friend bool operator==(const SeenGap&, const SeenGap&) = default;
};

/// An array is one with the samples of its elements.
struct SeenMessage {
    std::uint64_t epoch = 0;
    bool repeated = false;
    std::string device;
    std::vector<SeenSample> samples;
    std::optional<SeenGap> gap;  ///< then there are no samples
};

/// @returns nothing: it has not the form of docs/mqtt-messages.md
[[nodiscard]] std::optional<SeenMessage> read_message(std::string_view payload);

/// RFC 3339 in UTC with milliseconds, rounded down.
[[nodiscard]] std::string time_text(std::int64_t wall_ns);

/// What differs between the fields of a message and a sample; empty: nothing.
[[nodiscard]] std::string difference(const file::Json& fields, const publish::Series& series,
                                     const publish::Sample& sample);

}  // namespace takt::gatewaysim
