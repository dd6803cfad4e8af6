#include "takt/os/rotation.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "takt/os/open.hpp"

namespace takt::os {
namespace {

bool is_there(const std::string& path) {
    struct stat status{};
    return ::lstat(path.c_str(), &status) == 0 || errno != ENOENT;
}

// Renumbers up to the first gap only: an attempt that fails later must not cost an old file each time.
Result<void> free_first_number(unsigned old_files, const NumberedName& name) {
    unsigned last = 1;
    while (last < old_files && is_there(name(last))) ++last;
    for (unsigned number = last; --number > 0;)
        if (std::rename(name(number).c_str(), name(number + 1).c_str()) != 0)
            return fail(Code::io_failed, name(number), errno);
    if (::unlink(name(1).c_str()) != 0 && errno != ENOENT) return fail(Code::io_failed, name(1), errno);
    return {};
}

}  // namespace

Result<Descriptor> begin_next_file(int current, unsigned old_files, const NumberedName& name) {
    const std::string path = name(0);
    if (!is_there(path)) return open_anew(path);
    if (!is_at(current, path)) return fail(Code::replaced, path);
    if (old_files == 0) {
        Descriptor emptied(::fcntl(current, F_DUPFD_CLOEXEC, 0));
        if (!emptied || ::ftruncate(current, 0) != 0) return fail(Code::io_failed, path, errno);
        return emptied;
    }
    TAKT_CHECK(free_first_number(old_files, name));
    const std::string full = name(1);
    TAKT_TRY(auto empty, open_anew(full));
    if (::renameat2(AT_FDCWD, full.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) return empty;
    if (std::rename(path.c_str(), full.c_str()) == 0) return open_anew(path);
    const int error = errno;
    ::unlink(full.c_str());
    return fail(Code::io_failed, path, error);
}

}  // namespace takt::os
