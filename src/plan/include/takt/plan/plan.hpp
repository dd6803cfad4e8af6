// From variables to requests: the plan (docs/specification.md, sections 3, 4 and 7; docs/planning.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/model/project.hpp"

namespace takt::plan {

/// Why a request ends where it ends: a code (key of its text in module `text`) and the arguments of the text.
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
/// Additionally in strategy optimal:
/// - plan.gap_costs (previous, next, size, gap_ms, request_ms): reading the `size` items between them takes
///   longer than another request
/// - plan.gap_forbidden (previous, next, size, setting): an item between them may not be read; `setting` is
///   the key of the device that forbids it, with `no_read` the range, with `gaps: learn` the refused items
/// - plan.limit_learnt (next, size, limit): the device refuses longer reads
/// - plan.cheapest_cut (previous, next, size, limit): with the next request there would be `size` items; no
///   other cut is cheaper
/// - plan.bridged (gaps, size, gap_ms, request_ms): `size` unused items in that many gaps are read, because
///   that takes less time than as many additional requests. It is the second note of a request, never `why`
///
/// `previous` is the last variable of the request, `next` the following one. If there are several reasons,
/// the first of this order is named: function, type, address, period, status, trigger, write on change,
/// order, limit.
struct Reason {
    std::string code;
    std::vector<std::pair<std::string, std::string>> arguments;  ///< name, text
};

/// The longest time from the begin of a polled read to the end of the next one.
struct RefreshBound {
    Duration age{};            ///< period + R
    Duration with_failures{};  ///< the greatest age of its values with failures; kUnbounded: it has no bound
    static constexpr Duration kUnbounded = std::chrono::minutes(1);
    friend bool operator==(const RefreshBound&, const RefreshBound&) = default;
};

/// One request (an entry of docs/specification.md, section 4): a read, a write, or both of the same items.
struct Request {
    std::size_t device = 0;  ///< index into the line's devices
    /// The variables that it is sent for, as indices into the device's, in address order. In strategy optimal
    /// several requests may list the same variable.
    std::vector<std::size_t> variables;
    std::optional<wire::Function> read;
    std::optional<wire::Function> write;
    std::uint16_t start = 0;     ///< on the wire; coils: the coil address
    std::uint16_t quantity = 0;  ///< on the wire: registers, or coils
    /// Polled with this period, zero: as fast as the line allows; nothing: not polled.
    std::optional<Duration> period;
    /// Due at phase + n * period, n = 0, 1, …, on the common clock of the line; less than the period.
    Duration phase{};
    /// The stream: requests of a line with the same number alternate and cover the same variables (shapes of
    /// one cyclic request, docs/guarantees.md, "Model"). Numbered from 0 in the order of the requests.
    std::size_t stream = 0;
    /// The least deadline of the stream's variables; for a command, of its written variables. Nothing: no
    /// deadline, lowest priority.
    std::optional<Duration> deadline;
    std::optional<model::LocalIndex> read_trigger;
    std::optional<model::LocalIndex> write_trigger;
    /// The common status of all variables; nothing: none, or (optimal) different ones.
    std::optional<model::LocalIndex> status;
    bool write_on_change = false;
    /// Rate limit of its trigger or changes; nothing: unlimited, and therefore without a bound.
    std::optional<model::RateLimit> admission;
    /// For 0x17: the written range; start and quantity are the read range.
    std::uint16_t write_start = 0;
    std::uint16_t write_quantity = 0;
    /// Bits of one register are written by reading the register and writing it back with `write` (0x06 or
    /// 0x10).
    bool read_modify_write = false;
    /// Of a read with a period, on a line that holds its deadlines (put_ages()).
    std::optional<RefreshBound> refresh_bound;
    /// Of the read; for a write-only request of the write. With estimated_turnaround().
    Duration bus_time{};
    std::size_t request_bytes = 0;   ///< characters of the request frame
    std::size_t response_bytes = 0;  ///< characters of the normal response frame
    Reason why;
    std::optional<Reason> bridged;  ///< the note on bridged gaps and their saving

    /// How often it counts (docs/specification.md, section 4): twice if it has both a period and a
    /// start-reading trigger.
    [[nodiscard]] std::size_t count() const { return period && read_trigger ? 2 : 1; }
};

struct LinePlan {
    std::size_t line = 0;  ///< index into the project's lines
    /// Polling order: ascending address; within a device the requests that read, ordered by function and
    /// start, then those that only write, likewise.
    std::vector<Request> requests;
    std::size_t request_count = 0;           ///< counted requests
    std::size_t ungrouped_requests = 0;      ///< counted requests with grouping off everywhere
    std::vector<std::size_t> longest_round;  ///< see longest_round()
    Duration cycle{};                        ///< bus time of that round
    /// Sum of bus time / period over the requests with a period; above 1 means overrun.
    double utilization = 0;
    /// The greatest age of a good value of each variable of each device, with failures (proved_ages()).
    /// Empty: not proved, or the line does not hold its deadlines.
    std::vector<std::vector<std::optional<Duration>>> ages;
};

/// Whether a request writes a variable with `verify`, which is read back afterwards.
[[nodiscard]] bool is_verified(const Request& request, const model::Variable& variable);

/// The function that writes one variable by itself, as far as `write_single` allows. It has `write`.
[[nodiscard]] wire::Function command_function(const model::Device& device, const model::Variable& variable);

/// Immutable once made.
struct Plan {
    std::vector<LinePlan> lines;  ///< one for each line of the project
};

/// Receives how many steps of how many are done.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

/// Deviations of a plan from its project.
struct Options {
    std::optional<model::Strategy> strategy = {};  ///< for all devices instead of their own
    Progress progress = {};                        ///< of the lines
};

/// Plans a checked project. Deterministic: the same project gives the same requests in any order of its
/// variables (single and classic: variables with equal function, register and bit keep the order of the
/// file). O(n log n).
///
/// Single and classic follow docs/specification.md, section 4, exactly. Under rule 4 the sign of an integer
/// does not matter, and a 2-register int may share a request with a float.
///
/// Optimal reads each used variable with the least bus time that its period allows. Its type, status
/// and triggers do not matter. On TCP the cost is round_trip / in_flight + frame_gap + 10 ns a byte, at least
/// request_gap: `in_flight` requests share a round trip. Variables that are read only by a trigger are read
/// by that trigger's requests. Limits are the frame's, the profile's, and registers_per_request if the user
/// set it. A value longer than that limit is cut; each request with a piece lists it. Unused items are read
/// if `gaps` is not `never`, inside `readable` and outside `no_read`. `learn` counts as `always` except for
/// the items that Device::learnt has as refused (learning.hpp has the plan with confirmed gaps only).
///
/// A bool in a register has a write request of its own if the device has 0x16 or allows read-modify-write.
/// Otherwise only strategy single writes it: its request has the register with quantity 1, and the writer
/// must keep the other bits. A project with errors is planned too, for display: each variable once, but some
/// requests may be impossible.
[[nodiscard]] Plan make_plan(const model::Project& project, const Options& options = {});

/// Plans one line, as make_plan() does. The plan of a line does not depend on the other lines.
[[nodiscard]] LinePlan plan_line(const model::Project& project, std::size_t line,
                                 const Options& options = {});

/// Limit of the instants that are examined for even rounds and for the longest round.
inline constexpr std::size_t kMostInstants = std::size_t{1} << 16;

/// The polled requests of a line, ascending, that are due at the instant with the most bus time, including
/// those with period 0. With more than kMostInstants instants: the longest request of each stream, as if all
/// were due together.
/// @param requests  with period, phase, stream and bus time
[[nodiscard]] std::vector<std::size_t> longest_round(std::span<const Request> requests);

/// Bus time of one transaction of that many characters each way (docs/planning.md, "Bus time").
/// @param turnaround  from the end of the request to the first byte of the response; at least t3.5 on RTU
///                    lines
[[nodiscard]] Duration bus_time(const model::Line& line, const model::Device& device,
                                std::size_t request_characters, std::size_t response_characters,
                                Duration turnaround);

/// The turnaround for the estimate: the written one; else the measured one, without the longest 0.1 %; else
/// 5 ms.
[[nodiscard]] Duration estimated_turnaround(const model::Device& device);

}  // namespace takt::plan
