#include "takt/store/retained.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <utility>

#include "registers/database.hpp"
#include "registers/retained_rows.hpp"
#include "takt/os/open.hpp"
#include "takt/os/replace.hpp"
#include "takt/os/set_aside.hpp"
#include "takt/os/worker.hpp"

namespace takt::store {
namespace {

constexpr auto kRetryAfter = std::chrono::seconds(1);

// Of a database's header: the number of the program that it belongs to.
constexpr std::size_t kApplicationAt = 68;
constexpr std::string_view kApplicationMark = "Takt";
constexpr std::size_t kFirstSectorBytes = 512;

// With a rollback journal the file is complete whenever no transaction is open: it can be copied and read
// without a second file. A lost tail of a write-ahead log would not be noticed.
constexpr const char* kRetainedSettings =
    "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = TRUNCATE; PRAGMA synchronous = FULL;"
    "PRAGMA cell_size_check = ON; BEGIN EXCLUSIVE; COMMIT";

/// SQLite reports that it cannot open a file, but not always why. The file is opened once more to find out.
Error opening_error(const std::string& path, Error error) {
    error.subject = std::string_view(path);
    if (error.code != Code::cannot_open && error.code != Code::io_failed) return error;
    const bool there = file_exists(path);
    const auto opened = there ? os::open_for_update(path) : os::create_file(path);
    if (!opened) return opened.error();
    if (!there) ::unlink(path.c_str());
    return error;
}

/// Checks from its first bytes that a file is ours; the rest may be damaged. A file of another program, a
/// device or a pipe must be neither moved nor opened for writing.
/// @returns malformed (a lost or cut-off first sector), unsupported; cannot_open where there is no file
Result<void> check_ours(const std::string& path) {
    const auto file = os::open_for_reading(path);
    if (!file && (file.error().code == Code::unsupported || file.error().numbers[0] == ENOENT))
        return std::unexpected(file.error());
    if (!file) return {};  // opening the database reports it
    std::array<char, kFirstSectorBytes> head{};
    const auto count = ::pread(file->get(), head.data(), head.size(), 0);
    const std::string_view there(head.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
    const bool zeros = there.find_first_not_of('\0') == std::string_view::npos;
    if (zeros || kDatabaseMark.starts_with(there)) return fail(Code::malformed, path);
    if (!there.starts_with(kDatabaseMark)) return fail(Code::unsupported, path);
    const auto application = there.substr(std::min(kApplicationAt, there.size()), kApplicationMark.size());
    if (application.size() == kApplicationMark.size() && application != kApplicationMark)
        return fail(Code::unsupported, path);
    return {};
}

struct LoadedValues {
    std::unique_ptr<SQLite::Database> database;
    std::vector<Retained> values;
};

Result<LoadedValues> load_retained_file(const std::string& path) {
    TAKT_CHECK(check_ours(path));
    LoadedValues loaded;
    TAKT_CHECK(with_results(path, nullptr, [&]() -> Result<void> {
        loaded.database = std::make_unique<SQLite::Database>(open_database(path, false));
        return {};
    }));
    TAKT_CHECK(with_results(path, loaded.database.get(), [&]() -> Result<void> {
        loaded.database->exec(kRetainedSettings);
        TAKT_TRY(loaded.values, read_rows(*loaded.database, path));
        return {};
    }));
    return loaded;
}

/// Creates an empty file of retained values. It is written under a temporary name, so that a file under
/// `path` is always complete. A file that another program creates meanwhile is left alone.
Result<void> make_retained_file(const std::string& path) {
    const auto exists = [](const Error& error) { return error.numbers[0] == EEXIST; };
    auto file = os::FileReplacement::begin(path, {.mode = os::kStateFileMode, .replace = false});
    if (!file && exists(file.error())) return {};
    if (!file) return std::unexpected(file.error());
    const std::string unfinished = file->temporary();
    auto made = with_results(path, nullptr, [&unfinished]() -> Result<void> {
        auto database = open_database(unfinished, false);
        database.exec(kRetainedSettings);
        make_tables(database);
        return {};
    });
    ::unlink((unfinished + "-journal").c_str());
    if (made) made = file->commit();
    if (!made && exists(made.error())) return {};
    return made;
}

bool is_empty_file(const std::string& path) {
    std::error_code error;
    return std::filesystem::file_size(path, error) == 0 && !error;
}

}  // namespace

// The writing runs as a job of the worker: at once, or after a pause when the last attempt failed. At most
// one such job waits; it takes all entries that have come until it starts.
struct RetainedFile::Impl {
    Impl(std::unique_ptr<SQLite::Database> opened, std::string file, std::function<void()> notify)
        : database(std::move(opened)), path(std::move(file)), on_progress(std::move(notify)) {
        if (const auto found = contents_of(*database, path)) contents = *found;
    }
    ~Impl() { stop(); }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;

    std::uint64_t put(Retained entry);
    void stop();

    // The worker's thread.
    void write();
    Result<void> write_transaction(const std::map<std::string, Retained>& batch);
    void note(std::uint64_t ticket, const Result<void>& written, std::map<std::string, Retained>& batch);

    const std::unique_ptr<SQLite::Database> database;  // the worker's
    std::optional<FileContents> contents;              // the worker's; nothing: unknown after a failure
    const std::string path;
    const std::function<void()> on_progress;
    mutable std::mutex mutex;
    std::map<std::string, Retained> waiting;
    std::uint64_t last_ticket = 0;
    Progress progress;
    bool scheduled = false;                     // write() is posted or runs
    os::Worker worker{{.name = "takt-store"}};  // last: it uses all the others
};

std::uint64_t RetainedFile::Impl::put(Retained entry) {
    const std::lock_guard lock(mutex);
    auto key = entry.name;
    waiting.insert_or_assign(std::move(key), std::move(entry));
    if (!scheduled) scheduled = worker.post([this] { write(); });
    return ++last_ticket;
}

void RetainedFile::Impl::stop() {
    // One attempt for what is left, also where the last one failed.
    worker.post([this] { write(); });
    worker.finish();
}

void RetainedFile::Impl::write() {
    std::unique_lock lock(mutex);
    scheduled = !waiting.empty();
    if (!scheduled) return;
    auto batch = std::exchange(waiting, {});
    const std::uint64_t ticket = last_ticket;
    lock.unlock();
    const auto written = with_results(path, database.get(), [&] { return write_transaction(batch); });
    lock.lock();
    note(ticket, written, batch);
    lock.unlock();
    if (on_progress) on_progress();
    lock.lock();
    const auto next = os::Worker::Clock::now() + (written ? std::chrono::seconds(0) : kRetryAfter);
    scheduled = !waiting.empty() && worker.post_at(next, [this] { write(); });
}

// SQLite does not read its pages again while it has the file locked. It would write a few pages into a file
// that another program has emptied, and report success.
Result<void> RetainedFile::Impl::write_transaction(const std::map<std::string, Retained>& batch) {
    // Also before the transaction: its journal would belong to the file that is at the path now.
    TAKT_CHECK(check_unmoved(*database, path));
    TAKT_TRY(const FileContents found, contents_of(*database, path));
    if (contents && found != *contents) return fail(Code::replaced, path);
    contents.reset();
    write_rows(*database, batch);
    TAKT_TRY(contents, contents_of(*database, path));
    return check_unmoved(*database, path);
}

void RetainedFile::Impl::note(std::uint64_t ticket, const Result<void>& written,
                              std::map<std::string, Retained>& batch) {
    if (written) {
        progress.durable = ticket;
        return;
    }
    progress.failed = ticket;
    progress.why = written.error();
    waiting.merge(batch);  // a newer entry of the same name stays
}

RetainedFile::RetainedFile(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

RetainedFile::~RetainedFile() = default;

void RetainedFile::close() {
    impl_->stop();
}

Result<RetainedFile::Opened> RetainedFile::open(const std::string& path, std::function<void()> on_progress) {
    Opened opened;
    const auto make_and_load = [&path]() -> Result<LoadedValues> {
        TAKT_CHECK(make_retained_file(path));
        return load_retained_file(path);
    };
    // An existing file of no length is one that lost its contents.
    auto loaded = !file_exists(path)    ? make_and_load()
                  : is_empty_file(path) ? Result<LoadedValues>(fail(Code::malformed, path))
                                        : load_retained_file(path);
    if (!loaded && loaded.error().code == Code::malformed) {
        TAKT_TRY(opened.set_aside, os::set_aside(path, "-journal"));
        loaded = make_and_load();
    }
    if (!loaded) return std::unexpected(opening_error(path, loaded.error()));
    opened.values = std::move(loaded->values);
    opened.file = std::unique_ptr<RetainedFile>(
        new RetainedFile(std::make_unique<Impl>(std::move(loaded->database), path, std::move(on_progress))));
    return opened;
}

Result<std::vector<Retained>> RetainedFile::read(const std::string& path) {
    if (!file_exists(path)) return fail(Code::not_found, path);
    TAKT_CHECK(check_ours(path));
    return with_results(path, nullptr, [&path] {
        auto database = open_database(path, true);
        return read_rows(database, path);
    });
}

std::uint64_t RetainedFile::put(Retained entry) {
    return impl_->put(std::move(entry));
}

Progress RetainedFile::progress() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->progress;
}

}  // namespace takt::store
