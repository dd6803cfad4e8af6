// Signals as bytes of a pipe, so that a loop can wait for them.
#pragma once

#include <csignal>
#include <initializer_list>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::line {

/// Catches signals as long as it lives; then they do again what they did before. One at a time in a process:
/// the last one made gets them. A process that lives 5 s longer than its first signal to stop is ended by
/// that signal: it waits for a terminal or a disk that does not respond. SIGHUP is no signal to stop here.
class SignalPipe {
public:
    [[nodiscard]] static Result<SignalPipe> open(std::initializer_list<int> signals);
    ~SignalPipe();
    SignalPipe(SignalPipe&&) = default;
    SignalPipe(const SignalPipe&) = delete;
    SignalPipe& operator=(const SignalPipe&) = delete;
    SignalPipe& operator=(SignalPipe&&) = delete;

    /// Readable when there is one.
    [[nodiscard]] int fd() const { return end_.get(); }
    /// The number of the next one; 0: none.
    [[nodiscard]] int take() const;

private:
    SignalPipe(os::Descriptor end, os::Descriptor writing)
        : end_(std::move(end)), writing_(std::move(writing)) {}

    [[nodiscard]] Result<void> handle(int number, void (*handler)(int));

    os::Descriptor end_;
    os::Descriptor writing_;
    std::vector<std::pair<int, struct sigaction>> before_;
};

}  // namespace takt::line
