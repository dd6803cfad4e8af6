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
#include "takt/model/text_template.hpp"
#include "takt/wire/line_timing.hpp"

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
    std::string measurement;
    friend bool operator==(const InstrumentSource&, const InstrumentSource&) = default;
};

using Source = std::variant<Constant, Generator, Replay, FileSource, CommandSource, VariableSource,
                            LocalSource, InstrumentSource>;
/// The sink of written values. In a command the value replaces each argument `{value}`.
using Sink = std::variant<VariableSource, LocalSource, Command>;

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

enum class Checksum : std::uint8_t { none, sum, exclusive_or, crc16 };

/// A number in a binary answer.
struct BinaryField {
    std::string name;
    std::uint16_t offset = 0;
    std::uint16_t bytes = 2;
    bool is_signed = false;
    std::optional<DataType> type;  ///< nothing: an integer of one byte
    ByteOrder order;
    friend bool operator==(const BinaryField&, const BinaryField&) = default;
};

/// The format of an answer.
struct AnswerFormat {
    // Of text:
    std::string until;  ///< the bytes that end it; empty: it is binary
    TextTemplate pattern;
    // Binary:
    std::uint16_t length = 0;            ///< of the whole
    std::string begins;                  ///< its first bytes
    Checksum checksum = Checksum::none;  ///< the last byte; of crc16 the last two, low byte first
    std::vector<BinaryField> fields;

    [[nodiscard]] bool has(std::string_view measurement) const;
    [[nodiscard]] std::vector<std::string_view> names() const;
    friend bool operator==(const AnswerFormat&, const AnswerFormat&) = default;
};

/// A request and its answer, or an answer that the instrument sends by itself.
struct Exchange {
    SourceLocation location;
    std::string request;  ///< bytes; empty: the instrument sends by itself
    AnswerFormat answer;
    friend bool operator==(const Exchange&, const Exchange&) = default;
};

/// An instrument: a device with commands of its own, on its own serial port or TCP connection.
struct Instrument {
    std::string name;
    SourceLocation location;
    bool serial = true;
    std::string port;  ///< the device file, or the host
    std::uint16_t tcp_port = 0;
    wire::CharacterFormat format;
    Duration every = std::chrono::seconds(1);           ///< from the start of one round to the next
    Duration timeout = std::chrono::milliseconds(500);  ///< from a request to the end of its answer
    std::vector<Exchange> exchanges;

    /// Whether it answers requests; otherwise it sends by itself.
    [[nodiscard]] bool is_asked() const { return !exchanges.empty() && !exchanges[0].request.empty(); }
    [[nodiscard]] bool has(std::string_view measurement) const;
    friend bool operator==(const Instrument&, const Instrument&) = default;
};

}  // namespace takt::model
