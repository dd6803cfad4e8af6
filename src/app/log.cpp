// spdlog has the levels and the pattern. The lines go through an os::LineWriter, so that a slow or full disk
// never holds up the caller, and lost lines are counted in the log itself.
#include "log.hpp"

#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "output.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/os/rotating_file.hpp"
#include "takt/text/catalogue.hpp"
#include "takt/text/escape.hpp"

namespace takt::app {
namespace {

constexpr std::size_t kFileBytes = 10 << 20;
constexpr unsigned kOldFiles = 3;

std::string gap_line(std::uint64_t lost) {
    return "… " + std::to_string(lost) + " lines were not written: the disk is full or too slow\n";
}

/// Formats on the caller's thread and writes on another one.
class FileSink final : public spdlog::sinks::base_sink<std::mutex> {
public:
    FileSink(std::string path, std::unique_ptr<os::RotatingFile> file)
        : path_(std::move(path)),
          writer_(std::move(file), {.gap_line = gap_line, .gap_interval = std::chrono::seconds(1)}) {}

    /// Writes what is queued. @returns the system's error number if the last write failed; else 0
    int finish() {
        writer_.finish();
        return writer_.error();
    }
    [[nodiscard]] const std::string& path() const { return path_; }

protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        spdlog::memory_buf_t text;
        formatter_->format(message, text);
        writer_.put(fmt::to_string(text));
    }
    void flush_() override {}

private:
    std::string path_;
    os::LineWriter writer_;
};

std::shared_ptr<FileSink> g_sink;  // set once by begin_log() before other threads exist
std::shared_ptr<spdlog::logger> g_logger;
text::Language g_language = text::Language::english;  // of the messages; set by begin_log()

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

void write_record(void*, LogLevel level, std::string_view category, std::string_view event,
                  std::string_view subject, std::int64_t number) {
    if (g_logger)
        g_logger->log(level_of(level), "{}: {} {} {}", category, event, text::escape_line(subject), number);
}

/// The text of an argument, with those before it.
std::string text_of(const LogArgument& argument, std::span<const text::Argument> before) {
    if (argument.error != nullptr) return text::what(g_language, *argument.error);
    if (!argument.is_code) return std::string(argument.text);
    const bool unknown = !argument.otherwise.empty() && !text::has(text::Language::english, argument.text);
    return text::message(g_language, unknown ? argument.otherwise : argument.text, before);
}

void write_message(void*, LogLevel level, std::string_view category, std::string_view code,
                   std::span<const LogArgument> arguments) {
    if (!g_logger || !g_logger->should_log(level_of(level))) return;
    std::vector<std::string> texts;
    texts.reserve(arguments.size());
    std::vector<text::Argument> known;
    for (const LogArgument& argument : arguments) {
        texts.push_back(text_of(argument, known));
        known.push_back({argument.name, texts.back()});
    }
    g_logger->log(level_of(level), "{}: {}", category,
                  text::escape_line(text::message(g_language, code, known)));
}

}  // namespace

Result<void> begin_log(const std::string& path, const std::string& level, text::Language language) {
    g_language = language;
    TAKT_TRY(auto file, os::RotatingFile::open(path, {.file_bytes = kFileBytes, .old_files = kOldFiles}));
    g_sink = std::make_shared<FileSink>(path, std::move(file));
    g_logger = std::make_shared<spdlog::logger>("takt", g_sink);
    g_logger->set_level(spdlog::level::from_str(level));
    g_logger->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
    return {};
}

Log log(std::string_view category) {
    return {category, {write_record, nullptr, write_message}};
}

void end_log() {
    if (!g_sink) return;
    g_logger.reset();
    note_lost_output(g_sink->path(), g_sink->finish());
    g_sink.reset();
}

}  // namespace takt::app
