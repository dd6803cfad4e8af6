// The messages of events, for the terminal and for the log: a code of module text with its arguments.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/host/configuration.hpp"
#include "takt/host/event.hpp"

namespace takt::host {

/// A text by its code. An argument that is a code has the arguments before it as its own arguments.
struct EventMessage {
    struct Argument {
        std::string name;
        std::string text;
        std::string otherwise = {};  ///< the code to use if `text` is an unknown code
        bool is_code = false;        ///< `text` is the code of a text
    };
    std::string code;  ///< empty: the event needs no line
    std::vector<Argument> arguments;
};

/// Each message has the placeholder `where`: the caller appends this argument. The message has `line`,
/// `device` and `unit` already.
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const PeriodOverrun& overrun);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const WriteWaiting& waiting);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const VerifyFailed& failed);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const GapLearnt& learnt);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const DelaysFound& found);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const NoiseFound& found);
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const SurplusFound& found);
/// Needs no `where`. @returns an empty message if the change is only counted
[[nodiscard]] EventMessage event_message(const Configuration& configuration,
                                         const DeviceStateChanged& changed);
/// @returns an empty message if VerifyFailed reports the write
[[nodiscard]] EventMessage event_message(const Configuration& configuration, const Outcome& outcome);

/// "read holding registers 500..501" as a code with its arguments `function`, `items` and `request`.
/// @param function  0: none
void append_request_words(std::vector<EventMessage::Argument>& arguments, std::uint8_t function,
                          std::uint16_t start, std::uint16_t quantity, bool has_items);

/// "exception 2: illegal data address" as a code with its arguments `code`, `name` and `argument`.
void append_exception_words(std::vector<EventMessage::Argument>& arguments, unsigned exception,
                            std::string_view argument);

/// The exception that came most often; 0: another one than 1..11.
[[nodiscard]] std::uint8_t most_frequent_exception(const bus::TransactionCounters& counters);

/// Appends views of `words`, which must outlive them.
void append(std::vector<LogArgument>& arguments, const std::vector<EventMessage::Argument>& words);

/// Milliseconds without a unit, with one decimal below 10.
[[nodiscard]] std::string milliseconds_number(Duration time);

}  // namespace takt::host
