// The project as the user describes it (design, section 6; requirements, sections 1 and 2), checked and
// complete: every default is filled in, every name resolved to an index.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/network.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/model/document.hpp"
#include "takt/model/source.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {

/// Index into Project::locals.
using LocalIndex = std::size_t;

enum class Profile : std::uint8_t { generic, owen_kc1 };
enum class Transport : std::uint8_t { serial, tcp, tls, simulated };
enum class Rs485 : std::uint8_t { automatic, kernel, rts, none };
enum class PollOrder : std::uint8_t { deadline, address };
enum class Strategy : std::uint8_t { single, classic, optimal };
enum class Gaps : std::uint8_t { never, learn, always };
/// Which of the functions 0x05/0x06 (one item) and 0x0F/0x10 (several) a device takes for writing.
enum class WriteSingle : std::uint8_t {
    as_declared,  ///< not said: each variable is written with the function it names
    allowed,      ///< both: the cheaper one
    only,         ///< 0x05 and 0x06
    never,        ///< 0x0F and 0x10
};

/// Items of one area, both ends included.
struct ItemRange {
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    friend bool operator==(const ItemRange&, const ItemRange&) = default;
};

/// Ranges of each area, in the order of wire::Area; sorted, neither overlapping nor adjoining.
using AreaRanges = std::array<std::vector<ItemRange>, 4>;

/// Items that a device does not let anybody read, as it said so itself (gaps: learn).
struct RefusedItems {
    ItemRange items;
    std::uint8_t exception = 2;  ///< the code of its answer, 1..4
    Duration since{};            ///< how long ago it refused them first
    Duration checked{};          ///< and last; not longer than `since`
    friend bool operator==(const RefusedItems&, const RefusedItems&) = default;
};

/// What trying has shown of a device (gaps: learn), in the order of wire::Area.
struct Learnt {
    /// Most ranges that are remembered of an area, of each kind.
    static constexpr std::size_t kMostRanges = 4096;

    AreaRanges confirmed;                              ///< they were read together
    std::array<std::vector<RefusedItems>, 4> refused;  ///< ascending, not overlapping
    /// The longest read it answers where it refused a longer one whose parts it answers; 0: not met.
    std::array<std::uint16_t, 4> most_items{};
    friend bool operator==(const Learnt&, const Learnt&) = default;
};

/// At most `burst` at once, and then one each `min_interval` (guarantees, "Write on command").
struct Admission {
    Duration min_interval{};
    std::uint16_t burst = 1;
    friend bool operator==(const Admission&, const Admission&) = default;
};

/// What the computer adds (guarantees, "Model").
struct Host {
    Duration jitter = std::chrono::milliseconds(1);      ///< J: how late a release may be
    Duration overhead = std::chrono::microseconds(200);  ///< H: of each transaction
};

/// Assumed failures: in any window t at most burst + floor(t / every) attempts fail. Burst 0: none.
struct Faults {
    std::uint16_t burst = 1;
    Duration every = std::chrono::seconds(1);
};

/// How long a device that does not answer is left alone: first, then doubled up to the limit.
struct Backoff {
    Duration first = std::chrono::seconds(1);
    Duration limit = std::chrono::seconds(60);
};

/// One value in a device. Addresses are zero-based, as on the wire.
struct Variable {
    std::string name;
    Place place;
    DataType type = DataType::int16;
    wire::Area area = wire::Area::holding_register;
    std::uint16_t register_number =
        0;  ///< register; for a bool in a coil area the `register` of the file (coil / 16)
    std::optional<std::uint8_t> bit;     ///< of a bool: 0..15
    std::uint16_t registers = 1;         ///< registers it takes; 1 for a bool
    std::optional<wire::Function> read;  ///< 0x01..0x04
    /// 0x05, 0x06, 0x0F, 0x10. Of a bool in a register: only where the device has 0x16 or allows
    /// read-modify-write.
    std::optional<wire::Function> write;
    bool write_on_change = false;
    std::optional<LocalIndex> read_trigger;   ///< a local bool
    std::optional<LocalIndex> write_trigger;  ///< a local bool
    std::optional<LocalIndex> status;         ///< a local int; the device's does not count here
    std::optional<Admission> admission;       ///< of its writes on change; by a trigger: the local's
    Duration period{};                        ///< zero: as fast as the line allows
    std::optional<Duration> deadline;
    std::optional<Constant> default_value;
    bool hold_last = false;  ///< while the device does not answer: keep the last value instead of the default
    bool retain = false;
    bool used = true;
    ByteOrder order;
    double scale = 1;  ///< value = raw * scale + offset
    double offset = 0;
    double dead_band = 0;
    bool verify = false;
    bool safe_to_repeat = false;
    std::string unit;
    std::string comment;

    /// The address on the wire of its first item: the register, or the coil `register * 16 + bit`.
    [[nodiscard]] std::uint16_t start() const;
    /// Items it takes in a request: registers, or one coil.
    [[nodiscard]] std::uint16_t items() const { return is_bit_area(area) ? std::uint16_t{1} : registers; }
    /// Scaled: its value is a floating-point number whatever its type on the wire.
    [[nodiscard]] bool scaled() const { return scale != 1 || offset != 0; }
};

struct Device {
    std::string name;
    Place place;
    UnitId address{1};
    Duration poll_period = std::chrono::milliseconds(100);
    Duration response_timeout = std::chrono::milliseconds(100);
    std::optional<Duration> turnaround;  ///< longest time to the first byte of the response, when known
    Duration round_trip = std::chrono::milliseconds(1);  ///< TCP
    std::uint16_t attempts = 3;
    bool group_requests = false;
    std::uint16_t registers_per_request = 16;
    bool registers_per_request_set = false;  ///< the user wrote it
    Strategy strategy = Strategy::single;    ///< single whenever group_requests is false
    Gaps gaps = Gaps::never;                 ///< where it is not written and `readable` is: always
    AreaRanges readable;  ///< of an area with ranges, nothing else is read for the sake of grouping
    AreaRanges no_read;   ///< never read for the sake of grouping
    Learnt learnt;        ///< counts with gaps: learn; not in the project file
    WriteSingle write_single = WriteSingle::as_declared;
    bool fc22 = false;               ///< it has 0x16, mask write register
    bool fc23 = false;               ///< it has 0x17, read/write multiple registers
    bool read_modify_write = false;  ///< a bit may be written by reading its register and writing it back
    std::uint16_t in_flight = 1;     ///< TCP: requests it takes before it has answered: 1..16
    std::optional<Backoff> backoff;  ///< else the project's
    ByteOrder order;
    std::optional<LocalIndex> poll_enable;  ///< a local bool
    std::optional<LocalIndex> status;       ///< a local int
    std::string comment;
    std::vector<Variable> variables;
};

/// What others send over a line.
struct SharedLine {
    Duration response_timeout{};  ///< the longest of those who relay to it
    bool broadcast = false;       ///< one of them relays to unit 0
};

struct Line {
    std::string name;
    Place place;
    Transport transport = Transport::serial;
    std::string port;  ///< serial: the device file; tcp, tls: host name or address
    std::uint16_t tcp_port = 502;
    wire::Framing framing = wire::Framing::rtu;
    wire::CharacterFormat format;  ///< of serial and simulated serial lines
    Rs485 rs485 = Rs485::automatic;
    PollOrder order = PollOrder::deadline;
    Duration request_gap{};
    Duration frame_gap{};
    /// Longest pause inside a response, after which what came is taken as whole; nothing: 30 ms, t3.5 where
    /// that is longer (ASCII: 1 s; streams 50 ms).
    std::optional<Duration> byte_timeout;
    std::optional<SharedLine> relayed;  ///< a server relays to it
    /// Of what is relayed, one request in this time goes ahead of polling that is due.
    Duration relay_interval = std::chrono::seconds(1);
    std::vector<Device> devices;  ///< may be empty where it is relayed to

    /// RTU or ASCII characters on a real or simulated serial line, as opposed to a byte stream.
    [[nodiscard]] bool is_serial() const {
        return transport == Transport::serial ||
               (transport == Transport::simulated && framing != wire::Framing::tcp);
    }
};

/// A value of the project itself: triggers, statuses, enables, constants.
struct Local {
    std::string name;
    Place place;
    DataType type = DataType::boolean;
    std::optional<Constant> default_value;
    bool retain = false;
    std::optional<Admission> admission;  ///< of a trigger
    std::string comment;
};

/// The bits of an area are those of registers of the same unit, from register `first` on.
struct BitsOverRegisters {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t first = 0;
};

/// Values that a master may write to registers; `least` below zero: they count as int16.
struct RegisterLimits {
    std::vector<ItemRange> registers;  ///< holding registers
    std::int32_t least = 0;
    std::int32_t greatest = 65535;
};

/// An object of device identification (0x2B / 14).
struct IdentificationText {
    std::uint8_t id = 0;
    std::string text;
};

struct RecordFile {
    std::uint16_t number = 1;
    std::uint16_t records = 1;
    bool read_only = false;
};

/// What function 0x18 reads at an address, oldest first.
struct RegisterQueue {
    std::uint16_t address = 0;
    std::vector<std::uint16_t> values;
};

/// When a write of retained items is acknowledged, and when it is on the disk.
enum class Durability : std::uint8_t {
    acknowledged,  ///< acknowledged when it is on the disk
    interval,      ///< acknowledged at once, on the disk within 100 ms
    at_end,        ///< acknowledged at once, on the disk when the program ends in order
};

/// A unit of a server.
struct ServerUnit {
    Place place;
    UnitId address{1};
    AreaRanges offered;    ///< by area; without ranges there is no such area. With an overlay: of the bits
    AreaRanges read_only;  ///< by area
    AreaRanges retained;   ///< by area: they keep what was written to them over a restart
    Durability durability = Durability::acknowledged;
    std::string state;  ///< the file of what is retained, relative to the project's; empty: beside it
    std::array<std::optional<BitsOverRegisters>, 2> overlays;  ///< of coils and of discrete inputs
    std::vector<RegisterLimits> limits;
    std::vector<IdentificationText> identification;  ///< by id; empty: 0x2B / 14 is refused
    std::string server_id;                           ///< empty: 0x11 is refused
    std::vector<RecordFile> files;
    std::vector<RegisterQueue> fifos;
    std::optional<std::uint16_t> exception_coils;  ///< the first of the eight that 0x07 reads
    bool may_restart = false;
    bool may_listen_only = false;
    /// The project's own values in the registers of the unit. Of each only name, type, place, used, default
    /// value, order and comment count.
    std::vector<Variable> variables;
    std::vector<Binding> bindings;  ///< of some of them, in their order
};

/// What clients of a server may take of it, on each address it listens on.
struct ListenLimits {
    std::uint32_t max_connections = 256;                ///< at a time
    std::uint32_t max_per_peer = 64;                    ///< of them from one address
    Duration frame_timeout = std::chrono::seconds(2);   ///< from the first byte of a request to its last
    Duration idle_timeout = std::chrono::minutes(10);   ///< without any byte
    Duration write_timeout = std::chrono::seconds(10);  ///< of a client that does not take its answers
};

enum class AccessVerdict : std::uint8_t { allow, read_only, deny };

/// Requests a second of each peer, and how many of them at once.
struct AccessRate {
    std::uint32_t per_second = 1;
    std::uint32_t burst = 1;
};

/// Who may ask a server for what; of several rules the first that fits a request counts, and where there are
/// rules and none fits it is refused.
struct AccessRule {
    Place place;
    std::vector<Network> networks;
    bool serial = false;                  ///< peers on serial ports
    bool every_peer = true;               ///< none are named
    std::vector<ItemRange> units;         ///< 0..255; empty: all
    std::vector<std::uint8_t> functions;  ///< codes
    bool every_function = true;           ///< none are named
    std::optional<wire::Area> area;       ///< nothing: whatever the request touches
    std::vector<ItemRange> items;         ///< of `area`; empty: all
    AccessVerdict verdict = AccessVerdict::deny;
    std::optional<AccessRate> rate;
};

/// Requests to a unit that go on to another one.
struct UnitMapping {
    UnitId from{1};
    UnitId to{1};
};

/// Units of a server that are those of a line.
struct Relay {
    Place place;
    std::size_t line = 0;          ///< index into Project::lines
    std::vector<ItemRange> units;  ///< with the same addresses on the line
    std::vector<UnitMapping> map;  ///< each `from` once; go before `units`
    Duration cache{};              ///< how old an answer to the same read may be; zero: none is kept
    std::uint16_t attempts = 1;    ///< of a read
    Duration response_timeout = std::chrono::milliseconds(100);  ///< of units that are no device of the line
    Duration max_wait = std::chrono::seconds(5);                 ///< of a request for its turn
};

/// Where the project answers as a slave.
struct Server {
    std::string name;
    Place place;
    Transport transport = Transport::tcp;  ///< serial or tcp
    std::string port;                      ///< serial: the device file; tcp: the address to listen on
    std::uint16_t tcp_port = 502;
    wire::Framing framing = wire::Framing::tcp;
    wire::CharacterFormat format;  ///< serial
    Rs485 rs485 = Rs485::automatic;
    bool strict = false;             ///< RTU: pauses above t1.5 inside a frame spoil it
    Duration turnaround{};           ///< least time before an answer
    ListenLimits limits;             ///< tcp
    std::vector<AccessRule> access;  ///< empty: everybody may do everything
    std::string audit;               ///< file of writes and refusals, relative to the project's; empty: none
    std::vector<ServerUnit> units;   ///< may be empty where it relays
    std::vector<Relay> relays;       ///< an own unit goes before them, the first that has a unit counts
};

struct Project {
    int version = 1;
    Profile profile = Profile::generic;
    bool derive_timeouts = true;
    Duration timeout_margin = std::chrono::milliseconds(2);
    Host host;
    Faults faults;
    bool faults_set = false;  ///< the user wrote it
    Backoff backoff;
    std::vector<Line> lines;
    std::vector<Server> servers;
    std::vector<Instrument> instruments;
    std::vector<Local> locals;
    std::vector<std::string> files;  ///< for the file index of places

    /// The limits a profile puts on frames of that framing (requirements, sections 2 and 3).
    [[nodiscard]] wire::FrameLimits frame_limits() const;
};

std::string_view name(Profile profile);
std::string_view name(Transport transport);
std::string_view name(Strategy strategy);

}  // namespace takt::model
