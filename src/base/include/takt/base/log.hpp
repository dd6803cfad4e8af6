// The log facade. Modules log codes with arguments; the program injects the sink.
#pragma once

#include <cstdint>
#include <string_view>

namespace takt {

enum class LogLevel : std::uint8_t { trace, debug, info, warning, error };

/// The sink of log lines. `write` must not block and may drop lines. Called on the logging thread.
struct LogSink {
    void (*write)(void* context, LogLevel level, std::string_view category, std::string_view event,
                  std::string_view subject, std::int64_t number) = nullptr;
    void* context = nullptr;
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

private:
    std::string_view category_;
    LogSink sink_;
};

}  // namespace takt
