#include "takt/os/file_exchange.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <optional>
#include <utility>

#include "takt/os/open.hpp"
#include "takt/os/replace.hpp"

namespace takt::os {
namespace {

constexpr int kMostExchanges = 16;
constexpr int kMostConflicts = 1000;

/// Device and inode.
using Identity = std::pair<::dev_t, ::ino_t>;

std::optional<struct stat> status_of(const std::string& path) {
    struct stat status{};
    if (::lstat(path.c_str(), &status) != 0) return std::nullopt;
    return status;
}

std::optional<Identity> identity_of(const std::string& path) {
    const auto status = status_of(path);
    return status ? std::optional(Identity{status->st_dev, status->st_ino}) : std::nullopt;
}

/// A file that cannot be read, or is a link, has other contents.
bool has_contents(const std::string& path, std::string_view bytes) {
    const auto status = status_of(path);
    if (!status || !S_ISREG(status->st_mode)) return false;
    const auto file = open_for_reading(path);
    if (!file) return false;
    const auto contents = read_all(file->get(), path, bytes.size());
    return contents && *contents == bytes;
}

bool cannot_exchange(int error) {
    return error == EINVAL || error == ENOSYS || error == EOPNOTSUPP;
}

/// One replacement. `temporary` is a name of its own beside the path, at first of the new contents.
class Exchange {
public:
    Exchange(const std::string& path, std::string temporary, std::string_view bytes,
             const ExchangeOptions& options)
        : path_(path), temporary_(std::move(temporary)), bytes_(bytes), options_(options) {}

    Result<Exchanged> run(std::string_view expected) {
        const int error = options_.exchange(temporary_, path_);
        if (cannot_exchange(error)) return take_away(expected);
        if (error != 0) return give_up(error);
        if (has_contents(temporary_, expected))
            finish(temporary_);
        else
            put_back();
        return std::move(done_);
    }

private:
    /// Nothing has happened to the file. One that another program removed was changed.
    Result<Exchanged> give_up(int error) {
        ::unlink(temporary_.c_str());
        if (error == ENOENT) return std::move(done_);
        return fail(Code::io_failed, path_, error);
    }

    void finish(const std::string& old_file) {
        done_.replaced = true;
        done_.backup = path_ + "~";
        if (std::rename(old_file.c_str(), done_.backup.c_str()) != 0) done_.backup = set_aside(old_file);
    }

    // Each turn puts the newest foreign file at the path. The turn that displaces the file which this program
    // put there itself is the last one. An older foreign file was replaced by a program that may not have
    // seen it, so it is kept.
    void put_back() {
        std::optional<Identity> ours;  // none: the new contents
        for (int i = 0; i < kMostExchanges; ++i) {
            const auto foreign = identity_of(temporary_);
            if (options_.exchange(temporary_, path_) != 0) break;
            if (!ours && has_contents(temporary_, bytes_)) {
                ::unlink(temporary_.c_str());
                return;
            }
            if (ours && identity_of(temporary_) == ours) break;
            ours = foreign;
        }
        done_.kept.push_back(set_aside(temporary_));
    }

    Result<Exchanged> take_away(std::string_view expected) {
        const auto aside = reserve_conflict();
        if (aside.empty()) return give_up(EEXIST);
        if (std::rename(path_.c_str(), aside.c_str()) != 0) {
            const int error = errno;
            ::unlink(aside.c_str());
            return give_up(error);
        }
        const bool known = has_contents(aside, expected);
        const int error = rename_to_free(known ? temporary_ : aside, path_);
        if (known && error == 0) {
            finish(aside);
            return std::move(done_);
        }
        // EEXIST: another program has created the file meanwhile.
        if (error != 0 && (error == EEXIST || rename_to_free(aside, path_) != 0)) done_.kept.push_back(aside);
        return give_up(!known || error == EEXIST ? ENOENT : error);
    }

    /// An empty file of this program under a free name; empty: no name is free, or none can be created.
    [[nodiscard]] std::string reserve_conflict() const {
        for (int i = 1; i <= kMostConflicts; ++i) {
            auto name = path_ + ".conflict" + (i == 1 ? "" : "." + std::to_string(i));
            const auto created = create_file(name);
            if (created) return name;
            if (created.error().numbers[0] != EEXIST) break;
        }
        return {};
    }

    /// @returns the name under which the file is kept; without a free one its temporary name
    [[nodiscard]] std::string set_aside(const std::string& file) const {
        auto name = reserve_conflict();
        if (name.empty()) return file;
        if (std::rename(file.c_str(), name.c_str()) == 0) return name;
        ::unlink(name.c_str());
        return file;
    }

    const std::string& path_;
    const std::string temporary_;
    const std::string_view bytes_;
    const ExchangeOptions& options_;
    Exchanged done_;
};

}  // namespace

int exchange_names(const std::string& first, const std::string& second) {
    return ::renameat2(AT_FDCWD, first.c_str(), AT_FDCWD, second.c_str(), RENAME_EXCHANGE) == 0 ? 0 : errno;
}

Result<Exchanged> exchange_file(const std::string& path, std::string_view bytes, std::string_view expected,
                                const ExchangeOptions& options) {
    TAKT_TRY(auto replacement, FileReplacement::begin(path, {}));
    const auto backup = replacement.path() + "~";
    const auto old_backup = status_of(backup);
    if (old_backup && S_ISDIR(old_backup->st_mode)) return fail(Code::cannot_open, backup, EISDIR);
    if (!write_all(replacement.descriptor(), bytes)) return fail(Code::io_failed, path, errno);
    TAKT_TRY(auto temporary, replacement.release());
    TAKT_TRY(auto done, Exchange(replacement.path(), std::move(temporary), bytes, options).run(expected));
    if (done.replaced || !done.kept.empty()) TAKT_CHECK(replacement.sync_names());
    return done;
}

}  // namespace takt::os
