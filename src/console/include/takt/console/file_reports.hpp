// What a log reports about its file.
#pragma once

#include <functional>
#include <string>

#include "takt/base/result.hpp"

namespace takt::console {

/// Each may be empty.
struct FileReports {
    using OnError = std::function<void(const Error& error)>;

    /// A write failed: the first one, or the first one after records were written. The log's writing thread.
    OnError on_failed;
    /// A full file goes on because the next one cannot begin. Likewise once until one begins.
    OnError on_not_rotated;
    /// At the end: the file is incomplete. The owner's thread.
    /// @param number  errno of a write that failed
    std::function<void(const std::string& path, int number)> on_lost;
};

}  // namespace takt::console
