// Where a writing thread puts its text: a descriptor or a file with rotation.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "takt/os/descriptor.hpp"

namespace takt::os {

/// The destination of a RecordWriter's lines.
class Sink {
public:
    struct Written {
        std::size_t bytes = 0;  ///< of the text, written
        int error = 0;          ///< the system's error number; 0: all was written, or the end came first
        bool closed = false;    ///< nothing can be written any more
    };

    virtual ~Sink() = default;

    /// Writes whole lines. May block. The writing thread only.
    virtual Written write(std::string_view text) = 0;

    /// The end has begun: a write that makes no progress for that long gives up. Any thread.
    virtual void finish_within(std::chrono::milliseconds stall_timeout) { (void)stall_timeout; }

    /// Whether the reading side was closed. Any thread.
    [[nodiscard]] virtual bool reader_closed() const { return false; }
};

/// Writes to a descriptor: a pipe, a terminal or a file.
///
/// A pipe or a terminal that is not read holds up write() until finish_within() limits it. The descriptor is
/// never switched to non-blocking, which would change it for every process that shares it.
///
/// A write that fails because the disk is full leaves no part of a line behind and does not close the sink:
/// the next write tries again. Any other failure closes it.
class DescriptorSink final : public Sink {
public:
    /// @param descriptor  not closed by the sink; it must stay open as long as the sink exists
    explicit DescriptorSink(int descriptor) : descriptor_(descriptor) {}
    explicit DescriptorSink(Descriptor owned) : owned_(std::move(owned)), descriptor_(owned_.get()) {}

    Written write(std::string_view text) override;
    void finish_within(std::chrono::milliseconds stall_timeout) override;
    [[nodiscard]] bool reader_closed() const override;

private:
    [[nodiscard]] Written write_all(std::string_view text);
    [[nodiscard]] Written failed(std::string_view text, std::size_t done, int error);
    [[nodiscard]] bool is_stalled(std::chrono::steady_clock::time_point last_progress) const;

    static constexpr std::int64_t kNotEnding = -1;

    Descriptor owned_;
    int descriptor_;
    bool in_line_ = false;  // a part of a line was written and could not be removed
    std::atomic<std::int64_t> stall_timeout_ms_ = kNotEnding;
    std::atomic<std::chrono::steady_clock::time_point> ending_since_{};
};

}  // namespace takt::os
