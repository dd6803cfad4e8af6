// The progress of a long command on standard error: a bar on a terminal, else a line every ten seconds.
#pragma once

#include <cstddef>
#include <string>

#include "takt/base/time.hpp"
#include "takt/host/project_file.hpp"
#include "takt/report/drawing/progress_text.hpp"
#include "texts.hpp"

namespace takt::app {

struct ProgressPace {
    Duration silent_for = std::chrono::seconds(2);
    Duration line_every = std::chrono::seconds(10);  ///< where there is no terminal
};

/// Silent at first. Then a terminal shows a bar, redrawn five times a second; elsewhere a line is written now
/// and then. One owner, one thread.
class Progress {
public:
    /// @param wanted  false: it stays silent
    Progress(const Texts& texts, Instant start, bool wanted = true, ProgressPace pace = {});
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// @param what  the current step, in words
    void show(Instant t, const report::Done& done, const std::string& what);

    /// Removes the bar before other output goes to the terminal; show() draws it again.
    void clear();

private:
    [[nodiscard]] std::string back() const;

    Texts texts_;
    Instant start_;
    ProgressPace pace_;
    Instant next_;
    bool wanted_;
    bool terminal_;
    std::size_t drawn_ = 0;  // columns of the bar on the terminal
};

/// host::prove(), with its progress on stderr.
/// @param start  of the command: the progress is shown two seconds later
[[nodiscard]] plan::Proof prove(const Texts& texts, const host::LoadedProject& loaded, bool late_is_error,
                                bool with_measures, Instant start);

}  // namespace takt::app
