#include "takt/os/replace.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

#include "takt/os/open.hpp"

namespace takt::os {
namespace {

constexpr int kNames = 100;
constexpr ::mode_t kModeBits = 07777;

/// Checks the file that is to be replaced. @returns its status; none: there is no file
Result<std::optional<struct stat>> status_of_existing(const std::string& path, bool replace) {
    if (path.empty() || path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0) {
        if (errno != ENOENT) return fail(Code::cannot_open, path, errno);
        return std::nullopt;
    }
    if (S_ISDIR(status.st_mode)) return fail(Code::cannot_open, path, EISDIR);
    if (!S_ISREG(status.st_mode)) return fail(Code::unsupported, path);
    if (!replace) return fail(Code::cannot_open, path, EEXIST);
    if (::access(path.c_str(), W_OK) != 0) return fail(Code::cannot_open, path, errno);
    return status;
}

/// Only root may give a file away, and others only to their own groups: where that fails, the file stays
/// ours. The mode is set last, because a change of the owner clears bits of it.
bool pass_on(int descriptor, const struct stat& old) {
    struct stat created{};
    if (::fstat(descriptor, &created) != 0) return false;
    if ((created.st_uid != old.st_uid || created.st_gid != old.st_gid) &&
        ::fchown(descriptor, old.st_uid, old.st_gid) != 0)
        static_cast<void>(::fchown(descriptor, static_cast<::uid_t>(-1), old.st_gid));
    return ::fchmod(descriptor, old.st_mode & kModeBits) == 0;
}

/// Whether another user may have created a link at the path, to have one of our files replaced.
bool is_link_of_another(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode) && status.st_uid != ::geteuid() &&
           status.st_uid != 0;
}

std::string real_path(const std::string& path) {
    std::error_code error;
    const auto real = std::filesystem::canonical(path, error);
    return error ? path : real.string();
}

/// Whether the name still belongs to the open file. Its owner may have renamed it before we had the lock.
bool is_named(int descriptor, const std::string& name) {
    struct stat open_file{};
    struct stat named{};
    return ::fstat(descriptor, &open_file) == 0 && ::lstat(name.c_str(), &named) == 0 &&
           open_file.st_dev == named.st_dev && open_file.st_ino == named.st_ino;
}

}  // namespace

FileReplacement::FileReplacement(FileReplacement&& other) noexcept
    : path_(std::move(other.path_)),
      replace_(other.replace_),
      temporary_(std::exchange(other.temporary_, {})),
      file_(std::move(other.file_)) {}

// The name is removed while the lock is held, so that it cannot be another program's by then.
FileReplacement::~FileReplacement() {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

Result<FileReplacement> FileReplacement::begin(const std::string& path, const Options& options) {
    TAKT_TRY(const auto existing, status_of_existing(path, options.replace));
    if (existing && is_link_of_another(path)) return fail(Code::cannot_open, path, ELOOP);
    FileReplacement made(existing ? real_path(path) : path, options.replace);
    if (options.temporary_suffix.empty())
        TAKT_CHECK(made.create_unique(options.mode));
    else
        TAKT_CHECK(made.create_named(made.path_ + options.temporary_suffix, options));
    if (existing && !pass_on(made.file_.get(), *existing)) return fail(Code::io_failed, path, errno);
    return made;
}

Result<void> FileReplacement::create_unique(::mode_t mode) {
    for (int i = 0; i < kNames; ++i) {
        std::string name = path_ + "." + std::to_string(::getpid()) + "-" + std::to_string(i) + ".new";
        auto created = create_file(name, mode);
        if (created) {
            temporary_ = std::move(name);
            file_ = *std::move(created);
            return {};
        }
        if (created.error().numbers[0] != EEXIST)
            return fail(Code::cannot_open, path_, created.error().numbers[0]);
    }
    return fail(Code::cannot_open, path_, EEXIST);
}

Result<void> FileReplacement::create_named(const std::string& name, const Options& options) {
    auto created = create_file(name, options.mode);
    const bool exists = !created && created.error().numbers[0] == EEXIST;
    if (exists) {
        struct stat status{};
        if (!options.may_overwrite || ::lstat(name.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
            return fail(Code::unsupported, name);
        created = open_for_update(name);
    }
    if (!created) return std::unexpected(created.error());
    const int descriptor = created->get();
    if (options.lock && ::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, name, errno);
    if (!is_named(descriptor, name)) return fail(Code::busy, name);
    if (exists) {
        TAKT_TRY(const bool ours, options.may_overwrite(descriptor));
        if (!ours) return fail(Code::unsupported, name);
        if (::ftruncate(descriptor, 0) != 0) return fail(Code::io_failed, name, errno);
    }
    temporary_ = name;
    file_ = *std::move(created);
    return {};
}

Result<void> FileReplacement::rename_temporary() {
    int error = 0;
    if (!replace_)
        error = rename_to_free(temporary_, path_);
    else if (std::rename(temporary_.c_str(), path_.c_str()) != 0)
        error = errno;
    if (error != 0) return fail(error == EEXIST ? Code::cannot_open : Code::io_failed, path_, error);
    temporary_.clear();
    return {};
}

Result<void> FileReplacement::sync_contents() const {
    // EINVAL: the file system has nothing to synchronise.
    if (::fsync(file_.get()) != 0 && errno != EINVAL) return fail(Code::io_failed, path_, errno);
    return {};
}

Result<void> FileReplacement::commit() {
    TAKT_CHECK(sync_contents());
    TAKT_CHECK(rename_temporary());
    return sync_names();
}

Result<std::string> FileReplacement::release() {
    TAKT_CHECK(sync_contents());
    return std::exchange(temporary_, {});
}

Result<void> FileReplacement::sync_names() const {
    auto synced = sync_folder(path_);
    // A folder that may be written but not read: synchronise the whole file system instead.
    if (!synced && synced.error().code == Code::cannot_open && ::syncfs(file_.get()) == 0) return {};
    return synced;
}

Result<void> replace_file(const std::string& path, std::string_view bytes,
                          const FileReplacement::Options& options) {
    TAKT_TRY(auto replacement, FileReplacement::begin(path, options));
    if (!write_all(replacement.descriptor(), bytes)) return fail(Code::io_failed, path, errno);
    return replacement.commit();
}

int rename_to_free(const std::string& from, const std::string& to) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
    if (errno != EINVAL && errno != ENOSYS) return errno;
    if (::link(from.c_str(), to.c_str()) == 0) {
        ::unlink(from.c_str());
        return 0;
    }
    if (errno != EPERM && errno != EOPNOTSUPP && errno != ENOSYS) return errno;
    struct stat status{};
    if (::lstat(to.c_str(), &status) == 0) return EEXIST;
    return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

Result<void> sync_folder(const std::string& path) {
    auto folder = std::filesystem::path(path).parent_path().string();
    if (folder.empty()) folder = ".";
    const Descriptor open_folder(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!open_folder) return fail(Code::cannot_open, folder, errno);
    if (::fsync(open_folder.get()) != 0 && errno != EINVAL) return fail(Code::io_failed, folder, errno);
    return {};
}

}  // namespace takt::os
