// Replacement of a file that other programs edit too: none of their edits is lost.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"

namespace takt::os {

/// Exchanges the files of two names atomically (RENAME_EXCHANGE).
/// @returns 0, or the system's error number: EINVAL or ENOSYS where the file system cannot do it
[[nodiscard]] int exchange_names(const std::string& first, const std::string& second);

struct ExchangeOptions {
    /// Tests put edits of another program around the exchange, or refuse it.
    std::function<int(const std::string& first, const std::string& second)> exchange = exchange_names;
};

/// How exchange_file() ended.
struct Exchanged {
    bool replaced = false;  ///< false: the file had other contents, and stays as another program left it
    std::string backup;     ///< with `replaced`: the old file
    /// Files with edits of other programs that are not at the path any more. After 1,000 files
    /// PATH.conflict.N a further one keeps its temporary name.
    std::vector<std::string> kept;
};

/// Replaces the file at `path` by `bytes` if its contents are `expected`.
///
/// The old file becomes PATH~ with its mode and owner; the new one gets the same mode and, where the system
/// allows it, the same owner. A symbolic link at `path` stays: PATH is its target. A reader of the path finds
/// the old contents or the new.
///
/// Another program may replace the file at any moment. Its edit is displaced by the exchange, recognised, and
/// put back by a second one. An edit that comes between the two exchanges stays at the path; the one before
/// it is kept as PATH.conflict, or PATH.conflict.2 and so on: such a file is never overwritten. An old file
/// that cannot become PATH~ is kept in the same way.
///
/// A file system without the exchange: the old file is renamed to PATH.conflict, compared, and the new one
/// takes the free name. For that moment a reader finds no file. Nothing is lost there either; a crash at that
/// moment leaves the old file as PATH.conflict.
///
/// Any thread; two calls for one path must not overlap.
/// @returns as FileReplacement::begin() and commit(); cannot_open with EISDIR (PATH~) where the backup is a
///          folder. After an error of the last synchronisation the file may be replaced
[[nodiscard]] Result<Exchanged> exchange_file(const std::string& path, std::string_view bytes,
                                              std::string_view expected, const ExchangeOptions& options = {});

}  // namespace takt::os
