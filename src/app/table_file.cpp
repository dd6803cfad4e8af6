#include "takt/app/table_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "takt/app/console.hpp"
#include "takt/file/read.hpp"
#include "takt/table/format.hpp"

namespace takt::app {
namespace {

Result<void> write_all(int descriptor, const std::string& path, const table::Image& image) {
    std::size_t written = 0;
    while (written < image.size()) {
        const auto count = ::write(descriptor, image.data() + written, image.size() - written);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return fail(Code::io_failed, path, errno);
        written += static_cast<std::size_t>(count);
    }
    if (::fsync(descriptor) != 0 && errno != EINVAL) return fail(Code::io_failed, path, errno);
    return {};
}

}  // namespace

std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path) {
    const auto text = file::read_file(path, table::kMaxImage);
    if (!text) {
        print_error(texts.describe(text.error()));
        return std::nullopt;
    }
    TableFile read;
    read.image.assign(text->begin(), text->end());
    read.owen = text->starts_with(table::kOwenMagic);
    return read;
}

Result<void> write_table_file(const std::string& path, const table::Image& image) {
    const std::string temporary = path + ".new-" + std::to_string(::getpid());
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
    if (descriptor < 0) return fail(Code::cannot_open, path, errno);
    auto written = write_all(descriptor, path, image);
    if (::close(descriptor) != 0 && written) written = fail(Code::io_failed, path, errno);
    if (written && std::rename(temporary.c_str(), path.c_str()) != 0)
        written = fail(Code::io_failed, path, errno);
    if (!written) ::unlink(temporary.c_str());
    return written;
}

}  // namespace takt::app
