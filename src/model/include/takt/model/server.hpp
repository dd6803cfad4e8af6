// A server of a project: its endpoint, its clients and its units.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/network.hpp"
#include "takt/base/numbers.hpp"
#include "takt/base/time.hpp"
#include "takt/model/device.hpp"
#include "takt/model/document.hpp"
#include "takt/model/line.hpp"
#include "takt/model/source.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {

/// The bits of an area that are those of registers of the same unit, from register `first` on.
struct BitsOverRegisters {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t first = 0;
    SourceLocation location;
    friend bool operator==(const BitsOverRegisters&, const BitsOverRegisters&) = default;
};

/// Values that a master may write to registers. With `least` below zero they are int16.
struct RegisterLimits {
    std::vector<ItemRange> registers;  ///< holding registers
    std::int32_t least = 0;
    std::int32_t greatest = 65535;
    SourceLocation location;
    friend bool operator==(const RegisterLimits&, const RegisterLimits&) = default;
};

/// An object of device identification (0x2B / 14).
struct IdentificationText {
    std::uint8_t id = 0;
    std::string text;
    friend bool operator==(const IdentificationText&, const IdentificationText&) = default;
};

struct RecordFile {
    std::uint16_t number = 1;
    std::uint16_t records = 1;
    bool read_only = false;
    friend bool operator==(const RecordFile&, const RecordFile&) = default;
};

/// A FIFO queue for function 0x18, oldest value first.
struct RegisterQueue {
    std::uint16_t address = 0;
    std::vector<std::uint16_t> values;
    friend bool operator==(const RegisterQueue&, const RegisterQueue&) = default;
};

/// When a write of retained items is acknowledged, and when it is on the disk.
enum class Durability : std::uint8_t {
    acknowledged,  ///< acknowledged when it is on the disk
    interval,      ///< acknowledged at once, on the disk within 100 ms
    at_end,        ///< acknowledged at once, on the disk when the program ends in order
};

/// A unit of a server.
struct ServerUnit {
    SourceLocation location;
    UnitId address{1};
    AreaRanges offered;    ///< by area; without ranges there is no such area. With an overlay: of the bits
    AreaRanges read_only;  ///< by area
    AreaRanges retained;   ///< by area: they keep what was written to them over a restart
    Durability durability = Durability::acknowledged;
    std::string state;  ///< file of the retained items, relative to the project's; empty: next to it
    std::array<std::optional<BitsOverRegisters>, 2> overlays;  ///< of coils and of discrete inputs
    std::vector<RegisterLimits> limits;
    std::vector<IdentificationText> identification;  ///< by id; empty: 0x2B / 14 is refused
    std::string server_id;                           ///< empty: 0x11 is refused
    std::vector<RecordFile> files;
    std::vector<RegisterQueue> fifos;
    std::optional<std::uint16_t> exception_coils;  ///< the first of the eight that 0x07 reads
    bool may_restart = false;
    bool may_listen_only = false;
    /// Values of the project itself in the registers of the unit. Only name, type, location, used, default
    /// value, order and comment are in use.
    std::vector<Variable> variables;
    std::vector<Binding> bindings;  ///< of some of them, in their order
    friend bool operator==(const ServerUnit&, const ServerUnit&) = default;
};

/// Limits for the clients of a server, per address it listens on.
struct ListenLimits {
    std::uint32_t max_connections = 256;                ///< at a time
    std::uint32_t max_per_peer = 64;                    ///< of them from one address
    Duration frame_timeout = std::chrono::seconds(2);   ///< from the first byte of a request to its last
    Duration idle_timeout = std::chrono::minutes(10);   ///< without any byte
    Duration write_timeout = std::chrono::seconds(10);  ///< of a client that does not take its answers
    friend bool operator==(const ListenLimits&, const ListenLimits&) = default;
};

enum class AccessPermission : std::uint8_t { allow, read_only, deny };

/// Rate limit of each peer: requests per second, and how many at once.
struct AccessRate {
    std::uint32_t per_second = 1;
    std::uint32_t burst = 1;
    friend bool operator==(const AccessRate&, const AccessRate&) = default;
};

/// Access rules. The first matching rule decides; if there are rules and none matches, the request is
/// refused.
struct AccessRule {
    SourceLocation location;
    std::vector<Network> networks;
    bool serial = false;                  ///< peers on serial ports
    bool every_peer = true;               ///< none are named
    std::vector<std::string> roles;       ///< of clients' certificates; "": no role. Empty: all
    std::vector<ItemRange> units;         ///< 0..255; empty: all
    std::vector<std::uint8_t> functions;  ///< codes
    bool every_function = true;           ///< none are named
    bool identification = false;          ///< function 43 with MEI type 14, beside `functions`
    bool other_encapsulated = false;      ///< function 43 with the other MEI types, beside `functions`
    std::optional<wire::Area> area;       ///< nothing: any area
    std::vector<ItemRange> items;         ///< of `area`; empty: all
    AccessPermission permission = AccessPermission::deny;
    std::optional<AccessRate> rate;
    friend bool operator==(const AccessRule&, const AccessRule&) = default;
};

/// Passes requests to a unit on to another unit.
struct UnitMapping {
    UnitId from{1};
    UnitId to{1};
    friend bool operator==(const UnitMapping&, const UnitMapping&) = default;
};

/// Units of a server whose requests are passed on to a line.
struct Relay {
    SourceLocation location;
    std::size_t line = 0;          ///< index into Project::lines
    std::vector<ItemRange> units;  ///< with the same addresses on the line
    std::vector<UnitMapping> map;  ///< each `from` once; go before `units`
    Duration cache{};              ///< how old an answer to the same read may be; zero: none is kept
    std::uint16_t attempts = 1;    ///< of a read
    Duration response_timeout = std::chrono::milliseconds(100);  ///< of units that are no device of the line
    Duration max_wait = std::chrono::seconds(5);                 ///< limit of a request's wait in the queue
    friend bool operator==(const Relay&, const Relay&) = default;
};

/// An endpoint where the project answers as a slave.
struct Server {
    std::string name;
    SourceLocation location;
    Transport transport = Transport::tcp;  ///< serial, tcp or tls
    std::string port;                      ///< serial: the device file; else the address to listen on
    std::uint16_t tcp_port = 502;
    TlsFiles tls;  ///< with Transport::tls
    wire::Framing framing = wire::Framing::tcp;
    wire::CharacterFormat format;  ///< serial
    Rs485 rs485 = Rs485::automatic;
    bool strict = false;                    ///< RTU: pauses above t1.5 inside a frame spoil it
    Duration turnaround{};                  ///< least time before an answer
    std::optional<Duration> byte_timeout;   ///< serial: longest pause between two bytes of a request
    std::optional<Duration> frame_timeout;  ///< serial: longest time from its first byte to its last
    ListenLimits limits;                    ///< tcp, tls
    std::vector<AccessRule> access;         ///< empty: everything is allowed
    std::string audit;              ///< file of writes and refusals, relative to the project's; empty: none
    std::vector<ServerUnit> units;  ///< may be empty where it relays
    std::vector<Relay> relays;  ///< own units take precedence; of several relays the first one with the unit
    friend bool operator==(const Server&, const Server&) = default;
};

}  // namespace takt::model
