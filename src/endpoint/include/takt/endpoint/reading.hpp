// A value read from a source.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::endpoint {

struct Reading {
    value::Value value;
    std::optional<Instant> at;  ///< start of the request that gave the value; nothing: never read
    bool fails = false;         ///< the last attempt failed

    /// Whether the value is not older than that.
    [[nodiscard]] bool fresh(Instant t, std::optional<Duration> max_age) const {
        return at && (!max_age || t - *at <= *max_age);
    }
};

/// A measurement found in an answer, under the name of its placeholder or field.
struct Measured {
    std::string_view name;
    value::Value value;
};
using Measurements = std::vector<Measured>;

}  // namespace takt::endpoint
