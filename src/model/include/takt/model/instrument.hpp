// Instruments: devices with commands of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/model/document.hpp"
#include "takt/model/text_template.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::model {

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

/// What a request must be followed by.
struct Confirmation {
    std::optional<AnswerFormat> answer;                 ///< confirms it; nothing: no answer is expected
    std::optional<AnswerFormat> refused;                ///< the instrument refuses it
    Duration timeout = std::chrono::milliseconds(500);  ///< from the request to the end of its answer
    Duration pause{};                                   ///< from its end to the next request
    std::uint8_t attempts = 1;
    friend bool operator==(const Confirmation&, const Confirmation&) = default;
};

/// A request that is sent after the start of an instrument.
struct StartCommand {
    SourceLocation location;
    std::string request;  ///< bytes
    Confirmation confirmation;
    friend bool operator==(const StartCommand&, const StartCommand&) = default;
};

/// The text of a number in a request.
struct NumberFormat {
    std::optional<std::uint8_t> decimals;  ///< digits behind the point; nothing: as many as needed
    std::uint8_t digits = 1;               ///< before the point, filled with zeros
    std::optional<double> least;           ///< other values are refused
    std::optional<double> greatest;
    friend bool operator==(const NumberFormat&, const NumberFormat&) = default;
};

/// A command that carries a value to an instrument.
struct InstrumentCommand {
    std::string name;
    SourceLocation location;
    TextTemplate request;  ///< with one placeholder, `value`
    NumberFormat format;
    std::string unit;  ///< of the value, for people
    Confirmation confirmation;
    std::optional<Exchange> read_back;           ///< its answer has the measurement `value`
    Duration expires = std::chrono::seconds(1);  ///< from the write to its result
    bool restore = true;                         ///< the confirmed value is sent again after each start

    /// The kind of the placeholder.
    [[nodiscard]] TextTemplate::Kind kind() const;
    friend bool operator==(const InstrumentCommand&, const InstrumentCommand&) = default;
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
    std::vector<StartCommand> start;                 ///< sent in this order after each start
    Duration start_retry = std::chrono::seconds(5);  ///< from a failed start to the next one
    std::optional<AnswerFormat> reset;  ///< what the instrument sends by itself after its restart
    std::uint8_t silent_after = 3;      ///< unanswered requests in a row; 0: never
    std::vector<InstrumentCommand> commands;

    /// Whether it answers requests; otherwise it sends by itself.
    [[nodiscard]] bool is_asked() const { return !exchanges.empty() && !exchanges[0].request.empty(); }
    [[nodiscard]] bool has(std::string_view measurement) const;
    friend bool operator==(const Instrument&, const Instrument&) = default;
};

}  // namespace takt::model
