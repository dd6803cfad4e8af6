#include "live/mark_writer.hpp"

#include <utility>
#include <vector>

#include "live/wall_time.hpp"

namespace takt::web {

MarkWriter::MarkWriter(Marks& marks, MarkWriterOptions options)
    : marks_(marks), options_(std::move(options)), ticker_("takt-marks", kTick, [this](bool) {
          if (options_.wanted()) note(write());
      }) {}

Result<void> MarkWriter::open() {
    TAKT_TRY(auto opened, MarkFile::open(options_.path, marks_.after(Marks::kNone).since_ms));
    note_damage(opened);
    marks_.put_before(opened.since_ms, std::move(opened.marks));
    file_ = std::move(opened.file);
    return {};
}

Result<void> MarkWriter::write() {
    if (!file_) TAKT_CHECK(open());
    const auto fresh = marks_.after(written_);
    if (fresh.marks.empty()) return {};
    auto written = file_->append(fresh.marks);
    if (file_->is_large() || (!written && written.error().code == Code::replaced)) {
        const auto all = marks_.after(Marks::kNone);
        written = file_->write_anew(all.since_ms, all.marks);
        if (written) written_ = all.last;
        return written;
    }
    if (written) written_ = fresh.last;
    return written;
}

void MarkWriter::note(const Result<void>& result) {
    const auto failure = result ? std::nullopt : std::optional(result.error());
    if (failure == failure_) return;
    failure_ = failure;
    if (failure)
        report(LogLevel::warning, "log.marks.failed", {}, failure);
    else
        report(LogLevel::info, "log.marks.work", {{"file", options_.path}});
}

void MarkWriter::note_damage(const MarkFile::Opened& opened) {
    if (!opened.set_aside.empty())
        report(LogLevel::error, "log.marks.set_aside",
               {{"file", options_.path},
                {"aside", opened.set_aside},
                {"count", std::to_string(opened.marks.size())}});
    else if (opened.cut_bytes > 0)
        report(LogLevel::warning, "log.marks.cut",
               {{"file", options_.path}, {"count", std::to_string(opened.cut_bytes)}});
}

void MarkWriter::report(LogLevel level, std::string_view code, const report::Texts::Arguments& arguments,
                        const std::optional<Error>& failure) {
    std::vector<LogArgument> logged;
    for (const auto& [name, text] : arguments) logged.push_back({.name = name, .text = text});
    if (failure) logged.push_back({.name = "failure", .error = &*failure});
    options_.log.message(level, code, logged);

    Mark mark{.time_ms = WallTime().ms(line::now()), .severity = "info"};
    if (level != LogLevel::info) mark.severity = level == LogLevel::error ? "error" : "warning";
    for (const auto language : text::kLanguages) {
        const report::Texts texts(language);
        auto with_failure = arguments;
        if (failure) with_failure.emplace_back("failure", texts.describe(*failure));
        mark.texts[static_cast<std::size_t>(language)] = texts(code, with_failure);
    }
    marks_.put(std::move(mark));
}

}  // namespace takt::web
