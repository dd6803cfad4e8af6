// The keys of a project: its lines, their devices and variables, and locals.
#pragma once

#include "reading/common_fields.hpp"
#include "reading/field_ranges.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

inline constexpr Field kProject[] = {
    {.key = "takt", .kind = Kind::integer, .required = true, .range = between<1, 1>},
    {.key = "profile", .kind = Kind::word, .words = kProfiles},
    {.key = "derive_timeouts", .kind = Kind::boolean},
    {.key = "timeout_margin", .kind = Kind::duration, .range = kShortTime},
    {.key = "host", .kind = Kind::mapping, .object = Object::host},
    {.key = "faults", .kind = Kind::mapping, .object = Object::faults},
    kBackoffKey,
    {.key = "lines", .kind = Kind::list},
    {.key = "servers", .kind = Kind::list},
    {.key = "instruments", .kind = Kind::list},
    {.key = "locals", .kind = Kind::list},
    {.key = "outputs", .kind = Kind::list},
};

inline constexpr auto kLine = joined(
    {
        kNameKey,
        {.key = "transport", .kind = Kind::word, .words = kTransports, .fits = transport_fits},
        kPortKey,
        kHostKey,
        kTcpPortKey,
        kTlsKey,
    },
    kFrameKeys,
    {
        {.key = "order", .kind = Kind::word, .words = kOrders},
        {.key = "request_gap", .kind = Kind::duration, .range = request_gap},
        {.key = "frame_gap", .kind = Kind::duration, .range = kShortTime},
        {.key = "byte_timeout", .kind = Kind::duration, .range = kTimeout},
        {.key = "connection", .kind = Kind::word, .words = kConnections},
        {.key = "idle_close", .kind = Kind::duration, .range = kIdleClose},
        {.key = "pause_after_connect", .kind = Kind::duration, .range = kPauseAfterConnect},
        {.key = "connections_per_host", .kind = Kind::integer, .range = between<1, 16>},
        {.key = "length_tolerance", .kind = Kind::boolean},
        {.key = "relay_interval", .kind = Kind::duration, .range = kLongTime},
        {.key = "command_interval", .kind = Kind::duration, .range = kLongTime},
        {.key = "command_burst", .kind = Kind::integer, .range = kBurst},
        {.key = "devices", .kind = Kind::list},
    });

inline constexpr Field kDevice[] = {
    {.key = "name", .required = true, .range = device_name},
    {.key = "address", .kind = Kind::integer, .required = true, .range = address},
    {.key = "poll_period", .kind = Kind::duration, .range = period},
    {.key = "response_timeout", .kind = Kind::duration, .range = kTimeout, .zero_means = default_timeout},
    {.key = "turnaround", .kind = Kind::duration, .range = kShortTime, .words = kTurnarounds},
    {.key = "round_trip", .kind = Kind::duration, .range = kShortTime, .object = Object::round_trip},
    {.key = "deadline", .kind = Kind::duration, .range = kDeadline},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 255>, .zero_means = one_attempt},
    kBackoffKey,
    {.key = "in_flight", .kind = Kind::integer, .range = between<1, 16>},
    {.key = "group_requests", .kind = Kind::boolean},
    {.key = "registers_per_request", .kind = Kind::integer, .range = registers_per_request},
    {.key = "strategy", .kind = Kind::word, .words = kStrategies},
    {.key = "gaps", .kind = Kind::word, .words = kGaps},
    {.key = "readable", .kind = Kind::ranges, .range = kItem, .object = Object::areas},
    {.key = "no_read", .kind = Kind::ranges, .range = kItem, .object = Object::areas},
    {.key = "offers", .kind = Kind::ranges, .range = kItem, .object = Object::areas},
    {.key = "write_single", .kind = Kind::word, .words = kWriteSingle},
    {.key = "fc22", .kind = Kind::boolean},
    {.key = "fc23", .kind = Kind::boolean},
    {.key = "read_modify_write", .kind = Kind::boolean},
    kHighByteFirstKey,
    kHighRegisterFirstKey,
    kByteOrderKey,
    {.key = "poll_enable", .kind = Kind::local_bool},
    {.key = "status", .kind = Kind::local_integer},
    kCommentKey,
    kNotationKey,
    {.key = "device_template", .range = between<1, 4096>},
    {.key = "parameters", .kind = Kind::mapping},
    {.key = "variables", .kind = Kind::list},
};

inline constexpr Field kVariable[] = {
    kNameKey,
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
    {.key = "max_age", .kind = Kind::duration, .range = kLongTime},
    {.key = "default", .kind = Kind::constant},
    {.key = "hold_last", .kind = Kind::boolean},
    {.key = "retain", .kind = Kind::boolean},
    {.key = "used", .kind = Kind::boolean},
    kHighByteFirstKey,
    kHighRegisterFirstKey,
    kByteOrderKey,
    {.key = "scale", .kind = Kind::number},
    {.key = "offset", .kind = Kind::number},
    {.key = "dead_band", .kind = Kind::number},
    {.key = "write_range", .range = between<1, 64>},
    {.key = "verify", .kind = Kind::boolean},
    {.key = "safe_to_repeat", .kind = Kind::boolean},
    {.key = "unit", .range = between<0, 32>},
    {.key = "enumeration", .kind = Kind::words},
    {.key = "bits", .kind = Kind::words},
    {.key = "tags", .kind = Kind::list},
    kCommentKey,
};

inline constexpr Field kLocal[] = {
    kNameKey,
    {.key = "type", .kind = Kind::word, .required = true, .words = kTypes},
    {.key = "default", .kind = Kind::constant},
    {.key = "retain", .kind = Kind::boolean},
    {.key = "used", .kind = Kind::boolean},
    {.key = "min_interval", .kind = Kind::duration, .range = kLongTime},
    {.key = "burst", .kind = Kind::integer, .range = kBurst},
    kCommentKey,
};

inline constexpr Field kHost[] = {
    {.key = "jitter", .kind = Kind::duration, .range = kShortTime},
    {.key = "overhead", .kind = Kind::duration, .range = kShortTime},
};

inline constexpr Field kFaults[] = {
    {.key = "burst", .kind = Kind::integer, .range = between<0, 255>},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
};

inline constexpr Field kRoundTrip[] = {
    {.key = "longest", .kind = Kind::duration, .required = true, .range = kShortTime},
    {.key = "usual", .kind = Kind::duration, .range = kShortTime},
    {.key = "exchanges", .kind = Kind::integer, .required = true, .range = between<100, 1'000'000'000'000>},
    {.key = "in_flight", .kind = Kind::integer, .range = between<1, 16>},
};

inline constexpr Field kTls[] = {
    {.key = "ca", .range = kPath, .names_host_resource = true},
    {.key = "certificate", .range = kPath, .names_host_resource = true},
    {.key = "key", .range = kPath, .names_host_resource = true},
    {.key = "crl", .range = kPath, .names_host_resource = true},
    {.key = "server_name", .range = between<1, 253>},
};

inline constexpr Field kBackoff[] = {
    {.key = "first", .kind = Kind::duration, .range = kLongTime},
    {.key = "limit", .kind = Kind::duration, .range = kLongTime},
};

inline constexpr Field kByArea[] = {
    {.key = kAreas[0], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[1], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[2], .kind = Kind::ranges, .range = kItem},
    {.key = kAreas[3], .kind = Kind::ranges, .range = kItem},
};

}  // namespace takt::model
