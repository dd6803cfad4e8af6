// A damaged history file that is replaced by a new one.
#pragma once

#include <string>

#include "history/history_file.hpp"
#include "takt/base/time.hpp"

namespace takt::store {

struct ReplacedHistory {
    HistoryFile file;       ///< the new one
    std::string set_aside;  ///< where the damaged one is
};

/// Moves a damaged file aside and begins a new one. A gap `damaged` is in the place of the samples: from the
/// oldest one to the last commit. If the damaged file does not show these times, the gap begins `retention`
/// before the last change of the file, and ends there. There is no gap if the file had no samples. No
/// database of this process may have the file open.
/// @returns io_failed, cannot_open and others of open_history_file(): the damaged file is in its old place
[[nodiscard]] Result<ReplacedHistory> replace_history(const std::string& path, Duration retention);

}  // namespace takt::store
