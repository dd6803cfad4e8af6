#include "takt/store/retained.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include "database.hpp"
#include "retained_rows.hpp"

namespace takt::store {
namespace {

constexpr auto kRetryAfter = std::chrono::seconds(1);
constexpr int kMostSetAside = 999;

// Of a database's header: how it begins, and the number of the program it belongs to.
constexpr std::string_view kMark("SQLite format 3\0", 16);
constexpr std::size_t kApplicationAt = 68;
constexpr std::string_view kApplicationMark = "Takt";

// The file is whole whenever no transaction is under way, so that it can be copied and read without a second
// one beside it; and a lost tail of a write-ahead log would not be noticed.
constexpr const char* kSettings =
    "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = TRUNCATE; PRAGMA synchronous = FULL;"
    "PRAGMA cell_size_check = ON; BEGIN EXCLUSIVE; COMMIT";

bool is_there(const std::string& path) {
    std::error_code error;
    return std::filesystem::exists(path, error);
}

/// The journal belongs to the file: it may hold half of it.
Result<std::string> set_aside(const std::string& path) {
    for (int i = 1; i <= kMostSetAside; ++i) {
        const std::string aside = path + ".damaged-" + std::to_string(i);
        if (is_there(aside)) continue;
        std::error_code error;
        std::filesystem::rename(path, aside, error);
        if (error) return fail(Code::io_failed, path, error.value());
        std::filesystem::rename(path + "-journal", aside + "-journal", error);
        return aside;
    }
    return fail(Code::queue_full, path, kMostSetAside);
}

/// SQLite tells that it cannot open a file, not always why.
Error opening_error(const std::string& path, Error error) {
    error.subject = std::string_view(path);
    if (error.code != Code::cannot_open && error.code != Code::io_failed) return error;
    const bool there = is_there(path);
    const int fd =
        ::open(path.c_str(), there ? O_RDWR | O_CLOEXEC : O_RDWR | O_CLOEXEC | O_CREAT | O_EXCL, 0644);
    if (fd < 0) return fail(Code::cannot_open, path, errno).error();
    ::close(fd);
    if (!there) ::unlink(path.c_str());
    return error;
}

/// What a file begins with tells whose it is, whatever became of the rest. Nothing of another program, and no
/// device or pipe, may be moved or opened for writing.
/// @returns unsupported
Result<void> check_ours(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (std::filesystem::is_directory(status)) return {};  // opening it tells
    if (!std::filesystem::exists(status)) return fail(Code::cannot_open, path, ENOENT);
    if (!std::filesystem::is_regular_file(status)) return fail(Code::unsupported, path);
    std::array<char, kApplicationAt + 4> head{};
    std::ifstream file(path, std::ios::binary);
    if (!file) return {};
    file.read(head.data(), head.size());
    const std::string_view there(head.data(), static_cast<std::size_t>(file.gcount()));
    if (!there.starts_with(kMark)) return fail(Code::unsupported, path);
    if (there.size() == head.size() && there.substr(kApplicationAt) != kApplicationMark)
        return fail(Code::unsupported, path);
    return {};
}

struct Loaded {
    std::optional<Database> database;
    std::vector<Retained> values;
};

Result<Loaded> load(const std::string& path) {
    TAKT_CHECK(check_ours(path));
    TAKT_TRY(Database database, Database::open(path, false));
    TAKT_CHECK(database.execute(kSettings));
    Loaded loaded;
    TAKT_TRY(loaded.values, read_rows(database, path));
    loaded.database = std::move(database);
    return loaded;
}

/// Under another name until it is whole: a file of that name is never a half-made one, and never replaces one
/// that another program has just made.
Result<void> make(const std::string& path) {
    const std::string unfinished = path + ".new-" + std::to_string(::getpid());
    std::error_code error;
    {
        TAKT_TRY(Database database, Database::open(unfinished, false));
        TAKT_CHECK(database.execute(kSettings));
        TAKT_CHECK(make_table(database));
    }
    std::filesystem::create_hard_link(unfinished, path, error);
    const bool made = !error || error == std::errc::file_exists;
    const int reason = error.value();
    for (const auto* ending : {"", "-journal"}) std::filesystem::remove(unfinished + ending, error);
    if (!made) return fail(Code::io_failed, path, reason);
    return {};
}

bool is_empty_file(const std::string& path) {
    std::error_code error;
    return std::filesystem::file_size(path, error) == 0 && !error;
}

}  // namespace

struct RetainedFile::Impl {
    Impl(Database opened, std::function<void()> told)
        : database(std::move(opened)), on_progress(std::move(told)), thread([this] { work(); }) {}
    ~Impl() { stop(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    void stop() {
        {
            const std::lock_guard lock(mutex);
            stopping = true;
        }
        wake.notify_one();
        if (thread.joinable()) thread.join();
    }
    void work();
    void note(std::uint64_t ticket, const Result<void>& written, std::map<std::string, Retained>& batch);

    Database database;  // of the thread alone
    std::function<void()> on_progress;
    mutable std::mutex mutex;
    std::condition_variable wake;
    std::map<std::string, Retained> waiting;
    std::uint64_t last_ticket = 0;
    Progress progress;
    bool stopping = false;
    std::thread thread;  // last: it uses all the others
};

void RetainedFile::Impl::work() {
    std::unique_lock lock(mutex);
    for (;;) {
        wake.wait(lock, [this] { return stopping || !waiting.empty(); });
        if (waiting.empty()) return;
        const bool last = stopping;
        auto batch = std::exchange(waiting, {});
        const std::uint64_t ticket = last_ticket;
        lock.unlock();
        const auto written = write_rows(database, batch);
        lock.lock();
        note(ticket, written, batch);
        lock.unlock();
        if (on_progress) on_progress();
        lock.lock();
        if (!written && last) return;
        if (!written) wake.wait_for(lock, kRetryAfter, [this] { return stopping; });
    }
}

void RetainedFile::Impl::note(std::uint64_t ticket, const Result<void>& written,
                              std::map<std::string, Retained>& batch) {
    if (written) {
        progress.durable = ticket;
        return;
    }
    progress.failed = ticket;
    progress.why = written.error();
    waiting.merge(batch);  // what came meanwhile under the same name stays
}

RetainedFile::RetainedFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

RetainedFile::~RetainedFile() = default;

void RetainedFile::close() {
    impl_->stop();
}

Result<RetainedFile::Opened> RetainedFile::open(const std::string& path, std::function<void()> on_progress) {
    Opened opened;
    const auto make_and_load = [&path]() -> Result<Loaded> {
        TAKT_CHECK(make(path));
        return load(path);
    };
    // An existing file of no length is one that lost its contents.
    auto loaded = !is_there(path)       ? make_and_load()
                  : is_empty_file(path) ? Result<Loaded>(fail(Code::malformed, path))
                                        : load(path);
    if (!loaded && loaded.error().code == Code::malformed) {
        TAKT_TRY(opened.set_aside, set_aside(path));
        loaded = make_and_load();
    }
    if (!loaded) return std::unexpected(opening_error(path, loaded.error()));
    opened.values = std::move(loaded->values);
    opened.file = std::unique_ptr<RetainedFile>(
        new RetainedFile(std::make_unique<Impl>(std::move(*loaded->database), std::move(on_progress))));
    return opened;
}

Result<std::vector<Retained>> RetainedFile::read(const std::string& path) {
    if (!is_there(path)) return fail(Code::not_found, path);
    TAKT_CHECK(check_ours(path));
    TAKT_TRY(Database database, Database::open(path, true));
    return read_rows(database, path);
}

std::uint64_t RetainedFile::put(Retained entry) {
    std::uint64_t ticket = 0;
    {
        const std::lock_guard lock(impl_->mutex);
        ticket = ++impl_->last_ticket;
        auto key = entry.name;
        impl_->waiting.insert_or_assign(std::move(key), std::move(entry));
    }
    impl_->wake.notify_one();
    return ticket;
}

Progress RetainedFile::progress() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->progress;
}

}  // namespace takt::store
