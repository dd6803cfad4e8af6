#include "takt/file/write.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace takt::file {
namespace {

constexpr ::mode_t kUsual = 0666;
constexpr int kNames = 100;

// The new file next to its target. It is removed at the end unless it was moved there.
class Draft {
public:
    Draft(std::string path, int number) : path_(std::move(path)), number_(number) {}
    ~Draft() {
        if (number_ >= 0) ::close(number_);
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    Draft(const Draft&) = delete;
    Draft& operator=(const Draft&) = delete;

    [[nodiscard]] const std::string& path() const { return path_; }
    [[nodiscard]] int number() const { return number_; }
    void moved() { path_.clear(); }

private:
    std::string path_;
    int number_;
};

bool write_all(int number, std::string_view bytes) {
    while (!bytes.empty()) {
        const auto written = ::write(number, bytes.data(), bytes.size());
        if (written < 0 && errno != EINTR) return false;
        if (written > 0) bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return true;
}

// The file behind a chain of symbolic links. The links themselves stay.
std::string real_path(const std::string& path) {
    std::error_code trouble;
    const auto real = std::filesystem::canonical(path, trouble);
    return trouble ? path : real.string();
}

Result<void> check_place(const std::string& path, bool replace, struct ::stat& status, bool& there) {
    there = ::stat(path.c_str(), &status) == 0;
    if (!there && errno != ENOENT) return fail(Code::cannot_open, path, errno);
    if (!there) return {};
    if (S_ISDIR(status.st_mode)) return fail(Code::cannot_open, path, EISDIR);
    if (!S_ISREG(status.st_mode)) return fail(Code::unsupported, path);
    if (!replace) return fail(Code::cannot_open, path, EEXIST);
    if (::access(path.c_str(), W_OK) != 0) return fail(Code::cannot_open, path, errno);
    return {};
}

void sync_folder(const std::string& path) {
    auto folder = std::filesystem::path(path).parent_path().string();
    if (folder.empty()) folder = ".";
    const int number = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (number < 0) return;
    ::fsync(number);
    ::close(number);
}

}  // namespace

Result<void> write_file(const std::string& path, std::string_view bytes, bool replace) {
    if (path.empty() || path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    struct ::stat status{};
    bool there = false;
    TAKT_CHECK(check_place(path, replace, status, there));
    const auto target = there ? real_path(path) : path;
    std::string name;
    int number = -1;
    for (int i = 0; i < kNames && number < 0; ++i) {
        name = fmt::format("{}.{}-{}.new", target, ::getpid(), i);
        number = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOCTTY | O_CLOEXEC, kUsual);
        if (number < 0 && errno != EEXIST) return fail(Code::cannot_open, path, errno);
    }
    if (number < 0) return fail(Code::cannot_open, path, errno);
    Draft draft(name, number);
    if (there && ::fchmod(number, status.st_mode & 07777) != 0) return fail(Code::io_failed, path, errno);
    if (!write_all(number, bytes) || ::fsync(number) != 0) return fail(Code::io_failed, path, errno);
    const unsigned flags = replace ? 0 : RENAME_NOREPLACE;
    if (::renameat2(AT_FDCWD, name.c_str(), AT_FDCWD, target.c_str(), flags) != 0) {
        // The file system has no RENAME_NOREPLACE. link() refuses an existing name as well.
        if (errno != EINVAL || ::link(name.c_str(), target.c_str()) != 0)
            return fail(Code::cannot_open, path, errno);
        sync_folder(target);
        return {};
    }
    draft.moved();
    sync_folder(target);
    return {};
}

}  // namespace takt::file
