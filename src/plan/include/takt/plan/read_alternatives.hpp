// Reads that can be sent instead of a planned one because their responses have another length
// (docs/decisions/0032-in-step.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "takt/base/inplace_vector.hpp"
#include "takt/plan/plan.hpp"

namespace takt::plan {

/// A read whose normal response cannot be mistaken for that of the planned request.
struct ReadAlternative {
    enum class Kind : std::uint8_t {
        wider,    ///< all items of the request, and a few more that may be read
        part,     ///< the first items of the request
        another,  ///< another planned read of the device
    };
    Kind kind = Kind::part;
    wire::Function read = wire::Function::read_holding_registers;
    std::uint16_t start = 0;
    std::uint16_t quantity = 0;
    friend bool operator==(const ReadAlternative&, const ReadAlternative&) = default;
};

/// At most kWider + kParts + kOthers, in this order; their responses differ from each other too.
using ReadAlternatives = InplaceVector<ReadAlternative, 8>;

/// The alternatives to the reads of one device.
class AlternativeReads {
public:
    /// Sorts the variables of the device: O(n log n).
    /// @param requests  the plan of the line
    AlternativeReads(const model::Project& project, const model::Line& line, const model::Device& device,
                     std::span<const Request> requests);

    /// The alternatives to `request`, a read of this device. A wider read has items that the project reads
    /// or, with `gaps: always`, that may be read; it keeps the limits of the device. In profile owen-kc1
    /// there are parts alone. Its cost does not depend on the number of requests.
    [[nodiscard]] ReadAlternatives of(const Request& request) const;

private:
    /// Runs of items that may be read with one function, [start, end), ascending.
    struct Readable {
        wire::Function read;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> runs;
        std::size_t limit = 0;  ///< items of a request
    };

    std::vector<Readable> readable_;
    std::vector<ReadAlternative> others_;  // of the polled reads, the first one of each length
    const model::Device* device_;
    bool parts_only_ = false;
};

}  // namespace takt::plan
