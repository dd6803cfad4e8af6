// Kinds of faults in a simulated field, their rates and their counts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/sim/random.hpp"
#include "takt/wire/frame.hpp"

namespace takt::sim {

/// An exchange is one request and its answer. It suffers at most one of the kinds drawn per exchange;
/// scheduled kinds come on top.
enum class FaultKind : std::uint8_t {
    // Characters on a serial line, of the request or of the answer.
    bit_error,      ///< one to three bits
    lost_byte,      ///< one character is missing
    extra_byte,     ///< one character more, anywhere, at the ends too
    repeated_byte,  ///< one character twice
    // Frames.
    lost_request,        ///< the device receives nothing
    lost_response,       ///< the device executed the request; its answer is lost
    late_response,       ///< mostly 1.2 to 40 time-outs after its request, one in 50 up to minutes after it
    duplicate_response,  ///< twice: right behind, up to minutes later, or served twice before other requests;
                         ///< Modbus TCP: half of the copies with another id, as wrong_transaction
    past_response,       ///< before the answer, or instead of it, an earlier answer of the same shape again
    glitch,              ///< one to three characters 00, FF or random before or after an answer, up to 8 ms
                         ///< away from it
    fragmented,          ///< byte streams: in pieces with pauses, some up to the deadline and beyond
    truncated,           ///< its end is missing; over Modbus TCP its header promises more
    garbage,             ///< random bytes, as many as the frame or up to 300
    // Answers with a valid checksum and a wrong content.
    wrong_unit,         ///< from a unit that was not asked
    wrong_transaction,  ///< Modbus TCP: 0, id + 1, id - 1, swapped bytes, or a distant id
    wrong_function,     ///< another function's code, good checksum
    wrong_byte_count,   ///< of a read: fewer or more data than asked, byte count and length agree
    oversized,          ///< of a read: more than asked, up to the greatest frame and beyond
    wrong_echo,         ///< of a write: another address, value or quantity; the write was executed
    busy,               ///< exception 5 or 6; the request was not executed
    wrong_exception,    ///< exception 0, 0x7F or 0xFF; the request was not executed
    ignored_write,      ///< answered as executed; the request was not executed
    // Devices, scheduled.
    device_dead,     ///< no answer and no execution for a while
    device_back,     ///< the end of that
    device_babbles,  ///< serial: sends random bytes without pause for a while; all traffic is damaged
    device_reboots,  ///< silent for a while; keeps its values
    device_forgets,  ///< silent for a while; written values are as at the start again
    // Line, connection and host, scheduled.
    noise,            ///< serial: a few characters while the line is idle
    clock_jump,       ///< the master's computer is suspended; then all received bytes arrive at once
    link_down,        ///< serial: the master's port is unplugged
    link_up,          ///< the end of that
    tcp_reset,        ///< the connection is closed from outside
    tcp_half_open,    ///< the connection loses everything, both ways, until it is closed
    connect_refused,  ///< an attempt to connect again fails
    // A server that ends its connections (see Ending), drawn apart from the other kinds.
    close_after_response,  ///< behind a response, at once or up to 3 ms later
    close_at_random,       ///< instead of a response; half of the requests are executed
    close_on_request,      ///< the same, always for the same requests and for devices that are dead
    close_when_idle,       ///< when nothing was sent for that long
};
inline constexpr std::size_t kFaultKinds = static_cast<std::size_t>(FaultKind::close_when_idle) + 1;

/// "bit_error", …
std::string_view name(FaultKind kind);

/// Scheduled kinds (FaultRates::mean_between), as opposed to kinds per exchange (FaultRates::per_million).
/// The ends device_back and link_up have no rate; connect_refused is drawn per attempt (per million),
/// close_on_request once for each function and range of a unit. The time of close_when_idle is not drawn.
bool is_timed(FaultKind kind);

/// A server that ends its connections.
bool is_close(FaultKind kind);

/// Faults of the line, not of one device: noise, clock_jump, and all of link and connection.
bool is_of_line(FaultKind kind);

/// Whether the kind exists on a line: `serial` as in model::Line::is_serial().
bool possible(FaultKind kind, wire::Framing framing, bool serial);

struct FaultCounts {
    std::array<std::uint64_t, kFaultKinds> injected{};
    /// Faults from which the device (of the line: any device) recovered: a valid answer reached the master
    /// afterwards. Several faults of one kind before it count once each.
    std::array<std::uint64_t, kFaultKinds> recovered{};
    std::uint64_t exchanges = 0;  ///< requests sent to a simulated device
    std::uint64_t bytes = 0;      ///< characters on the wire, both ways
    /// Damage that was drawn again because it formed another valid frame, alone or with earlier characters.
    /// No master can detect such damage.
    std::uint64_t redrawn = 0;

    [[nodiscard]] std::uint64_t of(FaultKind kind) const { return injected[static_cast<std::size_t>(kind)]; }
    [[nodiscard]] std::uint64_t recovered_from(FaultKind kind) const {
        return recovered[static_cast<std::size_t>(kind)];
    }
    [[nodiscard]] std::uint64_t total() const;
    FaultCounts& operator+=(const FaultCounts& other);
};

/// Rates. All zero: no faults.
struct FaultRates {
    std::array<std::uint32_t, kFaultKinds> per_million{};  ///< of exchanges; their sum at most a million
    std::array<Duration, kFaultKinds> mean_between{};      ///< of those by the clock; zero: never

    FaultRates& set(FaultKind kind, std::uint32_t of_a_million);
    FaultRates& every(FaultKind kind, Duration mean);

    /// Every kind per exchange with that rate, every scheduled kind with that mean interval (zero: none).
    static FaultRates all(std::uint32_t per_million, Duration mean_between);
};

/// The turnaround, from the end of a request to the beginning of the answer, drawn for each.
struct Turnaround {
    enum class Shape : std::uint8_t {
        constant,   ///< least
        uniform,    ///< anything from least to most
        long_tail,  ///< mostly near least, one in a hundred beyond half way, at the longest most
    };
    Shape shape = Shape::constant;
    Duration least{};
    Duration most{};

    [[nodiscard]] Duration draw(Random& random) const;
};

/// Limits of a duration, inclusive.
struct DurationRange {
    Duration least{};
    Duration most{};
};

/// The faults of one line. Plain data; the same plan, project and calls give the same bytes.
struct FaultPlan {
    std::uint64_t seed = 1;
    FaultRates rates;                 ///< of the line, and of every device that has none of its own
    std::vector<FaultRates> devices;  ///< by the index of the device; kinds of is_of_line() do not count here
    /// Turnaround by index of the device; missing: its Behaviour::turnaround. A draw beyond the device's
    /// deadline counts as late_response.
    std::vector<std::optional<Turnaround>> turnarounds;
    /// By index of the device; missing: false. False: answers in the order of its requests, so that those
    /// behind a late one are late too (one task). True: answers other requests meanwhile (a gateway, several
    /// tasks).
    std::vector<bool> out_of_order;
    /// False: a late response comes within a response time-out after its deadline, a copy within 10 ms.
    bool merciless = true;
    DurationRange dead{std::chrono::seconds(1), std::chrono::seconds(60)};  ///< how long
    DurationRange reboot{std::chrono::milliseconds(200), std::chrono::seconds(5)};
    DurationRange babble{std::chrono::milliseconds(5), std::chrono::milliseconds(1500)};
    DurationRange jump{std::chrono::milliseconds(200), std::chrono::seconds(5)};
    DurationRange unplugged{std::chrono::milliseconds(100), std::chrono::seconds(20)};
    DurationRange half_open{std::chrono::seconds(1), std::chrono::seconds(30)};
    bool derive_timeouts = true;  ///< as in the project: lateness depends on them
    Duration timeout_margin = std::chrono::milliseconds(2);
    Instant quiet_from = kNever;  ///< from then on nothing new, what goes on ends at once, turnarounds
                                  ///< are the least
};

/// One fault.
struct FaultEvent {
    Instant time;
    FaultKind kind{};
    std::optional<std::size_t> device;  ///< index in the line; nothing: of the line
    std::optional<Instant> until;       ///< of what lasts: its end
};

/// Called when a fault takes effect, not when it is drawn. Must not call the simulation.
class FaultObserver {
public:
    virtual void on_fault(const FaultEvent& event) = 0;

protected:
    ~FaultObserver() = default;
};

}  // namespace takt::sim
