#include "live/mark_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <utility>

#include "takt/os/open.hpp"
#include "takt/os/replace.hpp"
#include "takt/os/set_aside.hpp"

namespace takt::web {
namespace {

constexpr std::int64_t kVersion = 1;
constexpr int kMostOpenings = 3;
constexpr std::size_t kMostLine = std::size_t{64} << 10;
constexpr std::uint64_t kMostNumber = std::uint64_t{1} << 53;
constexpr std::string_view kFormat = R"({"takt":"marks",)";
constexpr std::array<std::string_view, 3> kSeverities{"info", "warning", "error"};

template <class Type>
const Type* member_of(const file::Json& object, std::string_view key) {
    const auto* const found = object.find(key);
    return found == nullptr ? nullptr : std::get_if<Type>(&found->value());
}

/// A version, or a time in milliseconds since 1970. The parser makes positive numbers unsigned.
std::optional<std::int64_t> number_in(const file::Json& object, std::string_view key) {
    const auto* const number = member_of<std::uint64_t>(object, key);
    if (number == nullptr || *number > kMostNumber) return std::nullopt;
    return static_cast<std::int64_t>(*number);
}

std::string heading(std::int64_t since_ms) {
    auto object = file::Json::object();
    object.set("takt", "marks");
    object.set("version", kVersion);
    object.set("since", since_ms);
    return object.dump() + '\n';
}

std::string mark_line(const Mark& mark) {
    auto object = file::Json::object();
    object.set("time", mark.time_ms);
    object.set("kind", mark.kind == Mark::Kind::command ? "command" : "message");
    object.set("severity", mark.severity);
    if (!mark.outcome.empty()) object.set("outcome", mark.outcome);
    if (!mark.origin.empty()) object.set("origin", mark.origin);
    for (const auto language : text::kLanguages)
        object.set(text::tag(language), mark.texts[static_cast<std::size_t>(language)]);
    return object.dump() + '\n';
}

std::optional<Mark> mark_of(std::string_view line) {
    const auto object = file::Json::parse(line, kMostLine);
    if (!object) return std::nullopt;
    const auto time = number_in(*object, "time");
    const auto* const kind = member_of<std::string>(*object, "kind");
    const auto* const severity = member_of<std::string>(*object, "severity");
    if (!time || kind == nullptr || severity == nullptr) return std::nullopt;
    if (std::ranges::find(kSeverities, *severity) == kSeverities.end()) return std::nullopt;
    Mark mark{.time_ms = *time, .severity = *severity};
    if (*kind == "command")
        mark.kind = Mark::Kind::command;
    else if (*kind != "message")
        return std::nullopt;
    if (const auto* const outcome = member_of<std::string>(*object, "outcome")) mark.outcome = *outcome;
    if (const auto* const origin = member_of<std::string>(*object, "origin")) mark.origin = *origin;
    for (const auto language : text::kLanguages) {
        const auto* const text = member_of<std::string>(*object, text::tag(language));
        if (text == nullptr) return std::nullopt;
        mark.texts[static_cast<std::size_t>(language)] = *text;
    }
    return mark;
}

/// The contents of a file.
struct Contents {
    std::optional<std::int64_t> since_ms;  // nothing: the first line is no heading
    std::vector<Mark> marks;
    std::size_t good_bytes = 0;  // the heading and the marks, up to the end of the last whole line
    bool damaged = false;        // other lines are among them
    bool newer = false;          // of a version that this program does not know
};

void read_heading(Contents& contents, std::string_view line) {
    const auto object = file::Json::parse(line, kMostLine);
    if (!object) return;
    const auto* const format = member_of<std::string>(*object, "takt");
    const auto version = number_in(*object, "version");
    if (format == nullptr || *format != "marks" || !version) return;
    contents.newer = *version > kVersion;
    contents.since_ms = number_in(*object, "since");
}

// A power cut leaves a member_of of the last line, or zeros after the last line.
Contents contents_of(std::string_view bytes) {
    Contents contents;
    bytes = bytes.substr(0, bytes.find_last_not_of('\0') + 1);
    for (std::size_t begin = 0; begin < bytes.size();) {
        const auto end = bytes.find('\n', begin);
        if (end == std::string_view::npos) break;
        const auto line = bytes.substr(begin, end - begin);
        if (begin == 0)
            read_heading(contents, line);
        else if (auto mark = mark_of(line))
            contents.marks.push_back(*std::move(mark));
        else
            contents.damaged = true;
        begin = contents.good_bytes = end + 1;
    }
    const bool is_ours = heading(0).starts_with(bytes.substr(0, kFormat.size()));
    contents.damaged = contents.damaged || (!contents.since_ms && !is_ours);
    return contents;
}

/// Whether an earlier run left the file while it replaced the marks.
Result<bool> is_leftover(int descriptor) {
    std::array<char, kFormat.size()> head{};
    const auto count = ::pread(descriptor, head.data(), head.size(), 0);
    return count >= 0 && kFormat.starts_with(std::string_view(head.data(), static_cast<std::size_t>(count)));
}

/// The file of the path, locked. The path may get another file, or none, between two of the calls.
Result<os::Descriptor> open_locked(const std::string& path) {
    for (int i = 0; i < kMostOpenings; ++i) {
        auto file = os::open_for_update(path);
        if (!file && file.error().code == Code::cannot_open && file.error().numbers[0] == ENOENT)
            file = os::create_file(path);
        if (!file) return file;
        if (::flock(file->get(), LOCK_EX | LOCK_NB) != 0) break;
        if (os::is_at(file->get(), path)) return file;
    }
    return fail(Code::busy, path);
}

}  // namespace

Result<MarkFile::Opened> MarkFile::open(const std::string& path, std::int64_t since_ms) {
    TAKT_TRY(auto descriptor, open_locked(path));
    auto bytes = os::read_all(descriptor.get(), path, 2 * kMostBytes);
    if (!bytes && bytes.error().code != Code::too_long) return std::unexpected(bytes.error());
    auto contents = bytes ? contents_of(*bytes) : Contents{.damaged = true};
    if (contents.newer) return fail(Code::unsupported, path);
    Opened opened{.file = std::unique_ptr<MarkFile>(new MarkFile(path, std::move(descriptor))),
                  .since_ms = contents.since_ms.value_or(since_ms),
                  .marks = std::move(contents.marks)};
    auto& file = *opened.file;
    if (contents.damaged) {
        TAKT_TRY(opened.set_aside, os::set_aside(path));
    } else if (contents.since_ms) {
        opened.cut_bytes = bytes->size() - contents.good_bytes;
        file.lines_ = opened.marks.size();
        TAKT_CHECK(file.cut_to(contents.good_bytes));
        return opened;
    }
    TAKT_CHECK(file.write_anew(opened.since_ms, opened.marks));
    return opened;
}

bool MarkFile::is_unchanged() const {
    struct stat status{};
    return os::is_at(file_.get(), path_) && ::fstat(file_.get(), &status) == 0 &&
           static_cast<std::size_t>(status.st_size) == size_;
}

Result<void> MarkFile::cut_to(std::size_t size) {
    if (::ftruncate(file_.get(), static_cast<off_t>(size)) != 0 || ::lseek(file_.get(), 0, SEEK_END) < 0)
        return fail(Code::io_failed, path_, errno);
    size_ = size;
    return {};
}

Result<void> MarkFile::append(std::span<const Mark> marks) {
    if (!is_unchanged()) return fail(Code::replaced, path_);
    std::string text;
    for (const auto& mark : marks) text += mark_line(mark);
    if (!os::write_all(file_.get(), text) || ::fdatasync(file_.get()) != 0) {
        const int number = errno;
        TAKT_CHECK(cut_to(size_));
        return fail(Code::io_failed, path_, number);
    }
    size_ += text.size();
    lines_ += marks.size();
    return {};
}

Result<void> MarkFile::write_anew(std::int64_t since_ms, std::span<const Mark> marks) {
    std::vector<std::string> lines;
    std::size_t bytes = 0;
    for (const auto& mark : marks) bytes += lines.emplace_back(mark_line(mark)).size();
    auto first = lines.begin();
    for (; bytes > kMostBytes / 2; ++first) {
        bytes -= first->size();
        since_ms = std::max(since_ms, marks[static_cast<std::size_t>(first - lines.begin())].time_ms + 1);
    }
    std::string text = heading(since_ms);
    for (auto line = first; line != lines.end(); ++line) text += *line;

    const os::FileReplacement::Options options{
        .mode = os::kStateFileMode, .temporary_suffix = ".new", .may_overwrite = is_leftover, .lock = true};
    TAKT_TRY(auto replacement, os::FileReplacement::begin(path_, options));
    if (!os::write_all(replacement.descriptor(), text)) return fail(Code::io_failed, path_, errno);
    os::Descriptor file(::fcntl(replacement.descriptor(), F_DUPFD_CLOEXEC, 0));
    if (!file) return fail(Code::io_failed, path_, errno);
    TAKT_CHECK(replacement.commit());
    file_ = std::move(file);
    size_ = text.size();
    lines_ = static_cast<std::size_t>(lines.end() - first);
    return {};
}

}  // namespace takt::web
