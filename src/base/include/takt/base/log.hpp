// The log facade: rooms say what happened as a code with arguments; the sink is injected by the program.
#pragma once

#include <cstdint>
#include <string_view>

namespace takt {

enum class LogLevel : std::uint8_t { trace, debug, info, warning, error };

/// Where log lines go. `write` must not block and may drop; it is called on the thread that logs.
struct LogSink {
    void (*write)(void* context, LogLevel level, std::string_view category, std::string_view event,
                  std::string_view subject, std::int64_t number) = nullptr;
    void* context = nullptr;
};

/// A room's handle to the log: a category (the room's name) and the sink. A default one is silent. Cheap to
/// copy.
class Log {
public:
    constexpr Log() = default;
    constexpr Log(std::string_view category, LogSink sink) : category_(category), sink_(sink) {}

    void operator()(LogLevel level, std::string_view event, std::string_view subject = {},
                    std::int64_t number = 0) const {
        if (sink_.write) sink_.write(sink_.context, level, category_, event, subject, number);
    }

private:
    std::string_view category_;
    LogSink sink_;
};

}  // namespace takt
