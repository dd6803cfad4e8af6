// Samples: what an output delivers of the values of a project.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/value/value.hpp"

namespace takt::publish {

/// The variable or local of samples, by its names at the time of the sample.
struct Series {
    std::string variable;
    std::string device;  ///< empty: a local
    std::string line;    ///< empty: a local
    std::string unit;
    DataType type = DataType::int16;
    bool scaled = false;  ///< its value is a floating-point number, whichever its type

    friend bool operator==(const Series&, const Series&) = default;
};

/// Why there is a sample. The numbers are stored and stable.
enum class SampleCause : std::uint8_t {
    change = 0,     ///< value, quality or reason became another
    period = 1,     ///< the period of the selection
    heartbeat = 2,  ///< nothing changed for that long
    current = 3,    ///< the state at a start, after lost events, or on request
};
std::string_view name(SampleCause cause);

struct Sample {
    std::uint32_t series = 0;  ///< index into SampleBatch::series
    value::Value value;
    value::Quality quality = value::Quality::good;
    value::Reason reason = value::Reason::ok;
    SampleCause cause = SampleCause::change;
    std::int64_t wall_ns = 0;  ///< when the value was read, or the quality changed; ns since 1970 UTC
    /// Of a good value: the read before, so that the value changed between it and `wall_ns`. Of another one:
    /// the last good read. Not later than `wall_ns`.
    std::optional<std::int64_t> previous_wall_ns;
};

/// Samples that are written and delivered together: the payload of a record of the journal.
struct SampleBatch {
    std::vector<Series> series;
    std::vector<Sample> samples;
};

}  // namespace takt::publish
