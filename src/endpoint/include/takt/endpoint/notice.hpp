// Reports of an endpoint or a host to its operator: codes and arguments, no text.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"

namespace takt::endpoint {

/// A report of an endpoint or a host at work.
struct Notice {
    enum class Severity : std::uint8_t {
        status,   ///< as expected
        warning,  ///< it works on, with less than the operator may expect
        error,    ///< something failed
    };
    using Arguments = std::vector<std::pair<std::string, std::string>>;

    Severity severity = Severity::warning;
    std::string code;            ///< key of the message; begins with the module: "endpoint.registers.new"
    Arguments arguments;         ///< placeholders of the message: name, text
    std::optional<Error> error;  ///< described by the placeholder {error}
};

/// Takes notices as they arise. Called on the loop's thread; must not block and must not call back.
using NoticeSink = std::function<void(const Notice&)>;

}  // namespace takt::endpoint
