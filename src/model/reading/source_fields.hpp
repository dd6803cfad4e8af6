// The keys of sources and sinks.
#pragma once

#include "reading/common_fields.hpp"
#include "reading/field_ranges.hpp"
#include "reading/project_fields.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

inline constexpr auto* kAnswerTime = between<in_ns(1ms), in_ns(60s)>;
inline constexpr auto* kPause = between<0, in_ns(60s)>;

/// A variable of a server has all keys of a variable and those of its binding.
inline constexpr auto kServedVariable =
    joined(kVariable, {
                          {.key = "source", .kind = Kind::mapping, .object = Object::source},
                          {.key = "writes_to", .kind = Kind::mapping, .object = Object::sink},
                          {.key = "answer", .kind = Kind::word, .words = kAnswers},
                      });

inline constexpr Field kSource[] = {
    {.key = "constant", .kind = Kind::constant},
    {.key = "sine", .kind = Kind::mapping, .object = Object::sine},
    {.key = "ramp", .kind = Kind::mapping, .object = Object::ramp},
    {.key = "random_walk", .kind = Kind::mapping, .object = Object::random_walk},
    {.key = "counter", .kind = Kind::mapping, .object = Object::counter},
    {.key = "replay", .kind = Kind::mapping, .object = Object::replay},
    {.key = "file", .kind = Kind::mapping, .object = Object::file_source},
    {.key = "command", .kind = Kind::mapping, .object = Object::command_source, .names_host_resource = true},
    {.key = "variable", .range = kName},
    {.key = "local", .range = kName},
    {.key = "instrument", .range = between<1, 257>},
};

inline constexpr Field kSine[] = {
    {.key = "amplitude", .kind = Kind::number, .required = true},
    {.key = "offset", .kind = Kind::number},
    {.key = "period", .kind = Kind::duration, .required = true, .range = kLongTime},
};

inline constexpr Field kRamp[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "period", .kind = Kind::duration, .required = true, .range = kLongTime},
};

inline constexpr Field kRandomWalk[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "step", .kind = Kind::number},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
    {.key = "seed", .kind = Kind::integer, .range = between<0, 4294967295>},
};

inline constexpr Field kCounter[] = {
    {.key = "from", .kind = Kind::number},
    {.key = "to", .kind = Kind::number, .required = true},
    {.key = "step", .kind = Kind::number},
    {.key = "every", .kind = Kind::duration, .range = kLongTime},
};

inline constexpr Field kReplay[] = {
    {.key = "file", .required = true, .range = kPath, .names_host_resource = true},
    {.key = "column", .required = true, .range = kName},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "loop", .kind = Kind::boolean},
};

inline constexpr Field kFileSource[] = {
    {.key = "path", .required = true, .range = kPath, .names_host_resource = true},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "pattern", .range = kPattern},
};

inline constexpr Field kCommandSource[] = {
    {.key = "run", .kind = Kind::list, .required = true, .names_host_resource = true},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
    {.key = "pattern", .range = kPattern},
};

inline constexpr Field kCommand[] = {
    {.key = "run", .kind = Kind::list, .required = true, .names_host_resource = true},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
};

inline constexpr Field kSink[] = {
    {.key = "variable", .range = kName},
    {.key = "local", .range = kName},
    {.key = "command", .kind = Kind::mapping, .object = Object::command, .names_host_resource = true},
    {.key = "instrument", .range = between<1, 257>},
};

inline constexpr Field kInstrument[] = {
    kNameKey,
    {.key = "transport", .kind = Kind::word, .words = kInstrumentTransports},
    kPortKey,
    kHostKey,
    kTcpPortKey,
    kBaudKey,
    kParityKey,
    kStopBitsKey,
    {.key = "data_bits", .kind = Kind::integer, .range = between<7, 8>},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = kAnswerTime},
    {.key = "exchanges", .kind = Kind::list, .required = true},
    {.key = "start", .kind = Kind::list},
    {.key = "start_retry", .kind = Kind::duration, .range = kShortest},
    {.key = "reset", .kind = Kind::mapping, .object = Object::answer},
    {.key = "silent_after", .kind = Kind::integer, .range = between<0, 255>},
    {.key = "commands", .kind = Kind::list},
};

inline constexpr Field kStartCommand[] = {
    {.key = "request", .required = true, .range = kPattern},
    {.key = "answer", .kind = Kind::mapping, .object = Object::answer},
    {.key = "refused", .kind = Kind::mapping, .object = Object::answer},
    {.key = "timeout", .kind = Kind::duration, .range = kAnswerTime},
    {.key = "pause", .kind = Kind::duration, .range = kPause},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 255>},
};

inline constexpr Field kInstrumentCommand[] = {
    kNameKey,
    {.key = "request", .required = true, .range = kPattern},
    {.key = "decimals", .kind = Kind::integer, .range = between<0, 9>},
    {.key = "digits", .kind = Kind::integer, .range = between<1, 20>},
    {.key = "least", .kind = Kind::number},
    {.key = "greatest", .kind = Kind::number},
    {.key = "unit", .range = between<1, 32>},
    {.key = "answer", .kind = Kind::mapping, .object = Object::answer},
    {.key = "refused", .kind = Kind::mapping, .object = Object::answer},
    {.key = "read_back", .kind = Kind::mapping, .object = Object::read_back},
    {.key = "timeout", .kind = Kind::duration, .range = kAnswerTime},
    {.key = "pause", .kind = Kind::duration, .range = kPause},
    {.key = "attempts", .kind = Kind::integer, .range = between<1, 255>},
    {.key = "expires", .kind = Kind::duration, .range = kAnswerTime},
    {.key = "restore", .kind = Kind::boolean},
};

inline constexpr Field kReadBack[] = {
    {.key = "request", .required = true, .range = kPattern},
    {.key = "answer", .kind = Kind::mapping, .required = true, .object = Object::answer},
};

inline constexpr Field kExchange[] = {
    {.key = "request", .range = kPattern},
    {.key = "answer", .kind = Kind::mapping, .required = true, .object = Object::answer},
};

inline constexpr Field kAnswer[] = {
    {.key = "until", .range = between<1, 64>},
    {.key = "pattern", .range = kPattern},
    {.key = "length", .kind = Kind::integer, .range = between<1, 256>},
    {.key = "begins", .range = kPattern},
    {.key = "checksum", .kind = Kind::word, .words = kChecksums},
    {.key = "fields", .kind = Kind::list},
};

inline constexpr Field kMeasurement[] = {
    kNameKey,
    {.key = "offset", .kind = Kind::integer, .required = true, .range = between<0, 255>},
    {.key = "type", .kind = Kind::word, .required = true, .words = kFieldTypes},
    kHighByteFirstKey,
    kHighRegisterFirstKey,
};

}  // namespace takt::model
