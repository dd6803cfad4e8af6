// What an endpoint reports to its operator while it works: codes and arguments, no text.
#pragma once

#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/result.hpp"
#include "takt/model/findings.hpp"

namespace takt::endpoint {

/// A finding about a running endpoint. `code` is the key of its message ("app.registers.new"), and
/// `arguments` are the message's placeholders. A message with the placeholder {error} describes `error`.
struct Notice : model::Finding {
    std::optional<Error> error;
};

/// Takes notices as they arise. Called on the loop's thread; must not block and must not call back.
using NoticeSink = std::function<void(const Notice&)>;

/// A warning with that code.
[[nodiscard]] inline Notice make_notice(std::string_view code,
                                        std::initializer_list<std::pair<std::string, std::string>> arguments,
                                        std::optional<Error> error = {}) {
    Notice notice;
    notice.severity = model::Severity::warning;
    notice.code = code;
    notice.arguments = arguments;
    notice.error = std::move(error);
    return notice;
}

}  // namespace takt::endpoint
