#include "takt/store/posix_journal_storage.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <system_error>
#include <utility>

#include "registers/database.hpp"
#include "takt/os/open.hpp"
#include "takt/os/set_aside.hpp"

namespace takt::store {
namespace {

constexpr std::string_view kSegmentPrefix = "segment-";
constexpr std::string_view kCursorPrefix = "cursor-";
constexpr std::string_view kEndName = "stream-end";
constexpr std::size_t kDigits = 20;
constexpr std::uint64_t kSlotOffset = 4096;  // of slot 1: a sector of its own, also on disks with large ones
constexpr std::uint64_t kEndOffset = 512;    // of slot 1: in the same block, which a full disk still has
constexpr std::uint64_t kLeastReserved = std::uint64_t{64} << 10U;

std::unexpected<Error> io_failure(const std::string& path) {
    return fail(Code::io_failed, path, errno);
}

std::optional<std::uint64_t> number_of(std::string_view name) {
    if (!name.starts_with(kSegmentPrefix)) return std::nullopt;
    name.remove_prefix(kSegmentPrefix.size());
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
    if (name.size() != kDigits || error != std::errc{} || end != name.data() + name.size())
        return std::nullopt;
    return number;
}

Result<std::size_t> read_at(int file, const std::string& path, std::uint64_t offset,
                            std::span<std::uint8_t> into) {
    std::size_t done = 0;
    while (done < into.size()) {
        const auto got =
            ::pread(file, into.data() + done, into.size() - done, static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return io_failure(path);
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    return done;
}

Result<void> write_at(int file, const std::string& path, std::uint64_t offset, Bytes bytes) {
    while (!bytes.empty()) {
        const auto put = ::pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return io_failure(path);
        offset += static_cast<std::uint64_t>(put);
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
    return {};
}

/// A file without a name: its bytes are lost when it is closed.
bool is_removed(int file) {
    struct stat status{};
    return ::fstat(file, &status) == 0 && status.st_nlink == 0;
}

Result<os::Descriptor> lock(const std::string& directory) {
    os::Descriptor folder(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!folder) return fail(Code::cannot_open, directory, errno);
    if (::flock(folder.get(), LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, directory, errno);
    return folder;
}

/// Whether the path leads to something that can never be opened as a file. A missing one is none.
bool is_no_file(const std::string& path) {
    struct stat status{};
    if (::stat(path.c_str(), &status) == 0) return !S_ISREG(status.st_mode);
    return (errno == ENOENT || errno == ELOOP) && ::lstat(path.c_str(), &status) == 0;
}

/// Reserves space behind the end, less than `bytes` on a disk that is nearly full.
/// @returns what a segment should have at most; 0: see errno
std::uint64_t reserve(int file, std::uint64_t bytes) {
    for (auto size = bytes; size >= std::min(bytes, kLeastReserved); size /= 2) {
        if (::fallocate(file, FALLOC_FL_KEEP_SIZE, 0, static_cast<off_t>(size)) == 0) return size;
        if (errno == EOPNOTSUPP) return bytes;
        if (errno != ENOSPC && errno != EDQUOT) return 0;
    }
    return 0;
}

/// Frees the reserved space behind the end. A failure costs space only.
void cut_at_size(int file) {
    struct stat status{};
    if (::fstat(file, &status) == 0 && ::ftruncate(file, status.st_size) != 0) return;
}

}  // namespace

Result<std::unique_ptr<PosixJournalStorage>> PosixJournalStorage::open(const std::string& directory,
                                                                       std::uint64_t segment_bytes) {
    TAKT_TRY(auto folder, lock(directory));
    return std::unique_ptr<PosixJournalStorage>(
        new PosixJournalStorage(directory, std::move(folder), segment_bytes));
}

PosixJournalStorage::PosixJournalStorage(std::string directory, os::Descriptor folder,
                                         std::uint64_t segment_bytes)
    : directory_(std::move(directory)), folder_(std::move(folder)), segment_bytes_(segment_bytes) {}

std::string PosixJournalStorage::path_of(std::uint64_t segment) const {
    std::string digits = std::to_string(segment);
    digits.insert(0, kDigits - digits.size(), '0');
    return directory_ + "/" + std::string(kSegmentPrefix) + digits;
}

std::string PosixJournalStorage::path_of(std::string_view destination) const {
    return directory_ + "/" + std::string(kCursorPrefix) + std::string(destination);
}

// What was in the removed folder is gone. The journal goes on in another one of its name, so that its numbers
// are not used again.
Result<void> PosixJournalStorage::replace_removed_folder() {
    if (!is_removed(folder_.get())) return {};
    std::error_code error;
    std::filesystem::create_directories(directory_, error);
    if (error) return fail(Code::cannot_open, directory_, error.value());
    TAKT_TRY(folder_, lock(directory_));
    cursors_.clear();
    return {};
}

Result<void> PosixJournalStorage::sync_folder() {
    if (!folder_changed_) return {};
    if (::fsync(folder_.get()) != 0 && errno != EINVAL) return io_failure(directory_);
    folder_changed_ = false;
    return {};
}

Result<std::vector<SegmentFile>> PosixJournalStorage::list_segments() {
    const std::unique_ptr<DIR, int (*)(DIR*)> entries(::opendir(directory_.c_str()), &::closedir);
    if (!entries) return fail(Code::cannot_open, directory_, errno);
    std::vector<SegmentFile> files;
    for (;;) {
        errno = 0;
        const dirent* entry = ::readdir(entries.get());
        if (entry == nullptr && errno != 0) return io_failure(directory_);
        if (entry == nullptr) return files;
        const auto number = number_of(entry->d_name);
        if (!number) continue;
        struct stat status{};
        if (is_no_file(path_of(*number))) {
            TAKT_CHECK(move_aside(path_of(*number)));
            continue;
        }
        if (::stat(path_of(*number).c_str(), &status) != 0) return io_failure(path_of(*number));
        files.push_back({*number, static_cast<std::uint64_t>(status.st_size)});
    }
}

Result<std::size_t> PosixJournalStorage::read(std::uint64_t segment, std::uint64_t offset,
                                              std::span<std::uint8_t> into) {
    if (!read_ || read_->number != segment) {
        read_.reset();
        if (is_no_file(path_of(segment))) TAKT_CHECK(move_aside(path_of(segment)));
        auto file = os::open_for_reading(path_of(segment));
        const bool missing = !file && file.error().numbers[0] == ENOENT;
        if (missing && ::access(directory_.c_str(), F_OK) == 0) return std::size_t{0};
        if (!file) return std::unexpected(file.error());
        read_ = OpenSegment{segment, *std::move(file)};
    }
    return read_at(read_->file.get(), path_of(segment), offset, into);
}

// The name is free then; its records are a gap.
Result<void> PosixJournalStorage::move_aside(const std::string& path) {
    TAKT_TRY(set_aside_, os::set_aside(path));
    folder_changed_ = true;
    return {};
}

Result<std::uint64_t> PosixJournalStorage::create(std::uint64_t segment) {
    if (written_) cut_at_size(written_->file.get());
    written_.reset();
    TAKT_CHECK(replace_removed_folder());
    folder_changed_ = true;
    TAKT_TRY(auto created, os::create_file(path_of(segment)));
    created.reset();
    TAKT_TRY(auto file, os::open_for_append(path_of(segment)));
    const auto reserved = reserve(file.get(), segment_bytes_);
    if (reserved == 0) return io_failure(path_of(segment));
    TAKT_CHECK(sync_folder());  // the removal of earlier segments too
    written_ = OpenSegment{segment, std::move(file)};
    return reserved;
}

Result<int> PosixJournalStorage::writable(std::uint64_t segment) {
    if (!written_ || written_->number != segment) {
        written_.reset();
        TAKT_TRY(auto file, os::open_for_update(path_of(segment)));
        cut_at_size(file.get());
        written_ = OpenSegment{segment, std::move(file)};
    }
    return written_->file.get();
}

Result<void> PosixJournalStorage::append(std::uint64_t segment, Bytes bytes) {
    if (!written_ || written_->number != segment) return fail(Code::not_found, path_of(segment));
    while (!bytes.empty()) {
        const auto put = ::write(written_->file.get(), bytes.data(), bytes.size());
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return io_failure(path_of(segment));
        bytes = bytes.subspan(static_cast<std::size_t>(put));
    }
    return {};
}

Result<void> PosixJournalStorage::sync(std::uint64_t segment) {
    TAKT_CHECK(sync_folder());
    TAKT_TRY(const int file, writable(segment));
    if (::fdatasync(file) != 0) return io_failure(path_of(segment));
    if (is_removed(file)) return fail(Code::io_failed, path_of(segment), ENOENT);
    return {};
}

Result<void> PosixJournalStorage::remove(std::uint64_t segment) {
    if (written_ && written_->number == segment) written_.reset();
    if (read_ && read_->number == segment) read_.reset();
    if (is_no_file(path_of(segment))) return move_aside(path_of(segment));
    if (::unlink(path_of(segment).c_str()) != 0 && errno != ENOENT) return io_failure(path_of(segment));
    return {};
}

Result<int> PosixJournalStorage::cursor(std::string_view destination, bool create) {
    if (const auto found = cursors_.find(destination); found != cursors_.end()) return found->second.get();
    if (is_no_file(path_of(destination))) TAKT_CHECK(move_aside(path_of(destination)));
    auto file = os::open_for_update(path_of(destination));
    const bool missing = !file && file.error().numbers[0] == ENOENT;
    if (missing && !create) return fail(Code::not_found, path_of(destination));
    if (missing) {
        folder_changed_ = true;
        file = os::create_file(path_of(destination));
    }
    if (!file) return std::unexpected(file.error());
    return cursors_.emplace(destination, *std::move(file)).first->second.get();
}

Result<std::size_t> PosixJournalStorage::read_cursor(std::string_view destination, unsigned slot,
                                                     std::span<std::uint8_t> into) {
    TAKT_TRY(const int file, cursor(destination, false));
    return read_at(file, path_of(destination), slot * kSlotOffset, into);
}

Result<void> PosixJournalStorage::write_cursor(std::string_view destination, unsigned slot, Bytes bytes) {
    TAKT_TRY(const int file, cursor(destination, true));
    return write_at(file, path_of(destination), slot * kSlotOffset, bytes);
}

Result<void> PosixJournalStorage::sync_cursor(std::string_view destination) {
    TAKT_TRY(const int file, cursor(destination, false));
    if (::fdatasync(file) != 0) return io_failure(path_of(destination));
    if (is_removed(file)) {
        cursors_.erase(cursors_.find(destination));
        return fail(Code::io_failed, path_of(destination), ENOENT);
    }
    return sync_folder();
}

// It is opened for each note, so that a file that was removed is created again.
Result<os::Descriptor> PosixJournalStorage::end_file(bool create) {
    const std::string path = directory_ + "/" + std::string(kEndName);
    if (is_no_file(path)) TAKT_CHECK(move_aside(path));
    auto file = os::open_for_update(path);
    const bool missing = !file && file.error().numbers[0] == ENOENT;
    if (missing && create) {
        folder_changed_ = true;
        return os::create_file(path);
    }
    if (missing) return os::Descriptor();
    return file;
}

Result<std::size_t> PosixJournalStorage::read_end(unsigned slot, std::span<std::uint8_t> into) {
    TAKT_TRY(const auto file, end_file(false));
    return file ? read_at(file.get(), directory_, slot * kEndOffset, into) : 0;
}

Result<void> PosixJournalStorage::write_end(unsigned slot, Bytes bytes) {
    TAKT_TRY(const auto file, end_file(true));
    return write_at(file.get(), directory_, slot * kEndOffset, bytes);
}

Result<void> PosixJournalStorage::sync_end() {
    TAKT_TRY(const auto file, end_file(false));
    if (file && ::fdatasync(file.get()) != 0) return io_failure(directory_);
    return {};
}

}  // namespace takt::store
