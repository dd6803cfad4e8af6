// Which items of an area a device has, found by reading alone: the search behind `takt probe`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::discover {

/// One read of the search. quantity >= 1, start + quantity <= 65536.
struct ProbeRead {
    std::uint16_t start = 0;
    std::uint16_t quantity = 1;
    friend bool operator==(const ProbeRead&, const ProbeRead&) = default;
};

/// What came of it.
enum class ProbeReply : std::uint8_t {
    values,       ///< all of them were read
    refused,      ///< the device says no, with whatever exception but 1
    no_function,  ///< exception 1, which some devices also answer for addresses they do not have
    silent,       ///< nothing usable came, repetitions included
    stop,         ///< nothing more can be asked: the user ends it, the link is lost
};

/// Puts a read to the device and waits for what comes of it. Repeats what failed by chance (time-outs, bad
/// checksums, busy devices); each call counts as one request.
using ProbeOracle = std::function<ProbeReply(const ProbeRead&)>;

struct ProbeConfig {
    std::uint16_t first = 0;  ///< addresses to look at, both included; first <= last
    std::uint16_t last = 65535;
    std::uint16_t most = 125;  ///< items of a read to begin with: 125 registers, 2000 bits
    /// Where nothing answers, every `step`-th address is asked, 1..65535: no run of at least so many items is
    /// missed. Shorter ones are found near others and at likely places (probe_ranges()).
    std::uint16_t step = 1;
    std::size_t max_requests = 2000;
};

enum class ProbeEnd : std::uint8_t {
    complete,
    out_of_requests,  ///< max_requests were used up
    stopped,          ///< the oracle said stop
    no_function,      ///< the first 24 answers were all exception 1: the device does not have the function
    no_answer,        ///< the first 8 reads all stayed without an answer
    fell_silent,      ///< what was readable before is so no more
};

struct ProbeResult {
    ProbeEnd end = ProbeEnd::complete;
    /// Each item of them was read. Sorted, neither overlapping nor adjoining. With ProbeEnd::complete and
    /// step 1: exactly the items the device has.
    std::vector<model::ItemRange> readable;
    std::size_t requests = 0;
    std::uint16_t longest = 0;   ///< items of the longest read that succeeded
    bool limited = false;        ///< more than `longest` are refused although each of them is readable
    std::uint32_t next = 65536;  ///< addresses from here on were not all looked at; 65536: none such
};

/// The most requests a complete search takes of a device that answers steadily and is not silent where it has
/// nothing: one for each address of the grid and each likely place, one for each full read, and for each end
/// of a run a bisection of the longest read, its confirmation and a look around.
/// @param readable   items the device has among those looked at
/// @param runs       runs they make
/// @param limit      items it takes in a read, at most `most`
[[nodiscard]] std::size_t most_probe_requests(const ProbeConfig& config, std::size_t readable,
                                              std::size_t runs, std::uint16_t limit);

/// Searches first..last.
///
/// A read succeeds when the device has all its items and takes that many. So a refusal of several items says
/// little: one of them is missing, or they are too many. From an item that is there the search therefore
/// grows the run to both sides by the longest reads, and bisects the one that is refused down to the first
/// missing item; that one is then asked for alone: refused, it is confirmed as the end of the run; read, the
/// length was what was refused, and no longer reads are made from then on. Items to begin with are looked for
/// one by one: at the first 16 addresses, then in a grid that becomes finer down to `step`, and with a step
/// above 1 also at multiples of 100 and at distances 1, 2, 4, … from the ends of runs.
///
/// Where a device says no by silence, each silence is checked by reading something that was there before.
///
/// Calls nothing but `oracle`.
[[nodiscard]] ProbeResult probe_ranges(const ProbeConfig& config, const ProbeOracle& oracle);

}  // namespace takt::discover
