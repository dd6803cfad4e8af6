// The keys of outputs.
#pragma once

#include "reading/common_fields.hpp"
#include "reading/field_ranges.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

inline constexpr auto* kOutputName = between<1, 32>;
inline constexpr auto* kTopic = between<1, 512>;
inline constexpr auto* kHeartbeat = between<in_ns(1s), in_ns(24h)>;

/// Which values, and when there is a sample of them.
inline constexpr Field kSelectionKeys[] = {
    {.key = "variables", .kind = Kind::list},
    {.key = "devices", .kind = Kind::list},
    {.key = "tags", .kind = Kind::list},
    {.key = "on_change", .kind = Kind::boolean},
    {.key = "period", .kind = Kind::duration, .range = kLongTime},
    {.key = "dead_band", .kind = Kind::number},
    {.key = "heartbeat", .kind = Kind::duration, .range = kHeartbeat},
    {.key = "bad_quality", .kind = Kind::word, .words = kBadQuality},
    {.key = "topic", .range = kTopic},
    {.key = "message", .kind = Kind::word, .words = kMessageScopes},
    {.key = "retain", .kind = Kind::boolean},
};

inline constexpr auto kOutputSelection = joined(kSelectionKeys);

inline constexpr auto kOutput = joined(
    {
        {.key = "name", .required = true, .range = kOutputName},
        {.key = "transport", .kind = Kind::word, .required = true, .words = kOutputTransports},
        {.key = "brokers", .kind = Kind::list, .directs_secret = true},
        {.key = "version", .kind = Kind::word, .words = kMqttVersions},
        {.key = "client_id", .range = between<1, 256>},
        {.key = "user", .range = between<1, 1000>},
        {.key = "password_file", .range = kPath, .names_host_resource = true, .secret = true},
        {.key = "password_env", .range = between<1, 128>, .names_host_resource = true, .secret = true},
        {.key = "ca_file", .range = kPath, .names_host_resource = true, .directs_secret = true},
        {.key = "certificate_file", .range = kPath, .names_host_resource = true},
        {.key = "key_file", .range = kPath, .names_host_resource = true, .secret = true},
        {.key = "alpn", .range = between<1, 255>, .directs_secret = true},
        {.key = "keep_alive", .kind = Kind::duration, .range = between<in_ns(5s), in_ns(18h)>},
        kBackoffKey,
        {.key = "in_flight", .kind = Kind::integer, .range = between<1, 256>},
        {.key = "round_trip", .kind = Kind::duration, .range = between<in_ns(1us), in_ns(60s)>},
        {.key = "backlog", .kind = Kind::word, .words = kBacklogs},
    },
    kSelectionKeys,
    {
        {.key = "select", .kind = Kind::list},
        {.key = "control_topic", .range = kTopic},
        {.key = "commands", .kind = Kind::list},
        {.key = "command_expiry", .kind = Kind::duration, .range = between<in_ns(1s), in_ns(1h)>},
        {.key = "quota_mb", .kind = Kind::integer, .range = between<32, 4'194'304>},
        {.key = "retention", .kind = Kind::duration, .range = between<0, in_ns(3650 * 24h)>},
        {.key = "buffer_mb", .kind = Kind::integer, .range = between<1, 256>},
        {.key = "directory", .range = kPath, .names_host_resource = true},
    });

}  // namespace takt::model
