// What the log has of an output.
#pragma once

#include <string>

#include "takt/base/log.hpp"
#include "takt/publish/output_status.hpp"

namespace takt::publish {

/// Logs changes of what an output does: that it delivers, or why it does not, and the errors of its journal.
/// Attempts to connect are no changes.
class OutputLog {
public:
    explicit OutputLog(Log log) : log_(log) {}

    void note(const OutputStatus& status);

private:
    void note_destination(const OutputStatus& status);
    void note_behind(const OutputStatus& status);
    void note_journal(const OutputStatus& status);
    void note_unrecorded(const OutputStatus& status);
    void note_too_large(const OutputStatus& status);
    void note_oversized(const OutputStatus& status);
    void note_damaged(const OutputStatus& status);
    void note_set_aside(const OutputStatus& status);
    void note_journal_set_aside(const OutputStatus& status);

    Log log_;
    OutputState state_ = OutputState::starting;  // that was logged
    std::string failure_;
    bool journal_failed_ = false;
    std::uint64_t unrecorded_ = 0;
    bool too_large_noted_ = false;
    std::uint64_t oversized_ = 0;  // messages, at the last line
    std::uint64_t damaged_ = 0;
    std::string set_aside_;
    std::string journal_set_aside_;
};

}  // namespace takt::publish
