#include "takt/store/block_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>
#include <vector>

#include "takt/os/open.hpp"

namespace takt::store {
namespace {

class RealFile final : public BlockFile {
public:
    RealFile(os::Descriptor file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}

    Result<std::uint64_t> size() override {
        struct stat status{};
        if (::fstat(file_.get(), &status) != 0) return failed();
        return static_cast<std::uint64_t>(status.st_size);
    }

    Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) override {
        std::size_t done = 0;
        while (done < into.size()) {
            const auto got = ::pread(file_.get(), into.data() + done, into.size() - done,
                                     static_cast<off_t>(offset + done));
            if (got < 0 && errno == EINTR) continue;
            if (got < 0) return failed();
            if (got == 0)
                return fail(Code::too_short, path_, static_cast<std::int64_t>(offset + done),
                            static_cast<std::int64_t>(offset + into.size()));
            done += static_cast<std::size_t>(got);
        }
        return {};
    }

    Result<void> write_at(std::uint64_t offset, Bytes bytes) override {
        std::size_t done = 0;
        while (done < bytes.size()) {
            const auto put = ::pwrite(file_.get(), bytes.data() + done, bytes.size() - done,
                                      static_cast<off_t>(offset + done));
            if (put < 0 && errno == EINTR) continue;
            if (put <= 0) return failed();
            done += static_cast<std::size_t>(put);
        }
        return {};
    }

    Result<void> sync() override {
        if (::fdatasync(file_.get()) != 0) return failed();
        if (named_ && !os::is_at(file_.get(), path_)) return fail(Code::replaced, path_);
        return {};
    }

    /// @returns busy
    Result<void> lock() {
        if (::flock(file_.get(), LOCK_EX | LOCK_NB) != 0) return fail(Code::busy, path_, errno);
        return {};
    }
    /// From now on the file is the one of its path.
    void set_named() { named_ = true; }
    Result<void> reserve(std::uint64_t size) {
        if (const int error = ::posix_fallocate(file_.get(), 0, static_cast<off_t>(size)); error != 0)
            return fail(Code::io_failed, path_, error);
        return {};
    }

private:
    [[nodiscard]] std::unexpected<Error> failed() const { return fail(Code::io_failed, path_, errno); }

    os::Descriptor file_;
    std::string path_;
    bool named_ = false;  // else it still has a temporary name
};

bool is_link(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 && S_ISLNK(status.st_mode);
}

/// Whether a temporary file was left by an earlier run: it is empty, zeros, or begins with our mark.
Result<bool> is_unfinished(BlockFile& file, std::string_view mark) {
    TAKT_TRY(const auto size, file.size());
    std::vector<std::uint8_t> head(std::min<std::uint64_t>(size, mark.size()));
    TAKT_CHECK(file.read_at(0, head));
    const bool zeros = std::ranges::all_of(head, [](std::uint8_t byte) { return byte == 0; });
    return zeros || std::string_view(reinterpret_cast<const char*>(head.data()), head.size()) == mark;
}

std::unique_ptr<RealFile> duplicate(int descriptor, const std::string& path) {
    return std::make_unique<RealFile>(os::Descriptor(::fcntl(descriptor, F_DUPFD_CLOEXEC, 0)), path);
}

}  // namespace

Result<std::unique_ptr<BlockFile>> open_block_file(const std::string& path) {
    auto opened = os::open_for_update(path);
    // A link to nowhere exists and must not be replaced.
    if (!opened && opened.error().numbers[0] == ENOENT && !is_link(path))
        return fail(Code::not_found, path, ENOENT);
    if (!opened) return std::unexpected(opened.error());
    auto file = std::make_unique<RealFile>(*std::move(opened), path);
    TAKT_CHECK(file->lock());
    file->set_named();
    return file;
}

NewBlockFile::NewBlockFile(os::FileReplacement replacement, std::unique_ptr<BlockFile> file)
    : replacement_(std::move(replacement)), file_(std::move(file)) {}

Result<NewBlockFile> NewBlockFile::make(const std::string& path, std::uint64_t size, std::string_view mark) {
    const auto may_overwrite = [&path, mark](int descriptor) {
        return is_unfinished(*duplicate(descriptor, path), mark);
    };
    TAKT_TRY(auto replacement, os::FileReplacement::begin(path, {.mode = os::kStateFileMode,
                                                                 .replace = true,
                                                                 .temporary_suffix = ".new",
                                                                 .may_overwrite = may_overwrite,
                                                                 .lock = true}));
    auto file = duplicate(replacement.descriptor(), path);
    TAKT_CHECK(file->reserve(size));
    return NewBlockFile(std::move(replacement), std::move(file));
}

Result<std::unique_ptr<BlockFile>> NewBlockFile::publish() {
    TAKT_CHECK(replacement_.commit());
    static_cast<RealFile&>(*file_).set_named();
    return std::move(file_);
}

}  // namespace takt::store
