// Keeps the marks of trends over a restart: a thread that may wait for a disk.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "live/mark_file.hpp"
#include "live/marks.hpp"
#include "takt/base/log.hpp"
#include "takt/os/ticker.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::web {

struct MarkWriterOptions {
    std::string path;  ///< of the file
    /// Whether the marks are to be kept now. Called by the thread. While it is false the file is not touched.
    std::function<bool()> wanted;
    Log log{};
};

/// Reads the marks of the earlier run, and writes each new one within kTick. What cannot be written stays in
/// memory, and is written as soon as that works again. A failure goes to the log once, and becomes a mark
/// itself.
class MarkWriter {
public:
    static constexpr auto kTick = std::chrono::milliseconds(250);

    /// @param marks  must outlive this object
    MarkWriter(Marks& marks, MarkWriterOptions options);
    /// Writes the last marks and ends the thread. A second call does nothing.
    void end() { ticker_.end(); }

private:
    [[nodiscard]] Result<void> write();
    [[nodiscard]] Result<void> open();
    void note(const Result<void>& result);
    void note_damage(const MarkFile::Opened& opened);
    /// @param failure  the argument `failure` of the text
    void report(LogLevel level, std::string_view code, const report::Texts::Arguments& arguments,
                const std::optional<Error>& failure = {});

    Marks& marks_;
    const MarkWriterOptions options_;
    std::unique_ptr<MarkFile> file_;  // of the thread, as the next ones
    std::int64_t written_ = -1;       // the number of the last mark in the file
    std::optional<Error> failure_;    // that was logged last
    os::Ticker ticker_;               // last: it uses the other members
};

}  // namespace takt::web
