// The field table: every key of a project file with its kind and range (docs/project-file.md;
// docs/specification.md, section 2). Ranges may depend on the context. All readers of projects use it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "takt/model/project.hpp"

namespace takt::model {

/// Words of the enumerations, in the order of their enum's values.
inline constexpr std::array<std::string_view, 2> kProfiles{"generic", "owen-kc1"};
inline constexpr std::array<std::string_view, 4> kTransports{"serial", "tcp", "tls", "simulated"};
inline constexpr std::array<std::string_view, 3> kFramings{"rtu", "ascii", "tcp"};
inline constexpr std::array<std::string_view, 3> kParities{"none", "even", "odd"};
inline constexpr std::array<std::string_view, 4> kRs485{"auto", "kernel", "rts", "none"};
inline constexpr std::array<std::string_view, 2> kOrders{"deadline", "address"};
inline constexpr std::array<std::string_view, 4> kConnections{"keep", "per_request", "per_cycle",
                                                              "on_demand"};
inline constexpr std::array<std::string_view, 3> kStrategies{"single", "classic", "optimal"};
inline constexpr std::array<std::string_view, 3> kGaps{"never", "learn", "always"};
/// Instead of a time.
inline constexpr std::array<std::string_view, 1> kTurnarounds{"learn"};
/// Without a word for WriteSingle::as_declared, which is the absence of the key.
inline constexpr std::array<std::string_view, 3> kWriteSingle{"allowed", "only", "never"};
inline constexpr std::array<std::string_view, 4> kAreas{"coil", "discrete_input", "input_register",
                                                        "holding_register"};
/// Words for servers, instruments and overlays: the first or the last ones of their enums.
inline constexpr std::array<std::string_view, 3> kServerTransports{"serial", "tcp", "tls"};
inline constexpr std::array<std::string_view, 2> kInstrumentTransports{"serial", "tcp"};
inline constexpr std::array<std::string_view, 2> kRegisterAreas{"input_register", "holding_register"};
inline constexpr std::array<std::string_view, 3> kAccessVerdicts{"allow", "read_only", "deny"};
inline constexpr std::array<std::string_view, 3> kDurabilities{"ack", "100ms", "none"};
/// When a write that is passed on is answered.
inline constexpr std::array<std::string_view, 2> kAnswers{"when_done", "at_once"};
/// The order of mirrored values.
inline constexpr std::array<std::string_view, 3> kMirrorOrders{"project", "address", "name"};
inline constexpr std::array<std::string_view, 2> kOutputTransports{"mqtt", "history"};
inline constexpr std::array<std::string_view, 3> kMqttVersions{"auto", "5", "3.1.1"};
/// What a message of an output carries.
inline constexpr std::array<std::string_view, 3> kMessageScopes{"variable", "device", "request"};
/// How samples that wait for the broker travel.
inline constexpr std::array<std::string_view, 2> kBacklogs{"single", "array"};
inline constexpr std::array<std::string_view, 2> kBadQuality{"publish", "skip"};
inline constexpr std::array<std::string_view, 4> kChecksums{"none", "sum", "xor", "crc16"};
/// Numbers in the answer of an instrument.
inline constexpr std::array<std::string_view, 10> kFieldTypes{
    "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float", "double"};
/// Names of the types for data_type(); the last two are aliases.
inline constexpr std::array<std::string_view, 12> kTypes{"bool",   "int16",  "uint16", "int32",
                                                         "uint32", "int64",  "uint64", "float",
                                                         "double", "string", "int",    "real"};
inline constexpr std::array<std::string_view, 5> kReadFunctions{"none", "0x01", "0x02", "0x03", "0x04"};
inline constexpr std::array<std::string_view, 5> kWriteFunctions{"none", "0x05", "0x06", "0x0F", "0x10"};

/// The objects of a project file: entries of lists, and the mappings behind a key.
enum class Object : std::uint8_t {
    project,
    line,
    device,
    variable,
    local,
    host,
    faults,
    backoff,
    round_trip,
    tls,
    areas,
    server,
    unit,
    bank,
    mirror,
    limit,
    identification,
    file,
    fifo,
    access,
    relay,
    relay_map,
    served_variable,
    source,
    sine,
    ramp,
    random_walk,
    counter,
    replay,
    file_source,
    command_source,
    command,
    sink,
    instrument,
    exchange,
    start_command,
    instrument_command,
    read_back,
    answer,
    measurement,
    output,
    output_selection,  // the last of a project
    firmware,          // a file of its own (firmware.hpp)
};
/// Those of a project.
inline constexpr auto kObjects = [] {
    std::array<Object, static_cast<std::size_t>(Object::output_selection) + 1> all{};
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<Object>(i);
    return all;
}();

enum class Kind : std::uint8_t {
    integer,
    duration,  ///< with its unit; ranges in nanoseconds. With `words` one of them may stand instead
    boolean,
    number,         ///< floating point
    text,           ///< the range is that of its length in characters
    word,           ///< one of `words`
    function,       ///< one of `words`, as a number in any notation
    local_bool,     ///< the name of a local bool
    local_integer,  ///< the name of a local of an integer type
    constant,       ///< a value of the object's type
    reference,      ///< one-based number with its area, in quotes
    list,           ///< of further objects
    mapping,        ///< with the keys of the field's `object`
    words,          ///< numbers with words: {0: off, 1: on}; in a table `0=off, 1=on`
    ranges,         ///< a list of items: 7, 0..99, 0-99, [0, 99]; the range is that of each bound
};

/// The settings that ranges depend on.
struct Context {
    Profile profile = Profile::generic;
    Transport transport = Transport::serial;
    wire::Framing framing = wire::Framing::rtu;

    /// Serial characters, on a real or a simulated line.
    [[nodiscard]] bool is_serial() const {
        return transport == Transport::serial ||
               (transport == Transport::simulated && framing != wire::Framing::tcp);
    }
};

struct Range {
    std::int64_t least = 0;
    std::int64_t greatest = 0;
    std::int64_t tolerated = greatest;  ///< up to here accepted with a warning
    friend bool operator==(const Range&, const Range&) = default;
};

struct Field {
    std::string_view key;
    Kind kind = Kind::text;
    bool required = false;
    Range (*range)(const Context&) = nullptr;  ///< of integers, durations and the length of texts
    std::span<const std::string_view> words;
    /// Whether the word of that index is allowed in this context; nullptr: all words are.
    bool (*fits)(std::size_t word, const Context&) = nullptr;
    /// 0 is out of range; it is replaced by this value with a warning. nullptr: it is an error.
    std::int64_t (*zero_means)(const Context&) = nullptr;
    /// The object of a mapping (kind mapping), or of a mapping allowed instead of the value (other kinds).
    std::optional<Object> object;
    /// The value names a command, a file or an environment variable of the host. Only a person with access to
    /// the project file may add or change it.
    bool names_host_resource = false;
    /// The value is a secret or names one. The program sends it to, or uses it at, another computer.
    bool secret = false;
    /// Decides where the secrets of its object go, and how that computer is verified. While a secret of the
    /// object is set, only a person with access to the project file may change it.
    bool directs_secret = false;
};

/// The keys of an object, in the order in which they are described.
[[nodiscard]] std::span<const Field> fields(Object object);

/// The field of a key, or nullptr.
[[nodiscard]] const Field* find_field(Object object, std::string_view key);

/// The path of objects of that kind: "", "lines[]", "lines[].devices[]", "host", …; the first one of several.
[[nodiscard]] std::string_view location(Object object);

/// The keys of an object as text: "jitter, overhead".
[[nodiscard]] std::string keys_of(Object object);

/// The allowed values of a field as text: "0..65535", "1ms..65535ms", "rtu, ascii"; of a mapping its keys.
/// Empty if there is no range, and for texts, whose range is that of their length.
[[nodiscard]] std::string allowed(const Field& field, const Context& context);

/// The limits a profile puts on frames.
[[nodiscard]] wire::FrameLimits limits_of(Profile profile);

}  // namespace takt::model
