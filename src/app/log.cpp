#include "takt/app/log.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/spdlog.h>

#include <cerrno>
#include <memory>

namespace takt::app {
namespace {

constexpr std::size_t kFileBytes = 10 << 20;
constexpr std::size_t kOldFiles = 3;
constexpr std::size_t kQueueLines = 8192;

std::shared_ptr<spdlog::logger> g_logger;  // set once by begin_log() before other threads exist

constexpr spdlog::level::level_enum level_of(LogLevel level) {
    switch (level) {
        case LogLevel::trace: return spdlog::level::trace;
        case LogLevel::debug: return spdlog::level::debug;
        case LogLevel::info: return spdlog::level::info;
        case LogLevel::warning: return spdlog::level::warn;
        case LogLevel::error: return spdlog::level::err;
    }
    return spdlog::level::info;
}

void write(void*, LogLevel level, std::string_view category, std::string_view event, std::string_view subject,
           std::int64_t number) {
    if (g_logger) g_logger->log(level_of(level), "{}: {} {} {}", category, event, subject, number);
}

}  // namespace

Result<void> begin_log(const std::string& path, const std::string& level) {
    try {
        spdlog::init_thread_pool(kQueueLines, 1);
        auto sink = std::make_shared<spdlog::sinks::rotating_file_sink_mt>(path, kFileBytes, kOldFiles);
        g_logger = std::make_shared<spdlog::async_logger>("takt", std::move(sink), spdlog::thread_pool(),
                                                          spdlog::async_overflow_policy::overrun_oldest);
    } catch (const spdlog::spdlog_ex&) {
        return fail(Code::cannot_open, path, errno);
    }
    g_logger->set_level(spdlog::level::from_str(level));
    g_logger->set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
    return {};
}

Log log(std::string_view category) {
    return {category, {write, nullptr}};
}

void end_log() {
    if (!g_logger) return;
    g_logger->flush();
    g_logger.reset();
    spdlog::shutdown();
}

}  // namespace takt::app
