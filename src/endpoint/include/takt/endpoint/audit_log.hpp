// The audit log: writes and refused requests as JSON lines in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/endpoint/audit_record.hpp"
#include "takt/os/record_writer.hpp"

namespace takt::endpoint {

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
