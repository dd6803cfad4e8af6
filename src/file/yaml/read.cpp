#include "takt/file/read.hpp"

#include <sys/stat.h>

#include <cstdint>

#include "takt/os/open.hpp"

namespace takt::file {

namespace {

Result<os::Descriptor> open_within(const std::string& path, std::size_t limit) {
    TAKT_TRY(os::Descriptor file, os::open_for_reading(path));
    struct stat status{};
    if (::fstat(file.get(), &status) == 0 && static_cast<std::uintmax_t>(status.st_size) > limit)
        return fail(Code::too_long, path, status.st_size, static_cast<std::int64_t>(limit));
    return file;
}

}  // namespace

Result<void> check_readable(const std::string& path, std::size_t limit) {
    TAKT_CHECK(open_within(path, limit));
    return {};
}

Result<std::string> read_file(const std::string& path, std::size_t limit) {
    TAKT_TRY(const os::Descriptor file, open_within(path, limit));
    return os::read_all(file.get(), path, limit);
}

}  // namespace takt::file
