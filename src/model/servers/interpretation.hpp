// The parts of interpret(): their common state and one function for each kind of object.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "reading/reader.hpp"
#include "takt/base/network.hpp"
#include "takt/model/findings.hpp"
#include "takt/model/project.hpp"

namespace takt::model {

/// The state of one interpretation. Objects keep the index that they have in the file, even invalid ones.
struct Interpretation {
    explicit Interpretation(const Document& source) : document(source) {}

    const Document& document;
    Context context;
    Findings findings;
    Project project;
    /// A field that another one may repeat.
    struct FirstUse {
        FirstUse(const Reader& reader, std::string_view key);
        FirstUse(const SourceLocation& where, const std::string& field);
        SourceLocation location;
        std::string path;  ///< empty where the location is known
    };
    using FirstUses = std::unordered_map<std::string, FirstUse>;
    FirstUses names;  ///< of variables and locals
    FirstUses line_names;
    FirstUses output_names;
    FirstUses ports;  ///< serial ports
    /// Where a server listens; `address`: nothing for all of them.
    struct Listener {
        std::optional<IpAddress> address;
        std::uint16_t tcp_port = 0;
        FirstUse use;
    };
    std::vector<Listener> listeners;
    std::unordered_map<unsigned, FirstUse> addresses;      ///< of the line that is being read
    std::unordered_map<std::string, LocalIndex> locals;    ///< that the project declares
    std::unordered_map<std::string, LocalIndex> services;  ///< service variables that the project uses
    /// A service variable of a line or device that may follow in the file.
    struct UsedService {
        std::string name;
        SourceLocation location;
        std::string path;
    };
    std::vector<UsedService> used_services;
    std::unordered_map<std::string, Variable*> polled;  ///< variables of lines, once those are read
    std::vector<bool> local_type_known;                 ///< by LocalIndex
    std::optional<Duration> deadline;                   ///< of the device that is being read
    bool backoff_given = false;                         ///< by the project
    /// Lines without devices. They are valid only if a server relays to them, which is known at the end.
    struct WithoutDevices {
        std::size_t line = 0;
        Rule rule{};
        SourceLocation location;
        std::string path;
    };
    std::vector<WithoutDevices> without_devices;
    /// Addresses that look like references, in the list of variables that is being read: the first one.
    struct LikeReferences {
        SourceLocation location;
        std::string path;
        std::string text;
        Arguments arguments;
        std::size_t count = 0;
    };
    LikeReferences like_references;

    /// "boiler.yaml:12", or "Line, Boiler" in a document without lines: for messages about two fields.
    [[nodiscard]] std::string describe(const FirstUse& first) const;
};

/// The name of an object. Reports a duplicate with `rule`. Empty if invalid or missing.
std::string read_name(Interpretation& state, Reader& reader, Interpretation::FirstUses& taken);

/// The order of bytes that an object states: by two switches, by `byte_order`, or by both if they agree.
/// @param inherited  of what is not stated
/// @param type       of the value; nothing: of all values of the object
ByteOrder read_byte_order(Reader& reader, ByteOrder inherited, std::optional<DataType> type);

/// The notation of the table in `variables`. It is applied where the table is read; a list in the project
/// itself has the standard notation.
void check_notation(Reader& reader);

/// The local that a field names, of the type that the field requires. A service variable becomes a local.
std::optional<LocalIndex> read_local(Interpretation& state, Reader& reader, std::string_view key);

/// Whether the key names a service variable.
bool names_service(const Reader& reader, std::string_view key);

/// The service variable that a key names, as a local of the project. Whether its line or device exists is
/// checked by check_services().
std::optional<LocalIndex> read_service(Interpretation& state, Reader& reader, std::string_view key);

/// The service variable of that name, as a local of the project; nothing if its form is not that of one.
std::optional<LocalIndex> use_service(Interpretation& state, const std::string& name,
                                      const SourceLocation& location, const std::string& path);

/// Reports the service variables that do not exist. To be called when all lines are known.
void check_services(Interpretation& state);

/// The allowed constants: the type, and the limits of strings and scaled values.
struct ConstantShape {
    DataType type = DataType::int16;
    std::size_t most_bytes = 250;  ///< of a string
    double scale = 1;
    double offset = 0;
};
std::optional<Constant> read_constant(Reader& reader, std::string_view key, const ConstantShape& shape);

/// `write_range` of a number: `0..120`, `0..` or `..120`, with bounds that the type can hold.
std::optional<WriteRange> read_write_range(Reader& reader, const ConstantShape& shape);

/// A back-off: a duration, the first pause, or a mapping. Missing keys are those of `base`; the limit is at
/// least the first pause.
std::optional<Backoff> read_backoff(Interpretation& state, Reader& reader, const Backoff& base);

/// `enumeration` and `bits`.
void read_value_words(Interpretation& state, Reader& reader, Variable& variable,
                      std::optional<DataType> type);

/// `tags` of a variable.
std::vector<std::string> read_tags(Interpretation& state, Reader& reader);

/// `min_interval` and `burst`.
std::optional<RateLimit> read_admission(Reader& reader);

/// Ranges of items, for all areas or by area; sorted and merged.
AreaRanges read_ranges(Interpretation& state, Reader& reader, std::string_view key);

/// Ranges of items behind one key, sorted and merged.
std::vector<ItemRange> read_item_ranges(Interpretation& state, Reader& reader, std::string_view key);

/// The access rules of a server.
std::vector<AccessRule> read_access(Interpretation& state, Reader& reader);

/// The keys of a connection to a host.
inline constexpr std::string_view kClientKeys[] = {"host", "tcp_port"};

/// Of Modbus over TLS, registered with the IANA as mbap-s.
inline constexpr std::uint16_t kModbusTlsPort = 802;

/// The files of `tls`, or those of the folder `certs` beside the project.
/// @param own  "client", "server": the name of the own certificate there
TlsFiles read_tls(Interpretation& state, Reader& reader, Transport transport, std::string_view own);

/// Whether the transport of an instrument is TLS, which is reported: instruments have none.
bool report_tls(Reader& reader);

/// A host, and no port or a number meant as `tcp_port`: a network, without `transport`.
bool names_host(const Reader& reader);

/// Reports a host that contains a port, or is neither a name nor an address; `*` is one to listen on.
/// Returns whether it is one.
bool check_host(Reader& reader, std::string_view key, std::string_view host);

/// Reports the missing `key` that a transport needs. Returns whether it is missing.
bool report_missing_port(Reader& reader, std::string_view key, std::string_view transport);

/// Registers the serial port behind the key `port`; reports a port that another object has. Empty: invalid.
void register_port(Interpretation& state, Reader& reader, const std::string& port);

/// Reports the given ones of the keys that another transport has.
void report_keys_without_effect(Reader& reader, std::span<const std::string_view> keys,
                                std::string_view transport);

/// Reads all keys of a character format, for a serial line or server.
wire::CharacterFormat read_character_format(Reader& reader, wire::Framing framing);

/// An item of a list of mappings; reports anything else.
bool is_mapping(Interpretation& state, const Node& item, const std::string& path);

Local interpret_local(Interpretation& state, const Node& node, const std::string& path);
Line interpret_line(Interpretation& state, const Node& node, const std::string& path);
Device interpret_device(Interpretation& state, const Node& node, const std::string& path);
Server interpret_server(Interpretation& state, const Node& node, const std::string& path);
/// `relay` of a server; marks the lines as shared.
void interpret_relays(Interpretation& state, Reader& server, std::vector<Relay>& relays);
/// To be called when all servers are known.
void check_lines_without_devices(Interpretation& state);
ServerUnit interpret_server_unit(Interpretation& state, const Node& node, const std::string& path);
Variable interpret_variable(Interpretation& state, const Device& device, const Node& node,
                            const std::string& path);
/// The same for a server; `more` reads its further keys.
Variable interpret_served_variable(Interpretation& state, const Device& shape, const Node& node,
                                   const std::string& path,
                                   const std::function<void(Reader&, const Variable&)>& more);
Instrument interpret_instrument(Interpretation& state, const Node& node, const std::string& path);

/// The binding of a server variable; nothing if there is none.
std::optional<Binding> read_binding(Interpretation& state, Reader& reader, const Variable& variable);

/// `mirror` of a unit: appends variables, bindings and banks of polled values. To be called when the unit has
/// all others.
/// @param shape  the order of bytes
void interpret_mirrors(Interpretation& state, Reader& reader, ServerUnit& unit, const Device& shape);

/// Parses a text template and reports its errors.
std::optional<TextTemplate> read_template(Reader& reader, std::string_view key);

/// Service variables that outputs name become locals. To be called before check_services().
void use_services_of_outputs(Interpretation& state, const Reader& project);

/// `outputs`. To be called at the end, when lines, locals and the limits of the profile are settled.
void interpret_outputs(Interpretation& state, Reader& project);

/// Removes devices and variables beyond the limits of the profile, in the order of address, then of the file.
void apply_profile(Interpretation& state);

}  // namespace takt::model
