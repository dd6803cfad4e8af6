#include "takt/model/fields.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include "takt/model/scalar.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t in_ns(Duration duration) {
    return duration.count();
}

template <std::int64_t least, std::int64_t greatest>
Range between(const Context&) {
    return {least, greatest};
}

constexpr auto* kShortTime = between<0, in_ns(65535ms)>;
constexpr auto* kLongTime = between<in_ns(1ms), in_ns(24h)>;
constexpr auto* kDeadline = between<in_ns(1us), in_ns(24h)>;
constexpr auto* kBurst = between<1, 255>;
constexpr auto* kItem = between<0, 65535>;
constexpr auto* kName = between<1, 128>;
constexpr auto* kComment = between<0, 1000>;

Range device_name(const Context& context) {
    return {1, context.profile == Profile::owen_kc1 ? 14 : 64};
}

Range address(const Context& context) {
    if (!context.is_serial()) return {0, 255};
    return {1, 247, 254};
}

Range period(const Context& context) {
    return {0, in_ns(context.profile == Profile::owen_kc1 ? Duration(65535ms) : Duration(24h))};
}

Range baud(const Context& context) {
    return {50, context.profile == Profile::owen_kc1 ? 115200 : 10'000'000};
}

Range data_bits(const Context& context) {
    return {context.framing == wire::Framing::ascii ? 7 : 8, 8};
}

Range request_gap(const Context& context) {
    return {context.profile == Profile::owen_kc1 ? in_ns(12ms) : 0, in_ns(65535ms)};
}

std::int64_t most_registers(const Context& context) {
    return static_cast<std::int64_t>(
        wire::max_items(context.framing, wire::Function::read_holding_registers, limits_of(context.profile)));
}
Range registers_per_request(const Context& context) {
    return {2, most_registers(context)};
}
Range length(const Context& context) {
    return {1, most_registers(context)};
}

bool transport_fits(std::size_t word, const Context& context) {
    const auto transport = static_cast<Transport>(word);
    return context.profile == Profile::generic || transport == Transport::serial ||
           transport == Transport::simulated;
}

bool framing_fits(std::size_t word, const Context& context) {
    const auto framing = static_cast<wire::Framing>(word);
    switch (context.transport) {
        case Transport::serial: return framing != wire::Framing::tcp;
        case Transport::tcp: return framing != wire::Framing::ascii;
        case Transport::tls: return framing == wire::Framing::tcp;
        case Transport::simulated:
            return context.profile == Profile::generic || framing != wire::Framing::tcp;
    }
    return false;
}

constexpr Field kProject[] = {
    {.key = "takt", .kind = Kind::integer, .required = true, .range = between<1, 1>},
    {.key = "profile", .kind = Kind::word, .words = kProfiles},
    {.key = "derive_timeouts", .kind = Kind::boolean},
    {.key = "timeout_margin", .kind = Kind::duration, .range = kShortTime},
    {.key = "host", .kind = Kind::mapping, .object = Object::host},
    {.key = "faults", .kind = Kind::mapping, .object = Object::faults},
    {.key = "backoff", .kind = Kind::duration, .range = kLongTime, .object = Object::backoff},
    {.key = "lines", .kind = Kind::list},
    {.key = "servers", .kind = Kind::list},
    {.key = "instruments", .kind = Kind::list},
    {.key = "locals", .kind = Kind::list},
};

constexpr Field kLine[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "transport", .kind = Kind::word, .words = kTransports, .fits = transport_fits},
    {.key = "port", .range = between<1, 255>},
    {.key = "host", .range = between<1, 255>},
    {.key = "tcp_port", .kind = Kind::integer, .range = between<1, 65535>},
    {.key = "framing", .kind = Kind::word, .words = kFramings, .fits = framing_fits},
    {.key = "baud", .kind = Kind::integer, .range = baud},
    {.key = "parity", .kind = Kind::word, .words = kParities},
    {.key = "stop_bits", .kind = Kind::integer, .range = between<1, 2>},
    {.key = "data_bits", .kind = Kind::integer, .range = data_bits},
    {.key = "rs485", .kind = Kind::word, .words = kRs485},
    {.key = "order", .kind = Kind::word, .words = kOrders},
    {.key = "request_gap", .kind = Kind::duration, .range = request_gap},
    {.key = "frame_gap", .kind = Kind::duration, .range = kShortTime},
    {.key = "byte_timeout", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(65535ms)>},
    {.key = "relay_interval", .kind = Kind::duration, .range = kLongTime},
    {.key = "devices", .kind = Kind::list},
};

constexpr Field kDevice[] = {
    {.key = "name", .required = true, .range = device_name},
    {.key = "address", .kind = Kind::integer, .required = true, .range = address},
    {.key = "poll_period", .kind = Kind::duration, .range = period},
    {.key = "response_timeout",
     .kind = Kind::duration,
     .range = between<in_ns(1ms), in_ns(65535ms)>,
     .zero_means = in_ns(100ms)},
    {.key = "turnaround", .kind = Kind::duration, .range = kShortTime},
    {.key = "round_trip", .kind = Kind::duration, .range = kShortTime},
    {.key = "deadline", .kind = Kind::duration, .range = kDeadline},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 255>, .zero_means = 1},
    {.key = "backoff", .kind = Kind::duration, .range = kLongTime, .object = Object::backoff},
    {.key = "in_flight", .kind = Kind::integer, .range = between<1, 16>},
    {.key = "group_requests", .kind = Kind::boolean},
    {.key = "registers_per_request", .kind = Kind::integer, .range = registers_per_request},
    {.key = "strategy", .kind = Kind::word, .words = kStrategies},
    {.key = "gaps", .kind = Kind::word, .words = kGaps},
    {.key = "readable", .kind = Kind::ranges, .range = kItem, .object = Object::areas},
    {.key = "no_read", .kind = Kind::ranges, .range = kItem, .object = Object::areas},
    {.key = "write_single", .kind = Kind::word, .words = kWriteSingle},
    {.key = "fc22", .kind = Kind::boolean},
    {.key = "fc23", .kind = Kind::boolean},
    {.key = "read_modify_write", .kind = Kind::boolean},
    {.key = "high_byte_first", .kind = Kind::boolean},
    {.key = "high_register_first", .kind = Kind::boolean},
    {.key = "poll_enable", .kind = Kind::local_bool},
    {.key = "status", .kind = Kind::local_integer},
    {.key = "comment", .range = kComment},
    {.key = "variables", .kind = Kind::list},
};

constexpr Field kVariable[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "type", .kind = Kind::word, .required = true, .words = kTypes},
    {.key = "area", .kind = Kind::word, .words = kAreas},
    {.key = "register", .kind = Kind::integer, .range = between<0, 65535>},
    {.key = "bit", .kind = Kind::integer, .range = between<0, 15>},
    {.key = "coil", .kind = Kind::integer, .range = between<0, 65535>},
    {.key = "reference", .kind = Kind::reference},
    {.key = "length", .kind = Kind::integer, .range = length},
    {.key = "read", .kind = Kind::function, .words = kReadFunctions},
    {.key = "write", .kind = Kind::function, .words = kWriteFunctions},
    {.key = "write_on_change", .kind = Kind::boolean},
    {.key = "min_interval", .kind = Kind::duration, .range = kLongTime},
    {.key = "burst", .kind = Kind::integer, .range = kBurst},
    {.key = "read_trigger", .kind = Kind::local_bool},
    {.key = "write_trigger", .kind = Kind::local_bool},
    {.key = "status", .kind = Kind::local_integer},
    {.key = "period", .kind = Kind::duration, .range = period},
    {.key = "deadline", .kind = Kind::duration, .range = kDeadline},
    {.key = "default", .kind = Kind::constant},
    {.key = "hold_last", .kind = Kind::boolean},
    {.key = "retain", .kind = Kind::boolean},
    {.key = "used", .kind = Kind::boolean},
    {.key = "high_byte_first", .kind = Kind::boolean},
    {.key = "high_register_first", .kind = Kind::boolean},
    {.key = "scale", .kind = Kind::number},
    {.key = "offset", .kind = Kind::number},
    {.key = "dead_band", .kind = Kind::number},
    {.key = "verify", .kind = Kind::boolean},
    {.key = "safe_to_repeat", .kind = Kind::boolean},
    {.key = "unit", .range = between<0, 32>},
    {.key = "comment", .range = kComment},
};

constexpr Field kLocal[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "type", .kind = Kind::word, .required = true, .words = kTypes},
    {.key = "default", .kind = Kind::constant},
    {.key = "retain", .kind = Kind::boolean},
    {.key = "min_interval", .kind = Kind::duration, .range = kLongTime},
    {.key = "burst", .kind = Kind::integer, .range = kBurst},
    {.key = "comment", .range = kComment},
};

constexpr Field kHost[] = {
    {.key = "jitter", .kind = Kind::duration, .range = kShortTime},
    {.key = "overhead", .kind = Kind::duration, .range = kShortTime},
};

constexpr Field kFaults[] = {
    {.key = "burst", .kind = Kind::integer, .range = between<0, 255>},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
};

constexpr Field kBackoff[] = {
    {.key = "first", .kind = Kind::duration, .range = kLongTime},
    {.key = "limit", .kind = Kind::duration, .range = kLongTime},
};

constexpr Field kByArea[] = {
    {.key = kAreas[0], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[1], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[2], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[3], .kind = Kind::ranges, .range = kItem},
};

constexpr Field kServer[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "transport", .kind = Kind::word, .words = kServerTransports},
    {.key = "port", .range = between<1, 255>},
    {.key = "listen", .range = between<1, 255>},
    {.key = "tcp_port", .kind = Kind::integer, .range = between<1, 65535>},
    {.key = "framing", .kind = Kind::word, .words = kFramings, .fits = framing_fits},
    {.key = "baud", .kind = Kind::integer, .range = baud},
    {.key = "parity", .kind = Kind::word, .words = kParities},
    {.key = "stop_bits", .kind = Kind::integer, .range = between<1, 2>},
    {.key = "data_bits", .kind = Kind::integer, .range = data_bits},
    {.key = "rs485", .kind = Kind::word, .words = kRs485},
    {.key = "strict", .kind = Kind::boolean},
    {.key = "turnaround", .kind = Kind::duration, .range = kShortTime},
    {.key = "max_connections", .kind = Kind::integer, .range = between<1, 20000>},
    {.key = "max_per_peer", .kind = Kind::integer, .range = between<1, 20000>},
    {.key = "frame_timeout", .kind = Kind::duration, .range = kLongTime},
    {.key = "idle_timeout", .kind = Kind::duration, .range = kLongTime},
    {.key = "write_timeout", .kind = Kind::duration, .range = kLongTime},
    {.key = "access", .kind = Kind::list},
    {.key = "audit", .range = between<1, 255>},
    {.key = "units", .kind = Kind::list},
    {.key = "relay", .kind = Kind::list},
};

constexpr Field kAccess[] = {
    {.key = "peers", .kind = Kind::list},
    {.key = "units", .kind = Kind::ranges, .range = between<0, 255>},
    {.key = "functions", .kind = Kind::list},
    {.key = "area", .kind = Kind::word, .words = kAreas},
    {.key = "items", .kind = Kind::ranges, .range = kItem},
    {.key = "rule", .kind = Kind::word, .required = true, .words = kAccessVerdicts},
    {.key = "rate", .kind = Kind::integer, .range = between<1, 1'000'000>},
    {.key = "burst", .kind = Kind::integer, .range = between<1, 1'000'000>},
};

constexpr Field kUnit[] = {
    {.key = "address", .kind = Kind::integer, .required = true, .range = address},
    {.key = "banks", .kind = Kind::list, .required = true},
    {.key = "limits", .kind = Kind::list},
    {.key = "identification", .kind = Kind::list},
    {.key = "server_id", .range = between<0, 248>},
    {.key = "files", .kind = Kind::list},
    {.key = "fifos", .kind = Kind::list},
    {.key = "exception_coils", .kind = Kind::integer, .range = between<0, 65528>},
    {.key = "durability", .kind = Kind::word, .words = kDurabilities},
    {.key = "state", .range = between<1, 255>},
    {.key = "restart", .kind = Kind::boolean},
    {.key = "listen_only", .kind = Kind::boolean},
    {.key = "high_byte_first", .kind = Kind::boolean},
    {.key = "high_register_first", .kind = Kind::boolean},
    {.key = "variables", .kind = Kind::list},
};

constexpr Field kBank[] = {
    {.key = "area", .kind = Kind::word, .required = true, .words = kAreas},
    {.key = "items", .kind = Kind::ranges, .required = true, .range = kItem},
    {.key = "read_only", .kind = Kind::ranges, .range = kItem},
    {.key = "retain", .kind = Kind::ranges, .range = kItem},
    {.key = "overlay", .kind = Kind::word, .words = kRegisterAreas},
    {.key = "overlay_register", .kind = Kind::integer, .range = kItem},
};

constexpr Field kLimit[] = {
    {.key = "registers", .kind = Kind::ranges, .required = true, .range = kItem},
    {.key = "least", .kind = Kind::integer, .required = true, .range = between<-32768, 65535>},
    {.key = "greatest", .kind = Kind::integer, .required = true, .range = between<-32768, 65535>},
};

constexpr Field kIdentification[] = {
    {.key = "id", .kind = Kind::integer, .required = true, .range = between<0, 255>},
    {.key = "text", .required = true, .range = between<0, 61>},
};

constexpr Field kFile[] = {
    {.key = "number", .kind = Kind::integer, .required = true, .range = between<1, 65535>},
    {.key = "records", .kind = Kind::integer, .required = true, .range = between<1, 10000>},
    {.key = "read_only", .kind = Kind::boolean},
};

constexpr Field kFifo[] = {
    {.key = "register", .kind = Kind::integer, .required = true, .range = kItem},
    {.key = "values", .kind = Kind::list, .required = true},
};

constexpr Field kRelay[] = {
    {.key = "line", .required = true, .range = kName},
    {.key = "units", .kind = Kind::ranges, .range = between<0, 255>},
    {.key = "map", .kind = Kind::list},
    {.key = "cache", .kind = Kind::duration, .range = between<0, in_ns(1min)>},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 10>},
    {.key = "response_timeout", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(65535ms)>},
    {.key = "max_wait", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(10min)>},
};

constexpr Field kRelayMap[] = {
    {.key = "from", .kind = Kind::integer, .required = true, .range = between<0, 255>},
    {.key = "to", .kind = Kind::integer, .required = true, .range = between<0, 255>},
};

/// A variable of a server has all keys of a variable, and what it is bound to.
constexpr auto kServedVariable = [] {
    constexpr Field kOwn[] = {
        {.key = "source", .kind = Kind::mapping, .object = Object::source},
        {.key = "writes_to", .kind = Kind::mapping, .object = Object::sink},
        {.key = "max_age", .kind = Kind::duration, .range = kLongTime},
        {.key = "answer", .kind = Kind::word, .words = kAnswers},
    };
    std::array<Field, std::size(kVariable) + std::size(kOwn)> all;
    std::ranges::copy(kOwn, std::ranges::copy(kVariable, all.begin()).out);
    return all;
}();

constexpr auto* kPath = between<1, 1000>;
constexpr auto* kShortest = between<in_ns(10ms), in_ns(24h)>;  // between two looks at something

constexpr Field kSource[] = {
    {.key = "constant", .kind = Kind::constant},
    {.key = "sine", .kind = Kind::mapping, .object = Object::sine},
    {.key = "ramp", .kind = Kind::mapping, .object = Object::ramp},
    {.key = "random_walk", .kind = Kind::mapping, .object = Object::random_walk},
    {.key = "counter", .kind = Kind::mapping, .object = Object::counter},
    {.key = "replay", .kind = Kind::mapping, .object = Object::replay},
    {.key = "file", .kind = Kind::mapping, .object = Object::file_source},
    {.key = "command", .kind = Kind::mapping, .object = Object::command_source},
    {.key = "variable", .range = kName},
    {.key = "local", .range = kName},
    {.key = "instrument", .range = between<1, 257>},
};

constexpr Field kSine[] = {
    {.key = "amplitude", .kind = Kind::number, .required = true},
    {.key = "offset", .kind = Kind::number},
    {.key = "period", .kind = Kind::duration, .required = true, .range = kLongTime},
};

constexpr Field kRamp[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "period", .kind = Kind::duration, .required = true, .range = kLongTime},
};

constexpr Field kRandomWalk[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "step", .kind = Kind::number},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
    {.key = "seed", .kind = Kind::integer, .range = between<0, 4294967295>},
};

constexpr Field kCounter[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "step", .kind = Kind::number},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
};

constexpr Field kReplay[] = {
    {.key = "file", .required = true, .range = kPath},
    {.key = "column", .required = true, .range = kName},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "loop", .kind = Kind::boolean},
};

constexpr Field kFileSource[] = {
    {.key = "path", .required = true, .range = kPath},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "pattern", .range = between<1, 256>},
};

constexpr auto* kCommandTime = between<in_ns(1ms), in_ns(5min)>;

constexpr Field kCommandSource[] = {
    {.key = "run", .kind = Kind::list, .required = true},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
    {.key = "pattern", .range = between<1, 256>},
};

constexpr Field kCommand[] = {
    {.key = "run", .kind = Kind::list, .required = true},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
};

constexpr Field kSink[] = {
    {.key = "variable", .range = kName},
    {.key = "local", .range = kName},
    {.key = "command", .kind = Kind::mapping, .object = Object::command},
};

constexpr Field kInstrument[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "transport", .kind = Kind::word, .words = kServerTransports},
    {.key = "port", .range = between<1, 255>},
    {.key = "host", .range = between<1, 255>},
    {.key = "tcp_port", .kind = Kind::integer, .range = between<1, 65535>},
    {.key = "baud", .kind = Kind::integer, .range = baud},
    {.key = "parity", .kind = Kind::word, .words = kParities},
    {.key = "stop_bits", .kind = Kind::integer, .range = between<1, 2>},
    {.key = "data_bits", .kind = Kind::integer, .range = between<7, 8>},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(60s)>},
    {.key = "exchanges", .kind = Kind::list, .required = true},
};

constexpr Field kExchange[] = {
    {.key = "request", .range = between<1, 256>},
    {.key = "answer", .kind = Kind::mapping, .required = true, .object = Object::answer},
};

constexpr Field kAnswer[] = {
    {.key = "until", .range = between<1, 64>},
    {.key = "pattern", .range = between<1, 256>},
    {.key = "length", .kind = Kind::integer, .range = between<1, 256>},
    {.key = "begins", .range = between<1, 256>},
    {.key = "checksum", .kind = Kind::word, .words = kChecksums},
    {.key = "fields", .kind = Kind::list},
};

constexpr Field kMeasurement[] = {
    {.key = "name", .required = true, .range = kName},
    {.key = "offset", .kind = Kind::integer, .required = true, .range = between<0, 255>},
    {.key = "type", .kind = Kind::word, .required = true, .words = kFieldTypes},
    {.key = "high_byte_first", .kind = Kind::boolean},
    {.key = "high_register_first", .kind = Kind::boolean},
};

std::string bound_text(const Field& field, std::int64_t bound) {
    return field.kind == Kind::duration ? to_text(Duration(bound)) : std::to_string(bound);
}

}  // namespace

std::span<const Field> fields(Object object) {
    switch (object) {
        case Object::project: return kProject;
        case Object::line: return kLine;
        case Object::device: return kDevice;
        case Object::variable: return kVariable;
        case Object::local: return kLocal;
        case Object::host: return kHost;
        case Object::faults: return kFaults;
        case Object::backoff: return kBackoff;
        case Object::areas: return kByArea;
        case Object::server: return kServer;
        case Object::unit: return kUnit;
        case Object::bank: return kBank;
        case Object::limit: return kLimit;
        case Object::identification: return kIdentification;
        case Object::file: return kFile;
        case Object::fifo: return kFifo;
        case Object::access: return kAccess;
        case Object::relay: return kRelay;
        case Object::relay_map: return kRelayMap;
        case Object::served_variable: return kServedVariable;
        case Object::source: return kSource;
        case Object::sine: return kSine;
        case Object::ramp: return kRamp;
        case Object::random_walk: return kRandomWalk;
        case Object::counter: return kCounter;
        case Object::replay: return kReplay;
        case Object::file_source: return kFileSource;
        case Object::command_source: return kCommandSource;
        case Object::command: return kCommand;
        case Object::sink: return kSink;
        case Object::instrument: return kInstrument;
        case Object::exchange: return kExchange;
        case Object::answer: return kAnswer;
        case Object::measurement: return kMeasurement;
    }
    return {};
}

const Field* find_field(Object object, std::string_view key) {
    for (const auto& field : fields(object))
        if (field.key == key) return &field;
    return nullptr;
}

std::string_view location(Object object) {
    switch (object) {
        case Object::project: return "";
        case Object::line: return "lines[]";
        case Object::device: return "lines[].devices[]";
        case Object::variable: return "lines[].devices[].variables[]";
        case Object::local: return "locals[]";
        case Object::host: return "host";
        case Object::faults: return "faults";
        case Object::backoff: return "backoff";
        case Object::areas: return "lines[].devices[].readable";
        case Object::server: return "servers[]";
        case Object::unit: return "servers[].units[]";
        case Object::bank: return "servers[].units[].banks[]";
        case Object::limit: return "servers[].units[].limits[]";
        case Object::identification: return "servers[].units[].identification[]";
        case Object::file: return "servers[].units[].files[]";
        case Object::fifo: return "servers[].units[].fifos[]";
        case Object::access: return "servers[].access[]";
        case Object::relay: return "servers[].relay[]";
        case Object::relay_map: return "servers[].relay[].map[]";
        case Object::served_variable: return "servers[].units[].variables[]";
        case Object::source: return "servers[].units[].variables[].source";
        case Object::sine: return "servers[].units[].variables[].source.sine";
        case Object::ramp: return "servers[].units[].variables[].source.ramp";
        case Object::random_walk: return "servers[].units[].variables[].source.random_walk";
        case Object::counter: return "servers[].units[].variables[].source.counter";
        case Object::replay: return "servers[].units[].variables[].source.replay";
        case Object::file_source: return "servers[].units[].variables[].source.file";
        case Object::command_source: return "servers[].units[].variables[].source.command";
        case Object::command: return "servers[].units[].variables[].writes_to.command";
        case Object::sink: return "servers[].units[].variables[].writes_to";
        case Object::instrument: return "instruments[]";
        case Object::exchange: return "instruments[].exchanges[]";
        case Object::answer: return "instruments[].exchanges[].answer";
        case Object::measurement: return "instruments[].exchanges[].answer.fields[]";
    }
    return "";
}

std::string keys_of(Object object) {
    std::string keys;
    for (const auto& field : fields(object)) keys.append(keys.empty() ? "" : ", ").append(field.key);
    return keys;
}

std::string allowed(const Field& field, const Context& context) {
    if (field.kind == Kind::mapping && field.object) return keys_of(*field.object);
    if (field.kind == Kind::boolean) return "true, false";
    if (field.kind == Kind::text) return {};
    if (field.range != nullptr) {
        const auto [least, greatest, tolerated] = field.range(context);
        if (least == greatest) return bound_text(field, least);
        return bound_text(field, least) + ".." + bound_text(field, greatest);
    }
    std::string words;
    for (std::size_t i = 0; i < field.words.size(); ++i) {
        if (field.fits != nullptr && !field.fits(i, context)) continue;
        if (!words.empty()) words += ", ";
        words += field.words[i];
    }
    return words;
}

}  // namespace takt::model
