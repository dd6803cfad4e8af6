// The keys of servers: endpoint, clients and units.
#pragma once

#include "reading/common_fields.hpp"
#include "reading/field_ranges.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

inline constexpr auto kServer = joined(
    {
        kNameKey,
        {.key = "transport", .kind = Kind::word, .words = kServerTransports},
        kPortKey,
        {.key = "listen", .range = between<1, 255>},
        kTcpPortKey,
        kTlsKey,
    },
    kFrameKeys,
    {
        {.key = "strict", .kind = Kind::boolean},
        {.key = "turnaround", .kind = Kind::duration, .range = kShortTime},
        {.key = "max_connections", .kind = Kind::integer, .range = between<1, 20000>},
        {.key = "max_per_peer", .kind = Kind::integer, .range = between<1, 20000>},
        {.key = "byte_timeout", .kind = Kind::duration, .range = kTimeout},
        {.key = "frame_timeout", .kind = Kind::duration, .range = kLongTime},
        {.key = "idle_timeout", .kind = Kind::duration, .range = kLongTime},
        {.key = "write_timeout", .kind = Kind::duration, .range = kLongTime},
        {.key = "access", .kind = Kind::list},
        {.key = "audit", .range = between<1, 255>, .names_host_resource = true},
        {.key = "units", .kind = Kind::list},
        {.key = "relay", .kind = Kind::list},
    });

inline constexpr Field kAccess[] = {
    {.key = "peers", .kind = Kind::list},
    {.key = "roles", .kind = Kind::list},
    {.key = "units", .kind = Kind::ranges, .range = kUnitId},
    {.key = "functions", .kind = Kind::list},
    {.key = "area", .kind = Kind::word, .words = kAreas},
    {.key = "items", .kind = Kind::ranges, .range = kItem},
    {.key = "rule", .kind = Kind::word, .required = true, .words = kAccessVerdicts},
    {.key = "rate", .kind = Kind::integer, .range = between<1, 1'000'000>},
    {.key = "burst", .kind = Kind::integer, .range = between<1, 1'000'000>},
};

inline constexpr Field kUnit[] = {
    {.key = "address", .kind = Kind::integer, .required = true, .range = address},
    {.key = "banks", .kind = Kind::list},
    {.key = "mirror", .kind = Kind::mapping, .object = Object::mirror},
    {.key = "limits", .kind = Kind::list},
    {.key = "identification", .kind = Kind::list},
    {.key = "server_id", .range = between<0, 248>},
    {.key = "files", .kind = Kind::list},
    {.key = "fifos", .kind = Kind::list},
    {.key = "exception_coils", .kind = Kind::integer, .range = between<0, 65528>},
    {.key = "durability", .kind = Kind::word, .words = kDurabilities},
    {.key = "state", .range = between<1, 255>, .names_host_resource = true},
    {.key = "restart", .kind = Kind::boolean},
    {.key = "listen_only", .kind = Kind::boolean},
    kHighByteFirstKey,
    kHighRegisterFirstKey,
    kByteOrderKey,
    kNotationKey,
    {.key = "variables", .kind = Kind::list},
};

inline constexpr Field kBank[] = {
    {.key = "area", .kind = Kind::word, .required = true, .words = kAreas},
    {.key = "items", .kind = Kind::ranges, .required = true, .range = kItem},
    {.key = "read_only", .kind = Kind::ranges, .range = kItem},
    {.key = "retain", .kind = Kind::ranges, .range = kItem},
    {.key = "overlay", .kind = Kind::word, .words = kRegisterAreas},
    {.key = "overlay_register", .kind = Kind::integer, .range = kItem},
};

inline constexpr Field kMirror[] = {
    {.key = "area", .kind = Kind::word, .words = kAreas},
    {.key = "first", .kind = Kind::integer, .range = kItem},
    {.key = "order", .kind = Kind::word, .words = kMirrorOrders},
    {.key = "devices", .kind = Kind::list},
    {.key = "writable", .kind = Kind::boolean},
};

inline constexpr Field kLimit[] = {
    {.key = "registers", .kind = Kind::ranges, .required = true, .range = kItem},
    {.key = "least", .kind = Kind::integer, .required = true, .range = between<-32768, 65535>},
    {.key = "greatest", .kind = Kind::integer, .required = true, .range = between<-32768, 65535>},
};

inline constexpr Field kIdentification[] = {
    {.key = "id", .kind = Kind::integer, .required = true, .range = between<0, 255>},
    {.key = "text", .required = true, .range = between<0, 61>},
};

inline constexpr Field kFile[] = {
    {.key = "number", .kind = Kind::integer, .required = true, .range = between<1, 65535>},
    {.key = "records", .kind = Kind::integer, .required = true, .range = between<1, 10000>},
    {.key = "read_only", .kind = Kind::boolean},
};

inline constexpr Field kFifo[] = {
    {.key = "register", .kind = Kind::integer, .required = true, .range = kItem},
    {.key = "values", .kind = Kind::list, .required = true},
};

inline constexpr Field kRelay[] = {
    {.key = "line", .required = true, .range = kName},
    {.key = "units", .kind = Kind::ranges, .range = kUnitId},
    {.key = "map", .kind = Kind::list},
    {.key = "cache", .kind = Kind::duration, .range = between<0, in_ns(1min)>},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 10>},
    {.key = "response_timeout", .kind = Kind::duration, .range = kTimeout},
    {.key = "max_wait", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(10min)>},
};

inline constexpr Field kRelayMap[] = {
    {.key = "from", .kind = Kind::integer, .required = true, .range = kUnitId},
    {.key = "to", .kind = Kind::integer, .required = true, .range = kUnitId},
};

}  // namespace takt::model
