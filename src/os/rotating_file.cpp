#include "takt/os/rotating_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "takt/os/rotation.hpp"

namespace takt::os {

RotatingFile::RotatingFile(std::string path, const Options& options)
    : path_(std::move(path)), options_(options), limit_(options.file_bytes) {}

Result<std::unique_ptr<RotatingFile>> RotatingFile::open(const std::string& path, const Options& options) {
    auto opened = std::unique_ptr<RotatingFile>(new RotatingFile(path, options));
    TAKT_CHECK(opened->reopen());
    return opened;
}

Result<void> RotatingFile::reopen() {
    TAKT_TRY(file_, options_.anew ? open_anew(path_, options_.mode) : open_for_append(path_, options_.mode));
    struct stat status{};
    if (::fstat(file_.get(), &status) != 0) return fail(Code::io_failed, path_, errno);
    size_ = static_cast<std::size_t>(status.st_size);
    return {};
}

std::string RotatingFile::numbered(unsigned number) const {
    return number == 0 ? path_ : path_ + "." + std::to_string(number);
}

// A file whose successor cannot begin goes on.
void RotatingFile::begin_next() {
    auto next = begin_next_file(file_.get(), options_.old_files, [this](unsigned i) { return numbered(i); });
    limit_ = options_.file_bytes + (next ? 0 : size_);
    const bool failed_before = std::exchange(rotation_failed_, !next);
    if (!next) {
        if (!failed_before && options_.on_not_rotated) options_.on_not_rotated(next.error());
        return;
    }
    file_ = *std::move(next);
    size_ = 0;
}

void RotatingFile::rotate() {
    std::error_code unknown;  // is no link
    if (std::filesystem::is_symlink(path_, unknown)) return;
    if (options_.anew) return begin_next();
    if (options_.old_files == 0) {
        if (::ftruncate(file_.get(), 0) == 0) size_ = 0;
        return;
    }
    file_.reset();
    for (unsigned i = options_.old_files; i-- > 0;)
        (void)std::rename(numbered(i).c_str(), numbered(i + 1).c_str());
    (void)reopen();  // write() tries again
}

// The end of the lines from `begin` that fit into one file: all of them, or as many as do, or one long line.
std::size_t RotatingFile::piece_end(std::string_view text, std::size_t begin) const {
    if (text.size() - begin <= options_.file_bytes) return text.size();
    const std::size_t fitting = text.rfind('\n', begin + options_.file_bytes - 1);
    if (fitting != std::string_view::npos && fitting >= begin) return fitting + 1;
    const std::size_t line = text.find('\n', begin);
    return line == std::string_view::npos ? text.size() : line + 1;
}

// Removes the part of a line that was written, so that the next line starts at a line's beginning.
Sink::Written RotatingFile::failed(std::string_view text, std::size_t done, int error) {
    std::size_t whole = done;
    while (whole > 0 && text[whole - 1] != '\n') --whole;
    if (whole < done && ::ftruncate(file_.get(), static_cast<off_t>(size_ - (done - whole))) == 0)
        size_ -= done - whole;
    return {.bytes = whole, .error = error, .closed = false};
}

Sink::Written RotatingFile::write(std::string_view text) {
    std::size_t done = 0;
    while (done < text.size()) {
        if (file_ && size_ > 0 && size_ + (text.size() - done) > limit_) rotate();
        if (!file_) {
            if (const auto opened = reopen(); !opened)
                return failed(text, done, static_cast<int>(opened.error().numbers[0]));
        }
        const std::size_t end = piece_end(text, done);
        while (done < end) {
            const auto count = ::write(file_.get(), text.data() + done, end - done);
            if (count < 0 && errno == EINTR) continue;
            if (count <= 0) return failed(text, done, count < 0 ? errno : EIO);
            done += static_cast<std::size_t>(count);
            size_ += static_cast<std::size_t>(count);
        }
    }
    return {.bytes = done, .error = 0, .closed = false};
}

}  // namespace takt::os
