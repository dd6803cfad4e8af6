// A file or standard input, read until a signal stops it.
#pragma once

#include <csignal>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::app {

/// While the object exists, the stop_signals() end the input instead of the program. One at a time, on the
/// main thread.
class StoppableInput {
public:
    /// @param path  "-": standard input
    /// @returns what os::open_stream() returns
    [[nodiscard]] static Result<StoppableInput> open(const std::string& path);
    /// For wait() alone, on a descriptor that another object owns. @param name  the subject of errors
    [[nodiscard]] static StoppableInput around(std::string name, int descriptor);
    ~StoppableInput();
    StoppableInput(StoppableInput&& other) noexcept;
    StoppableInput& operator=(StoppableInput&&) = delete;

    /// Waits for bytes. @returns how many were stored; 0: the end, or a signal came; io_failed
    [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> storage);

    /// Waits until the input is readable, for at most `limit`. @returns false: it is not, or a signal came;
    /// io_failed
    [[nodiscard]] Result<bool> wait(Duration limit);

    /// A signal came. Stays so after the input was closed.
    [[nodiscard]] static bool stopped();
    /// Bytes of the file; nothing: unknown.
    [[nodiscard]] std::optional<std::uint64_t> size() const { return size_; }

private:
    StoppableInput(std::string path, os::Descriptor file, int number);

    [[nodiscard]] bool is_stopped() const;

    std::string path_;
    os::Descriptor file_;  // none: standard input, or owned by another object
    int number_;
    std::optional<std::uint64_t> size_;
    bool owns_ = true;  // whether this object took the signals
    sigset_t taken_{};
    sigset_t before_{};  // the mask of blocked signals
};

}  // namespace takt::app
