// Sources and sinks of a server's variables.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/model/document.hpp"
#include "takt/model/instrument.hpp"
#include "takt/model/text_template.hpp"

namespace takt::model {

/// A constant of a project, for example a default value. Text for strings, else a number; a bool is 0 or 1.
struct Constant {
    std::string text;
    double number = 0;  ///< the value of every type but string; exact for float, double and scaled ones
    std::int64_t integer = 0;  ///< of the unscaled integers and bools; uint64 as its bit pattern
    friend bool operator==(const Constant&, const Constant&) = default;
};

/// A generator: its value changes with time from the start of the server.
struct Generator {
    enum class Motion : std::uint8_t {
        sine,         ///< between `from` and `to`, once each period; begins in the middle, upwards
        ramp,         ///< from `from` to `to` in a period, then anew
        random_walk,  ///< each period a step up or down of at most `step`, between `from` and `to`
        counter,      ///< from `from`, each period `step` more; behind `to` it begins anew
    };
    Motion motion = Motion::sine;
    double from = 0;
    double to = 1;
    double step = 1;
    Duration period = std::chrono::seconds(1);
    std::uint64_t seed = 1;
    friend bool operator==(const Generator&, const Generator&) = default;
};

/// A column of a CSV file, one row per `every`.
struct Replay {
    std::string path;    ///< as written, relative to the project file
    std::string column;  ///< its heading, or its number from 1
    Duration every = std::chrono::seconds(1);
    bool loop = true;  ///< after the last row the first one; else the last one stays
    friend bool operator==(const Replay&, const Replay&) = default;
};

/// The content of a file, read once per `every`. The template's measurement is `value`.
struct FileSource {
    std::string path;
    Duration every = std::chrono::seconds(1);
    TextTemplate pattern;
    friend bool operator==(const FileSource&, const FileSource&) = default;
};

/// A program that is run without a shell.
struct Command {
    std::vector<std::string> run;  ///< the program and its arguments; not empty
    Duration timeout = std::chrono::seconds(1);
    friend bool operator==(const Command&, const Command&) = default;
};

/// The output of a command, run once per `every`.
struct CommandSource {
    Command command;
    Duration every = std::chrono::seconds(5);
    TextTemplate pattern;
    friend bool operator==(const CommandSource&, const CommandSource&) = default;
};

/// A variable of a line, or a local, of the same project.
struct VariableSource {
    std::string name;
    friend bool operator==(const VariableSource&, const VariableSource&) = default;
};
struct LocalSource {
    std::string name;
    friend bool operator==(const LocalSource&, const LocalSource&) = default;
};

struct InstrumentSource {
    std::size_t instrument = 0;  ///< index into Project::instruments
    std::string measurement;     ///< empty: the state of the instrument
    friend bool operator==(const InstrumentSource&, const InstrumentSource&) = default;
};

/// A command of an instrument that carries the value.
struct InstrumentSink {
    std::size_t instrument = 0;  ///< index into Project::instruments
    std::size_t command = 0;     ///< index into Instrument::commands
    friend bool operator==(const InstrumentSink&, const InstrumentSink&) = default;
};

using Source = std::variant<Constant, Generator, Replay, FileSource, CommandSource, VariableSource,
                            LocalSource, InstrumentSource>;
/// The sink of written values. In a command the value replaces each argument `{value}`.
using Sink = std::variant<VariableSource, LocalSource, Command, InstrumentSink>;

/// The binding of a variable of a unit to its source and sink.
struct Binding {
    std::size_t variable = 0;  ///< index into ServerUnit::variables
    SourceLocation location;
    std::optional<Source> source;
    std::optional<Sink> sink;
    std::optional<Duration> max_age;  ///< an older value is exception 0x0B
    bool answer_at_once = false;      ///< a write is answered before it is done
    friend bool operator==(const Binding&, const Binding&) = default;
};

}  // namespace takt::model
