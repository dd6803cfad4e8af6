#include "audit_log.hpp"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <iterator>
#include <utility>

#include "takt/file/json.hpp"

namespace takt::app {
namespace {

constexpr mode_t kMode = 0640;
constexpr int kFlags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC;

std::string time_text(std::chrono::system_clock::time_point time) {
    const auto whole = std::chrono::floor<std::chrono::milliseconds>(time);
    const auto seconds = std::chrono::floor<std::chrono::seconds>(whole);
    return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z",
                       fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)), (whole - seconds).count());
}

std::string quoted(std::string_view text) {
    std::string result = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            result.append({'\\', c});
        else if (byte < 0x20)
            result += fmt::format("\\u{:04x}", byte);
        else
            result += c;
    }
    return result + '"';
}

std::string numbers(const wire::Pdu& values, const AuditRecord::Items& items) {
    std::string text;
    for (std::size_t i = 0; i < items.count; ++i) {
        const unsigned byte = values[wire::is_bit_area(items.area) ? i / 8 : 2 * i];
        const unsigned value =
            wire::is_bit_area(items.area) ? byte >> (i % 8) & 1U : byte << 8 | values[2 * i + 1];
        text += (i == 0 ? "" : ",") + std::to_string(value);
    }
    return "[" + text + "]";
}

std::string left_out_line(std::uint64_t count) {
    return fmt::format(R"({{"time":"{}","event":"left_out","count":{}}})"
                       "\n",
                       time_text(std::chrono::system_clock::now()), count);
}

}  // namespace

std::string audit_line(const AuditRecord& record) {
    std::string line =
        fmt::format(R"({{"time":"{}","event":"{}","peer":{},"unit":{},"function":{})", time_text(record.time),
                    record.event == AuditRecord::Event::write ? "write" : "refused",
                    quoted(record.peer.view()), record.unit, record.function);
    if (record.broadcast) line += R"(,"broadcast":true)";
    if (const auto& items = record.items)
        line += fmt::format(R"(,"area":"{}","start":{},"count":{})", wire::name(items->area), items->start,
                            items->count);
    if (record.items && !record.new_values.empty())
        line += R"(,"old":)" + numbers(record.old_values, *record.items) + R"(,"new":)" +
                numbers(record.new_values, *record.items);
    if (!record.request.empty())
        line += fmt::format(R"(,"request":"{:02x}")", fmt::join(record.request.span(), ""));
    if (record.event == AuditRecord::Event::refused)
        line += fmt::format(R"(,"why":"{}","exception":{})", record.why, record.exception);
    return line + "}\n";
}

bool AuditLog::Bucket::take(Instant t) {
    const std::int64_t passed = std::max<std::int64_t>((t - seen).count(), 0);
    tokens = passed >= most - tokens ? most : tokens + passed;
    seen = t;
    if (tokens < price) return false;
    tokens -= price;
    return true;
}

AuditLog::AuditLog(std::string path, int fd, std::size_t size, const Options& options)
    : path_(std::move(path)), options_(options), fd_(fd), size_(size) {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const auto bucket = [](std::uint32_t rate) {
        const std::int64_t price = kSecond / std::max<std::uint32_t>(rate, 1);
        return Bucket{price, 2 * price * rate, 2 * price * rate, {}};
    };
    writes_ = bucket(options.writes_per_second);
    refusals_ = bucket(options.refusals_per_second);
    queue_.reserve(options_.queue);
    thread_ = std::thread([this] { work(); });
}

Result<std::unique_ptr<AuditLog>> AuditLog::open(const std::string& path, const Options& options) {
    const int fd = ::open(path.c_str(), kFlags, kMode);
    if (fd < 0) return fail(Code::cannot_open, path, errno);
    struct stat status{};
    ::fstat(fd, &status);
    return std::unique_ptr<AuditLog>(
        new AuditLog(path, fd, static_cast<std::size_t>(status.st_size), options));
}

AuditLog::~AuditLog() {
    (void)finish();
    if (fd_ >= 0) ::close(fd_);
}

std::uint64_t AuditLog::finish() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) thread_.join();
    return failures_;
}

void AuditLog::put(Instant t, const AuditRecord& record) {
    const bool admitted = (record.event == AuditRecord::Event::write ? writes_ : refusals_).take(t);
    const std::lock_guard lock(mutex_);
    if (!admitted || queue_.size() >= options_.queue) {
        ++left_out_;
        return;
    }
    queue_.push_back(record);
    wake_.notify_one();
}

void AuditLog::work() {
    constexpr auto kTellEvery = std::chrono::seconds(1);
    std::vector<AuditRecord> records;
    records.reserve(options_.queue);
    std::chrono::steady_clock::time_point next_told{};
    std::unique_lock lock(mutex_);
    while (!ending_ || !queue_.empty() || left_out_ > 0) {
        wake_.wait_for(lock, kTellEvery, [this] { return ending_ || !queue_.empty(); });
        records.swap(queue_);
        const auto now = std::chrono::steady_clock::now();
        const bool tells = ending_ || now >= next_told;
        const std::uint64_t left_out = tells ? std::exchange(left_out_, 0) : 0;
        if (left_out > 0) next_told = now + kTellEvery;
        lock.unlock();
        std::string text;
        for (const auto& record : records) text += audit_line(record);
        if (left_out > 0) text += left_out_line(left_out);
        if (!text.empty()) write(text);
        records.clear();
        lock.lock();
    }
}

// A batch goes into one file, unless it is larger than a file may be.
void AuditLog::write(const std::string& text) {
    std::size_t done = 0;
    while (done < text.size()) {
        if (size_ > 0 && size_ + (text.size() - done) > options_.file_bytes) rotate();
        std::size_t end = text.size();
        if (end - done > options_.file_bytes) {
            const std::size_t line = text.rfind('\n', done + options_.file_bytes - 1);
            end = line == std::string::npos || line < done ? text.find('\n', done) + 1 : line + 1;
        }
        const auto put = fd_ < 0 ? -1 : ::write(fd_, text.data() + done, end - done);
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) {
            ++failures_;
            const std::lock_guard lock(mutex_);
            left_out_ += ending_ ? 0U
                                 : static_cast<std::uint64_t>(std::count(
                                       text.begin() + static_cast<std::ptrdiff_t>(done), text.end(), '\n'));
            return;
        }
        done += static_cast<std::size_t>(put);
        size_ += static_cast<std::size_t>(put);
    }
}

void AuditLog::rotate() {
    if (fd_ >= 0) ::close(fd_);
    const auto numbered = [this](unsigned i) { return i == 0 ? path_ : path_ + "." + std::to_string(i); };
    for (unsigned i = options_.old_files; i-- > 0;)
        (void)std::rename(numbered(i).c_str(), numbered(i + 1).c_str());
    fd_ = ::open(path_.c_str(), kFlags | (options_.old_files == 0 ? O_TRUNC : 0), kMode);
    struct stat status{};
    size_ = fd_ >= 0 && ::fstat(fd_, &status) == 0 ? static_cast<std::size_t>(status.st_size) : 0;
}

}  // namespace takt::app
