// The frames that a command would send.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"

namespace takt::web {

/// A request frame as it would be on the wire.
struct PreviewFrame {
    std::vector<std::uint8_t> raw;
    std::string words;
    Duration bus_time{};  ///< of the transaction, estimated (docs/planning.md, "Bus time")
};

struct CommandPreview {
    std::vector<PreviewFrame> frames;
    value::Value written;  ///< the value that the device gets: the nearest it can hold
    bool rounded = false;
};

/// A variable that is written on change goes with its group: the other members have the values that are
/// wanted, else those that were read. Of a read-modify-write the second frame has the other bits as zero,
/// because they are only known then.
/// @param snapshot  with values and plan
/// @returns not_writable (name); overflow, out_of_range, unsupported as value::encode()
[[nodiscard]] Result<CommandPreview> preview(const host::Snapshot& snapshot, value::SlotId slot,
                                             const value::Value& value);

}  // namespace takt::web
