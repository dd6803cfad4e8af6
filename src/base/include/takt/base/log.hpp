// The log facade. Modules log codes with arguments; the program injects the sink.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "takt/base/result.hpp"

namespace takt {

enum class LogLevel : std::uint8_t { trace, debug, info, warning, error };

/// A value of a message by its placeholder.
struct LogArgument {
    std::string_view name;
    std::string_view text;
    std::string_view otherwise;    ///< the code to use if `text` is an unknown code
    const Error* error = nullptr;  ///< instead of `text`
    bool is_code = false;          ///< `text` is the code of a text, whose arguments go before this one
};

/// The sink of log lines. `write` must not block and may drop lines. Called on the logging thread.
struct LogSink {
    void (*write)(void* context, LogLevel level, std::string_view category, std::string_view event,
                  std::string_view subject, std::int64_t number) = nullptr;
    void* context = nullptr;
    /// As `write`, for a line that is the text of a code (module text).
    void (*write_message)(void* context, LogLevel level, std::string_view category, std::string_view code,
                          std::span<const LogArgument> arguments) = nullptr;
};

/// A module's handle to the log: a category (the module's name) and the sink. The default one drops
/// everything. Cheap to copy.
class Log {
public:
    constexpr Log() = default;
    constexpr Log(std::string_view category, LogSink sink) : category_(category), sink_(sink) {}

    void operator()(LogLevel level, std::string_view event, std::string_view subject = {},
                    std::int64_t number = 0) const {
        if (sink_.write) sink_.write(sink_.context, level, category_, event, subject, number);
    }

    /// Whether message() has an effect.
    [[nodiscard]] bool enabled() const { return sink_.write_message != nullptr; }

    void message(LogLevel level, std::string_view code, std::span<const LogArgument> arguments) const {
        if (enabled()) sink_.write_message(sink_.context, level, category_, code, arguments);
    }

private:
    std::string_view category_;
    LogSink sink_;
};

}  // namespace takt
