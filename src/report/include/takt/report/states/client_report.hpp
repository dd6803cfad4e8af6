// Requests to one device, made once: their results as text and as JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/client/values.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// The requests themselves, for their reports.
struct ClientRun {
    std::string target;
    std::uint8_t unit = 1;
    Duration duration{};       ///< of the requests; zero: no connection was made
    bool interrupted = false;  ///< a signal ended the requests
};

/// A line for each value: "5 17", "6 -0.5". Bits are 0 and 1.
[[nodiscard]] std::string read_text(DataType type, std::span<const client::ReadValue> values);

/// The object that `takt read --json` prints (docs/commands/read.md).
/// @param values  those that were read before the end
[[nodiscard]] file::Json read_json(const Texts& texts, const ClientRun& run, const client::ReadSpec& spec,
                                   std::span<const client::ReadValue> values, const Result<void>& ended);

/// A write and its end.
struct WriteRun {
    std::uint16_t start = 0;
    std::size_t wanted = 0;  ///< registers or bits to write
    client::Written written;
};

/// How many items were written, and from which one on. After an error: how many of how many were confirmed,
/// and which one is the next.
[[nodiscard]] std::string write_text(const Texts& texts, const WriteRun& write);

/// The object that `takt write --json` prints (docs/commands/write.md).
[[nodiscard]] file::Json write_json(const Texts& texts, const ClientRun& run, const WriteRun& write);

/// The object that `takt raw --json` prints (docs/commands/raw.md).
/// @param response  empty: to a broadcast
[[nodiscard]] file::Json raw_json(const Texts& texts, const ClientRun& run, Bytes request,
                                  const Result<Bytes>& response);

/// Why reads or a raw request ended early: the error, or the interruption.
[[nodiscard]] std::string ended_text(const Texts& texts, const ClientRun& run, const Error& error);

/// Likewise for a write, which the device may have executed when it was interrupted.
[[nodiscard]] std::string write_ended_text(const Texts& texts, const ClientRun& run, const Error& error);

}  // namespace takt::report
