#include "takt/model/fields.hpp"

#include <algorithm>

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
    {.key = "lines", .kind = Kind::list, .required = true},
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
    {.key = "devices", .kind = Kind::list, .required = true},
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
