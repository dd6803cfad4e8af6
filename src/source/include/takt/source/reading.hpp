// What a source knows of a value.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::source {

struct Reading {
    value::Value value;
    std::optional<Instant> at;  ///< when what it was taken from began to be asked for; nothing: never
    bool fails = false;         ///< the last attempt gave nothing

    /// Not older than that.
    [[nodiscard]] bool fresh(Instant t, std::optional<Duration> max_age) const {
        return at && (!max_age || t - *at <= *max_age);
    }
};

/// A measurement found in what was said; the name is that of the template or format it was found with.
struct Measured {
    std::string_view name;
    value::Value value;
};
using Measurements = std::vector<Measured>;

}  // namespace takt::source
