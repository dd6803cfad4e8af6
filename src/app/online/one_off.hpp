// Shared by the commands for one device: the connection, the exit status, and the check of arguments that are
// out of range.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "exit_code.hpp"
#include "takt/client/client.hpp"
#include "takt/report/states/client_report.hpp"
#include "texts.hpp"
#include "work_loop.hpp"

namespace takt::app {

/// Reports that the device sends lengths that only a line with `length_tolerance` accepts.
void report_lengths_off(const Texts& texts, const client::Client& device);

/// A client that a signal interrupts, with the log of its frames.
class OneOff {
public:
    explicit OneOff(const Texts& texts) : texts_(texts) {}
    OneOff(const OneOff&) = delete;
    /// Reports what a project needs for that device.
    ~OneOff() {
        if (client_) report_lengths_off(texts_, *client_);
    }

    /// @param texts  outlive it
    /// @returns what Client::open() and WorkLoop::begin() return
    [[nodiscard]] static Result<std::unique_ptr<OneOff>> open(const Texts& texts,
                                                              const ClientOptions& options);

    [[nodiscard]] client::Client& device() { return *client_; }
    [[nodiscard]] line::Loop& loop() { return loop_.loop(); }

private:
    const Texts& texts_;
    WorkLoop loop_;
    std::unique_ptr<client::Client> client_;
};

/// The device that the options name, for the reports.
[[nodiscard]] report::ClientRun run_of(const ClientOptions& options);

/// The exit code of a run that `error` or a signal ended.
[[nodiscard]] ExitCode exit_code(const report::ClientRun& run, const Error& error);

/// The first item that START means. With `--type bool` tables number bools by registers, so START may be a
/// coil, or bit 0 of a register: asks on a terminal which one is meant; elsewhere reports both.
/// @returns nothing, after a report: it is not known which, or an option does not fit the area
[[nodiscard]] std::optional<std::uint16_t> start_meant(const Texts& texts, wire::Area area,
                                                       std::uint16_t start, const ItemOptions& options);

/// @returns true, and reports it, when the items from `start` on go beyond the last address
bool is_beyond(const Texts& texts, std::uint64_t start, std::uint64_t items);

}  // namespace takt::app
