// How far a long command is, on standard error: a bar on a terminal, else a line now and then.
#pragma once

#include <cstddef>
#include <string>

#include "takt/app/texts.hpp"
#include "takt/base/time.hpp"

namespace takt::app {

/// What is done of how much, in the same unit; `total` may grow.
struct Done {
    std::size_t done = 0;
    std::size_t total = 0;
    std::size_t requests = 0;  ///< so far: shown as a rate
};

/// Says nothing for the first two seconds; then on a terminal a bar with rate and remaining time, five times
/// a second, in other places a line each ten seconds. One owner, one thread.
class Progress {
public:
    /// @param wanted  false: never says anything
    Progress(const Texts& texts, Instant start, bool wanted = true);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// @param what  what it is busy with, in words
    void show(Instant t, const Done& done, const std::string& what);

    /// Takes the bar away, before something else is written to the terminal; show() brings it back.
    void clear();

private:
    [[nodiscard]] std::string back() const;
    [[nodiscard]] std::string line(Instant t, const Done& done, const std::string& what) const;

    Texts texts_;
    Instant start_;
    Instant next_;
    bool wanted_;
    bool terminal_;
    std::size_t drawn_ = 0;  // characters of the bar that stands there
};

/// "45 s", "3 min 5 s", "2 h 10 min".
[[nodiscard]] std::string rough_time(Duration time);

/// "[#####-----]" of `width` characters between the brackets.
[[nodiscard]] std::string bar(std::size_t done, std::size_t total, std::size_t width);

}  // namespace takt::app
