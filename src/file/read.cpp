#include "takt/file/read.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace takt::file {
namespace {

class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    [[nodiscard]] int number() const { return number_; }

private:
    int number_;
};

Result<void> check_kind(const struct stat& status, std::string_view path, std::size_t limit) {
    if (S_ISDIR(status.st_mode)) return fail(Code::cannot_open, path, EISDIR);
    if (!S_ISREG(status.st_mode)) return fail(Code::unsupported, path);
    if (static_cast<std::uintmax_t>(status.st_size) > limit)
        return fail(Code::too_long, path, status.st_size, static_cast<std::int64_t>(limit));
    return {};
}

// fstat() cannot be trusted: the file may grow, and files of /proc report size 0.
Result<std::string> read_bounded(int number, std::string_view path, std::size_t limit) {
    constexpr std::size_t kChunk = 64 << 10;
    std::string bytes;
    for (;;) {
        const auto there = bytes.size();
        bytes.resize(there + kChunk);
        const auto got = ::read(number, bytes.data() + there, kChunk);
        if (got < 0 && errno == EINTR) {
            bytes.resize(there);
            continue;
        }
        if (got < 0) return fail(Code::io_failed, path, errno);
        bytes.resize(there + static_cast<std::size_t>(got));
        if (bytes.size() > limit)
            return fail(Code::too_long, path, static_cast<std::int64_t>(bytes.size()),
                        static_cast<std::int64_t>(limit));
        if (got == 0) return bytes;
    }
}

}  // namespace

Result<std::string> read_file(const std::string& path, std::size_t limit) {
    if (path.find('\0') != std::string::npos) return fail(Code::cannot_open, path, ENOENT);
    // The type is checked before open(): opening a serial port toggles its modem lines, and opening a pipe
    // blocks until it has a writer.
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0) return fail(Code::cannot_open, path, errno);
    TAKT_CHECK(check_kind(status, path, limit));
    const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (descriptor.number() < 0) return fail(Code::cannot_open, path, errno);
    if (::fstat(descriptor.number(), &status) != 0) return fail(Code::io_failed, path, errno);
    TAKT_CHECK(check_kind(status, path, limit));
    return read_bounded(descriptor.number(), path, limit);
}

}  // namespace takt::file
