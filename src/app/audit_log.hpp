// What was written through a server and what was refused, as JSON lines in a file.
#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "takt/base/inplace_string.hpp"
#include "takt/base/inplace_vector.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::app {

/// One write, or one request that was refused.
struct AuditRecord {
    enum class Event : std::uint8_t { write, refused };

    std::chrono::system_clock::time_point time;
    Event event = Event::write;
    InplaceString<64> peer;
    std::uint8_t unit = 0;
    bool broadcast = false;
    std::uint8_t function = 0;
    /// The items, where the request has some.
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint16_t start = 0;
        std::uint16_t count = 0;
    };
    std::optional<Items> items;
    /// Of a write to items, as on the wire: bits from the lowest of the first byte on, registers high byte
    /// first. Else empty.
    wire::Pdu old_values;
    wire::Pdu new_values;
    wire::Pdu request;           ///< where the values do not tell it
    std::string_view why;        ///< of a refusal: "rule", "read_only", "rate", "exception"; a constant
    std::uint8_t exception = 0;  ///< of a refusal; 0: a broadcast, which is not answered
};

/// The record as one line, with its end.
[[nodiscard]] std::string audit_line(const AuditRecord& record);

/// A file of at most `file_bytes`, and the `old_files` before it as FILE.1 (the newest), FILE.2, …
///
/// put() never waits: a thread of its own writes. What comes faster than the limits (of writes and of
/// refusals, each by itself, so that a flood of refusals does not hide a write), or than the disk takes it,
/// is left out and counted in a line of its own. put() is called by one thread.
class AuditLog {
public:
    struct Options {
        std::size_t file_bytes = 10 << 20;
        unsigned old_files = 5;
        std::uint32_t writes_per_second = 1000;  ///< after twice as many at once
        std::uint32_t refusals_per_second = 100;
        std::size_t queue = 4096;  ///< records
    };

    /// @returns cannot_open (path, system's error number)
    [[nodiscard]] static Result<std::unique_ptr<AuditLog>> open(const std::string& path) {
        return open(path, Options{});
    }
    [[nodiscard]] static Result<std::unique_ptr<AuditLog>> open(const std::string& path,
                                                                const Options& options);
    /// finish()
    ~AuditLog();
    AuditLog(const AuditLog&) = delete;
    AuditLog& operator=(const AuditLog&) = delete;

    /// @param t  the engines' time: what the limits go by
    void put(Instant t, const AuditRecord& record);

    /// Writes what is queued, and ends. Nothing is to be put afterwards.
    /// @returns how often the file could not be written
    std::uint64_t finish();

private:
    /// Tokens in nanoseconds of the rate.
    struct Bucket {
        std::int64_t price = 1;
        std::int64_t most = 1;
        std::int64_t tokens = 1;
        Instant seen;
        bool take(Instant t);
    };

    AuditLog(std::string path, int fd, std::size_t size, const Options& options);
    void work();
    void write(const std::string& text);
    void rotate();

    std::string path_;
    Options options_;
    Bucket writes_;
    Bucket refusals_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::vector<AuditRecord> queue_;
    std::uint64_t left_out_ = 0;
    bool ending_ = false;
    int fd_;  // the writing thread's, as all below
    std::uint64_t failures_ = 0;
    std::size_t size_;  // of the file
    std::thread thread_;
};

}  // namespace takt::app
