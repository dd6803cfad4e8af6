// The audit log: writes and refused requests as JSON lines in a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/inplace_string.hpp"
#include "takt/base/network.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/base/token_bucket.hpp"
#include "takt/endpoint/audit_record.hpp"
#include "takt/os/record_writer.hpp"

namespace takt::endpoint {

/// An AuditSink on a rotating file that a thread of its own writes.
///
/// Each peer (rate_owner() of its address; a serial port) has limits of its own, of writes and of refusals,
/// so that a flood of one hides neither the records of others nor its own writes. Records beyond the limits,
/// and records that the disk does not take fast enough, are dropped. The last quarter of the queue is for
/// peers with few records. A line in the log reports how many were dropped, at most once a second. put() is
/// called by one thread.
class AuditLog final : public AuditSink {
public:
    struct Options {
        std::size_t file_bytes = 10 << 20;
        unsigned old_files = 5;
        std::uint32_t writes_per_second = 1000;  ///< of a peer, after twice as many at once; at least 1
        std::uint32_t refusals_per_second = 100;
        std::size_t queue = 4096;  ///< records
        std::size_t peers = 1024;  ///< a further one replaces the one that was silent longest
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
    /// The remaining limits of one peer.
    struct Budget {
        IpAddress network;       // of a TCP peer
        InplaceString<64> port;  // of a serial one
        Instant seen;
        TokenBucket writes;
        TokenBucket refusals;
        TokenBucket few;  // records that may use the whole queue
    };

    AuditLog(std::unique_ptr<os::Sink> file, const Options& options);
    [[nodiscard]] Budget& budget_of(Instant t, std::string_view peer);

    const Options options_;
    std::vector<Budget> budgets_;
    os::RecordWriter<AuditRecord> writer_;
};

}  // namespace takt::endpoint
