// From variables to requests: the plan (specification, sections 3, 4 and 7; docs/planning.md, "Bus time").
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// Why a request ends where it ends: a code (the key of its text in room `text`) and the text's arguments.
///
/// - plan.grouping_off: the device is planned `single`
/// - plan.last (variable): no further variable in this pass
/// - plan.single_function (function): 0x05 and 0x06 never group
/// - plan.gap, plan.gap_bits (previous, next, size): so many registers or bits lie between
/// - plan.overlap, plan.other_register (of bits), plan.other_status, plan.other_trigger, plan.other_write,
///   plan.order_conflict (previous, next)
/// - plan.other_function (previous, next, previous_function, next_function), and in the same manner
///   plan.other_type (_type), plan.other_length (_registers), plan.other_period (_ms)
/// - plan.limit_setting (registers per request), plan.limit_frame, plan.limit_profile, plan.limit_protocol
///   (next, size, limit): with `next` there would be `size` items
///
/// and in strategy optimal besides
/// - plan.gap_costs (previous, next, size, gap_ms, request_ms): to read the `size` items between takes longer
///   than a request of its own
/// - plan.gap_forbidden (previous, next, size, setting): one of the items between may not be read; `setting`
///   says which key of the device forbids it, with `no_read` the range, with `gaps: learn` what was refused
/// - plan.limit_learnt (next, size, limit): the device refuses longer reads
/// - plan.cheapest_cut (previous, next, size, limit): together with the next request there would be `size`
///   items; to cut elsewhere is no cheaper
/// - plan.bridged (gaps, size, gap_ms, request_ms): `size` items that nobody asked for, in so many gaps, are
///   read because it takes less than as many more requests; the second note of a request, never `why`
///
/// `previous` is the last variable of the request, `next` the one that would have followed. Where several
/// things stand in the way, the first in this order is named: function, type, address, period, status,
/// trigger, write on change, order, limit.
struct Reason {
    std::string code;
    std::vector<std::pair<std::string, std::string>> arguments;  ///< name, text
};

/// One request (an entry of specification, section 4): what is read, what is written, or both of the same
/// items.
struct Request {
    std::size_t device = 0;  ///< index into the line's devices
    /// Indices into the device's, in the order of their addresses: what it is sent for. In strategy optimal a
    /// variable may be listed by several requests that hold it.
    std::vector<std::size_t> variables;
    std::optional<wire::Function> read;
    std::optional<wire::Function> write;
    std::uint16_t start = 0;     ///< on the wire; coils: the coil address
    std::uint16_t quantity = 0;  ///< on the wire: registers, or coils
    /// Polled with this period, zero: as fast as the line allows; nothing: not polled.
    std::optional<Duration> period;
    /// It is due at phase + n * period, n = 0, 1, …, on the clock that all requests of its line share; less
    /// than the period.
    Duration phase{};
    /// Requests of a line with the same number take turns at covering the same variables: shapes of one
    /// cyclic request (guarantees, "Age of a value"). Numbered from 0 in the order of the requests.
    std::size_t stream = 0;
    /// Least deadline of what its stream polls; of a command, of what it writes. Nothing: no deadline, lowest
    /// priority.
    std::optional<Duration> deadline;
    std::optional<model::LocalIndex> read_trigger;
    std::optional<model::LocalIndex> write_trigger;
    /// That of all its variables; nothing: they have none, or (optimal) not all the same.
    std::optional<model::LocalIndex> status;
    bool write_on_change = false;
    /// How often it may be caused by its trigger or by changes; nothing: without limit, and without a bound.
    std::optional<model::Admission> admission;
    /// With 0x17: what is written, while start and quantity are what is read.
    std::uint16_t write_start = 0;
    std::uint16_t write_quantity = 0;
    /// Written by reading the register and writing it back with `write` (0x06 or 0x10): bits of one register.
    bool read_modify_write = false;
    /// Of the read, of the write where it only writes; with estimated_turnaround().
    Duration bus_time{};
    std::size_t request_bytes = 0;   ///< characters of the request frame
    std::size_t response_bytes = 0;  ///< characters of the normal response frame
    Reason why;
    std::optional<Reason> bridged;  ///< that gaps are read, and what that saves

    /// How often it counts (specification, section 4): twice with both a period and a start-reading trigger.
    [[nodiscard]] std::size_t count() const { return period && read_trigger ? 2 : 1; }
};

struct LinePlan {
    std::size_t line = 0;  ///< index into the project's lines
    /// In polling order: ascending address; of a device the entries that read by function and start, then
    /// those that only write by function and start.
    std::vector<Request> requests;
    std::size_t request_count = 0;           ///< counted requests
    std::size_t ungrouped_requests = 0;      ///< counted requests with grouping off everywhere
    std::vector<std::size_t> longest_round;  ///< see longest_round()
    Duration cycle{};                        ///< bus time of that round
    /// Sum of bus time / period of the polled requests with a period; above 1: overrun.
    double utilization = 0;
};

/// Whether a request writes a variable that is to be verified: it is read back afterwards.
[[nodiscard]] bool is_verified(const Request& request, const model::Variable& variable);

/// A plan is immutable once made.
struct Plan {
    std::vector<LinePlan> lines;  ///< one for each line of the project
};

/// How a plan deviates from what the project asks for.
struct Options {
    std::optional<model::Strategy> strategy;  ///< for all devices instead of their own
};

/// Plans a checked project. Deterministic: the same project, whatever the order of its variables, gives the
/// same requests (single and classic: up to equal variables, which keep the order of the file). O(n log n).
/// Single and classic are exact (specification, section 4); under rule 4 a 2-register int of either sign may
/// mix with a float.
///
/// Optimal reads each used variable that is read with the least bus time its period allows, whatever its
/// type, status and triggers; on TCP by round_trip / in_flight + frame_gap + 10 ns a byte, at least
/// request_gap, where `in_flight` requests share a round trip. What only a trigger reads at a time are the
/// variables of that trigger. Limits are the frame's and the profile's, and registers_per_request where the
/// user set it; a value longer than that, and no other, is cut: each request that holds a piece lists it.
/// Items nobody uses are read where `gaps` is not `never`, inside `readable` and outside `no_read`; `learn`
/// counts as `always` but for what Device::learnt says is refused (learning.hpp: the plan without what is not
/// confirmed).
///
/// A bool in a register is written by an entry of its own where the device has 0x16 or allows
/// read-modify-write, else by single only: its write entry names the register with quantity 1, whose other
/// bits the writer must keep. A project with errors is planned too, so that its author can look at it: each
/// variable once, but not all of its requests need to be possible.
[[nodiscard]] Plan make_plan(const model::Project& project, const Options& options = {});

/// Greatest number of instants that are looked at for even rounds and for the longest one.
inline constexpr std::size_t kMostInstants = std::size_t{1} << 16;

/// The polled requests of a line, ascending, that are due at the instant with the most bus time due, what has
/// period 0 included. Where there are more than kMostInstants: the longest ones of each stream, as if they
/// met.
/// @param requests  with period, phase, stream and bus time
[[nodiscard]] std::vector<std::size_t> longest_round(std::span<const Request> requests);

/// Bus time of one transaction of that many characters each way (docs/planning.md, bus time).
/// @param turnaround  from the end of the request to the first byte of the response; at least t3.5 counts on
/// RTU lines
[[nodiscard]] Duration bus_time(const model::Line& line, const model::Device& device,
                                std::size_t request_characters, std::size_t response_characters,
                                Duration turnaround);

/// The turnaround for the estimate: the device's, else 5 ms.
[[nodiscard]] Duration estimated_turnaround(const model::Device& device);

}  // namespace takt::plan
