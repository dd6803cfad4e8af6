// The audit log: writes and refused requests as JSON lines in a file.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/inplace_string.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/os/record_writer.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::endpoint {

/// One write, or one request that was refused.
struct AuditRecord {
    enum class Event : std::uint8_t { write, refused };

    std::chrono::system_clock::time_point time;
    Event event = Event::write;
    InplaceString<64> peer;
    std::uint8_t unit = 0;
    bool broadcast = false;
    std::uint8_t function = 0;
    /// Of a request that touches items.
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint16_t start = 0;
        std::uint16_t count = 0;
    };
    std::optional<Items> items;
    /// Of a write to items, as on the wire: bits from the lowest of the first byte on, registers high byte
    /// first. Empty for other requests.
    wire::Pdu old_values;
    wire::Pdu new_values;
    wire::Pdu request;           ///< where there are no values
    std::string_view why;        ///< of a refusal: "rule", "read_only", "rate", "exception"; a constant
    std::uint8_t exception = 0;  ///< of a refusal; 0: a broadcast, which is not answered
};

/// The record as one line, with its end.
[[nodiscard]] std::string audit_line(const AuditRecord& record);

/// Takes the records.
class AuditSink {
public:
    virtual ~AuditSink() = default;
    /// Must not block. @param t  the engines' time: the rate limits go by it
    virtual void put(Instant t, const AuditRecord& record) = 0;
};

/// An AuditSink on a rotating file that a thread of its own writes.
///
/// Records beyond the limits (of writes and of refusals, each by itself, so that a flood of refusals does not
/// hide a write), and records that the disk does not take fast enough, are dropped. A line in the log reports
/// how many, at most once a second. put() is called by one thread.
class AuditLog final : public AuditSink {
public:
    struct Options {
        std::size_t file_bytes = 10 << 20;
        unsigned old_files = 5;
        std::uint32_t writes_per_second = 1000;  ///< after twice as many at once; at least 1
        std::uint32_t refusals_per_second = 100;
        std::size_t queue = 4096;  ///< records
    };

    /// @returns as os::RotatingFile::open()
    [[nodiscard]] static Result<std::unique_ptr<AuditLog>> open(const std::string& path) {
        return open(path, Options{});
    }
    [[nodiscard]] static Result<std::unique_ptr<AuditLog>> open(const std::string& path,
                                                                const Options& options);

    void put(Instant t, const AuditRecord& record) override;

    /// Writes what is queued, and ends. Nothing may be put afterwards.
    /// @returns how often the file could not be written
    std::uint64_t finish();

private:
    AuditLog(std::unique_ptr<os::Sink> file, const Options& options);

    TokenBucket writes_;
    TokenBucket refusals_;
    os::RecordWriter<AuditRecord> writer_;
};

}  // namespace takt::endpoint
