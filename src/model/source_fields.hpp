// The keys of sources and sinks.
#pragma once

#include "common_fields.hpp"
#include "field_ranges.hpp"
#include "project_fields.hpp"
#include "takt/model/fields.hpp"

namespace takt::model {

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
    {.key = "command", .kind = Kind::mapping, .object = Object::command_source},
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
    {.key = "file", .required = true, .range = kPath},
    {.key = "column", .required = true, .range = kName},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "loop", .kind = Kind::boolean},
};

inline constexpr Field kFileSource[] = {
    {.key = "path", .required = true, .range = kPath},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "pattern", .range = kPattern},
};

inline constexpr Field kCommandSource[] = {
    {.key = "run", .kind = Kind::list, .required = true},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
    {.key = "pattern", .range = kPattern},
};

inline constexpr Field kCommand[] = {
    {.key = "run", .kind = Kind::list, .required = true},
    {.key = "timeout", .kind = Kind::duration, .range = kCommandTime},
};

inline constexpr Field kSink[] = {
    {.key = "variable", .range = kName},
    {.key = "local", .range = kName},
    {.key = "command", .kind = Kind::mapping, .object = Object::command},
};

inline constexpr Field kInstrument[] = {
    kNameKey,
    {.key = "transport", .kind = Kind::word, .words = kServerTransports},
    kPortKey,
    kHostKey,
    kTcpPortKey,
    kBaudKey,
    kParityKey,
    kStopBitsKey,
    {.key = "data_bits", .kind = Kind::integer, .range = between<7, 8>},
    {.key = "every", .kind = Kind::duration, .range = kShortest},
    {.key = "timeout", .kind = Kind::duration, .range = between<in_ns(1ms), in_ns(60s)>},
    {.key = "exchanges", .kind = Kind::list, .required = true},
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
