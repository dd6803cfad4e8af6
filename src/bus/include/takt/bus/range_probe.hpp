// Finds the items of an area that a device has, by reading alone: the search behind `takt probe`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::bus {

/// One read of the search. quantity >= 1, start + quantity <= 65536.
struct ProbeRead {
    std::uint16_t start = 0;
    std::uint16_t quantity = 1;
    friend bool operator==(const ProbeRead&, const ProbeRead&) = default;
};

/// The result of one read.
enum class ProbeReply : std::uint8_t {
    values,       ///< all items were read
    refused,      ///< any exception but 1, 3 and 4
    no_function,  ///< exception 1; some devices also send it for addresses they do not have
    bad_value,    ///< exception 3: the quantity is not accepted; of one item: it is refused
    failure,      ///< exception 4: the device failed to read the item
    silent,       ///< no usable response, repetitions included
    stop,         ///< the probe ends: the user interrupted it, or the link is lost
};

/// Sends a read and waits for its result. Repeats what fails by chance (time-outs, bad checksums, busy
/// devices); each call counts as one request.
using ProbeOracle = std::function<ProbeReply(const ProbeRead&)>;

struct ProbeConfig {
    std::uint16_t first = 0;  ///< addresses to search, both included; first <= last
    std::uint16_t last = 65535;
    std::uint16_t most = 125;  ///< items of the longest read: 125 registers, 2000 bits
    /// Distance of the addresses that are read where nothing was found, 1..65535. No run of at least so many
    /// items is missed; a shorter one is found near another run or at a likely address (probe_ranges()).
    std::uint16_t step = 1;
    std::size_t max_requests = 4096;
};

/// Items that exist, but cannot be read now or alone.
struct RefusedItems {
    model::ItemRange range;
    ProbeReply reply = ProbeReply::failure;  ///< bad_value or failure
    friend bool operator==(const RefusedItems&, const RefusedItems&) = default;
};

enum class ProbeEnd : std::uint8_t {
    complete,
    out_of_requests,  ///< max_requests were sent
    stopped,          ///< the oracle returned `stop`
    no_function,      ///< the first 24 responses were exception 1: the device does not have the function
    no_answer,        ///< the first 8 reads got no response
    fell_silent,      ///< an item that was read before gets no response any more
};

struct ProbeResult {
    ProbeEnd end = ProbeEnd::complete;
    /// Ranges of items that were read: sorted, neither overlapping nor adjoining. With ProbeEnd::complete and
    /// step 1 they are exactly the items that the device has.
    std::vector<model::ItemRange> readable;
    /// Addresses that were examined: readable, refused, or absent. Sorted as `readable`.
    std::vector<model::ItemRange> tested;
    /// Items that were refused by exception 3 or 4, while other addresses were refused in another way. A
    /// device that knows only one refusal leaves the list empty. Sorted by address.
    std::vector<RefusedItems> refused;
    /// Every refused item was refused by exception 3 or 4, so that absent items look like failed ones.
    bool one_refusal = false;
    std::size_t requests = 0;
    std::uint16_t longest = 0;  ///< items of the longest read that succeeded
    bool limited = false;       ///< longer reads are refused although each of their items is readable
    /// The first address of the grid that was not examined; 65536: all were.
    std::uint32_t next = 65536;
};

/// An upper bound on the requests of a complete search, for a device that responds consistently and refuses
/// by exceptions other than 3 and 4: one for each address of the grid and each likely address, one for each
/// full read, for each end of a run a bisection of the longest read, its confirmation, and the reads around
/// it, and for each run one longer read.
/// @param readable   items of the device among the addresses of the search
/// @param runs       runs that they form
/// @param limit      items of its longest read, at most `most`
[[nodiscard]] std::size_t most_probe_requests(const ProbeConfig& config, std::size_t readable,
                                              std::size_t runs, std::uint16_t limit);

/// Searches first..last.
///
/// A read succeeds when the device has all its items and accepts that many. A refusal of several items is
/// therefore ambiguous: an item is missing, or they are too many. From an item that exists the search extends
/// the run to both sides by the longest reads. It bisects a refused read down to the first missing item and
/// reads that item alone. A refusal confirms the end of the run. A value shows that the length was refused,
/// and no longer reads are sent from then on. A run that was read in parts and is longer than every read so
/// far is read once more in one request, so that `longest` is what the device accepts.
///
/// Items to start from are searched one by one, in this order:
///   1. the first 16 addresses of the search, addresses 0..255, and every 8th address up to 1023;
///   2. N * 1000 .. N * 1000 + 3, N * 0x1000 .. N * 0x1000 + 3, and multiples of 100;
///   3. a grid that becomes finer down to `step`.
/// Around each end of a run, and around refused items, addresses at the distances 1, 2, 4, … 64 follow at
/// once. The order does not depend on `step`: the requests with one step are the first requests with half
/// of it, so that a finer step finds at least as much, also when the requests run out.
///
/// A device may refuse by silence. Each silence is therefore checked by reading an item that was read before.
///
/// Calls nothing but `oracle`.
[[nodiscard]] ProbeResult probe_ranges(const ProbeConfig& config, const ProbeOracle& oracle);

}  // namespace takt::bus
