// Options that several commands share. A value that is not accepted ends the parsing (reject()) with the
// option's name, the text and what is allowed.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "online/realtime_mode.hpp"
#include "options/command_line.hpp"
#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/console/capture_file.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

/// Ends the parsing: the value is none of the `allowed` ones.
[[noreturn]] void reject_word(const std::string& option, const std::string& value,
                              const std::string& allowed);

/// Rejects a URL that is no target (line::parse_target()).
void check_target(const std::string& option, const std::string& url);

/// A duration as in a project file (model::parse_duration), at most a year.
Option add_duration(Command& command, const std::string& name, std::function<void(Duration)> set,
                    const std::string& help);

/// The same, at least 1 ms.
Option add_wait(Command& command, const std::string& name, std::function<void(Duration)> set,
                const std::string& help);

/// --capture, --capture-size and --capture-files.
void add_capture(Command& command, console::CaptureFileOptions& options);
/// The size and the number of files. @param needed  the option or argument that names the file
void add_capture_files(Command& command, console::CaptureFileOptions& options, const std::string& prefix,
                       const Option& needed);

/// --realtime, --cpu and --spin.
void add_realtime(Command& command, RealtimeMode& mode);

/// The words for the four areas.
inline const std::map<std::string, wire::Area> kAreas{{"coils", wire::Area::coil},
                                                      {"discrete", wire::Area::discrete_input},
                                                      {"input", wire::Area::input_register},
                                                      {"holding", wire::Area::holding_register}};

/// An option that takes one of a few words.
template <class Target, class T>
Option add_word(Command& command, const std::string& name, Target& target,
                const std::map<std::string, T>& words, const std::string& help) {
    return command.text(
        name,
        [&target, &words, name](const std::string& text) {
            const auto found = words.find(text);
            if (found == words.end()) {
                std::string known;
                for (const auto& word : words) known += (known.empty() ? "" : ", ") + word.first;
                reject_word(name, text, known);
            }
            target = found->second;
        },
        help);
}

/// An option that may be given several times, each value read by `parse`.
/// @param form  the word for the value in the help
/// @param rule  the message for a value that is not accepted: the form and the limits
template <class T>
Option add_parsed(Command& command, const std::string& name, std::vector<T>& target,
                  std::optional<T> (*parse)(std::string_view), const std::string& form,
                  const std::string& rule, const std::string& help) {
    return command
        .texts(
            name,
            [=, &target](const std::vector<std::string>& texts) {
                for (const auto& text : texts) {
                    auto parsed = parse(text);
                    if (!parsed) reject({rule, {{"option", name}, {"value", text}}});
                    target.push_back(*std::move(parsed));
                }
            },
            help)
        .one_value_each()
        .value_name(form);
}

/// The words for the types of values in registers.
const std::map<std::string, DataType>& type_words();

/// A word of --type that is no type of registers, and what it sets.
struct TypeFlag {
    std::string_view word;
    bool* flag = nullptr;
};

/// --type, with these words besides the types of registers; `given` becomes true where the option stands.
void add_type(Command& command, DataType& type, std::vector<TypeFlag> flags, bool& given,
              const std::string& help);

/// The order of bytes that `text` names; otherwise the option is rejected.
ByteOrder order_of(const std::string& option, const std::string& text);

/// --order: how the bytes of a value are sent.
void add_order(Command& command, ByteOrder& order);

/// TARGET and the options of every command that addresses one device.
void add_client(Command& command, ClientOptions& options);

/// --timeout
template <class Target>
void add_timeout(Command& command, Target& target, const std::string& help) {
    add_wait(command, "--timeout", [&target](Duration timeout) { target = timeout; }, help);
}

}  // namespace takt::app
