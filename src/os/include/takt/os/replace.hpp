// Atomic replacement of a file: a reader of the path finds the old contents or the new, never a part.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::os {

/// A new file that is written under a temporary name beside its path and renamed when it is on the disk.
///
/// The temporary file is removed when the object is destroyed without commit(). One thread at a time.
class FileReplacement {
public:
    struct Options {
        /// Mode of a new file, less the umask. An existing file passes its own mode on, and its owner and
        /// group as far as the system allows it.
        ::mode_t mode = 0666;
        /// Whether an existing file is replaced; else begin() and commit() return EEXIST.
        bool replace = true;
        /// Appended to the path to name the temporary file. Empty: ".PID-N.new" with a free N.
        std::string temporary_suffix;
        /// With `temporary_suffix`: decides from the contents of an existing temporary file whether an
        /// earlier run left it and it may be overwritten. Empty: it is never overwritten.
        std::function<Result<bool>(int descriptor)> may_overwrite;
        /// Whether the file is locked (flock, exclusive) before it is written. The lock lasts as long as a
        /// duplicate of descriptor() is open.
        bool lock = false;
    };

    /// Creates the temporary file. A symbolic link at `path` stays; its target is replaced. A
    /// link of another user than this one and root is refused.
    /// @returns cannot_open (path, system's error number: EEXIST, EISDIR, ELOOP), unsupported (path: not a
    ///          regular file; or the temporary file: not ours), busy (the temporary file is locked),
    ///          io_failed
    [[nodiscard]] static Result<FileReplacement> begin(const std::string& path, const Options& options);

    ~FileReplacement();
    FileReplacement(FileReplacement&& other) noexcept;
    FileReplacement& operator=(FileReplacement&&) = delete;

    /// Open for reading and writing, at the file's beginning.
    [[nodiscard]] int descriptor() const { return file_.get(); }

    /// The path of the file that is replaced, with links followed.
    [[nodiscard]] const std::string& path() const { return path_; }

    /// The temporary file's path, for a library that opens the file itself. It must not have the file open
    /// any more when commit() is called.
    [[nodiscard]] const std::string& temporary() const { return temporary_; }

    /// Synchronises the file with the disk, renames it to its path and synchronises the folder.
    /// @returns cannot_open with EEXIST where the path exists and must not be replaced, io_failed (path,
    ///          system's error number: 28, the disk is full)
    [[nodiscard]] Result<void> commit();

    /// Synchronises the file with the disk and leaves it under its temporary name, which the caller renames
    /// or removes. Then sync_names() synchronises the folder.
    /// @returns the temporary name; io_failed (path, system's error number)
    [[nodiscard]] Result<std::string> release();
    [[nodiscard]] Result<void> sync_names() const;

private:
    FileReplacement(std::string path, bool replace) : path_(std::move(path)), replace_(replace) {}
    [[nodiscard]] Result<void> create_unique(::mode_t mode);
    [[nodiscard]] Result<void> create_named(const std::string& name, const Options& options);
    [[nodiscard]] Result<void> sync_contents() const;
    [[nodiscard]] Result<void> rename_temporary();

    std::string path_;
    bool replace_;
    std::string temporary_;  // empty: none to remove
    Descriptor file_;
};

/// Replaces the contents of `path` by `bytes`.
/// @returns as FileReplacement
[[nodiscard]] Result<void> replace_file(const std::string& path, std::string_view bytes,
                                        const FileReplacement::Options& options);

/// Renames a file to a name that must be free. A file system without RENAME_NOREPLACE gets a hard link
/// instead; one without links is asked first whether the name is free.
/// @returns 0, or the system's error number: EEXIST, the name is taken
[[nodiscard]] int rename_to_free(const std::string& from, const std::string& to);

/// Makes what was renamed or created in the folder of `path` durable.
/// @returns cannot_open, io_failed (folder, system's error number)
[[nodiscard]] Result<void> sync_folder(const std::string& path);

}  // namespace takt::os
