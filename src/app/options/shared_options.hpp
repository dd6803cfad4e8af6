// Options that several commands share. A value that is not accepted ends the parsing (reject()) with the
// option's name, the text and what is allowed.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <string>

#include "commands/client_options.hpp"
#include "options/command_line.hpp"
#include "takt/base/data_type.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"

namespace takt::app {

/// A duration with its unit (us, ms, s, min, h), at most a year, as in a project file.
Option add_duration(Command& command, const std::string& name, std::function<void(Duration)> set,
                    const std::string& help);

/// The words for the four areas.
inline const std::map<std::string, wire::Area> kAreas{{"coils", wire::Area::coil},
                                                      {"discrete", wire::Area::discrete_input},
                                                      {"input", wire::Area::input_register},
                                                      {"holding", wire::Area::holding_register}};

/// An option that takes one of a few words.
template <class T>
Option add_word(Command& command, const std::string& name, T& target, const std::map<std::string, T>& words,
                const std::string& help) {
    return command.text(
        name,
        [&target, &words, name](const std::string& text) {
            const auto found = words.find(text);
            if (found == words.end()) {
                std::string known;
                for (const auto& word : words) known += (known.empty() ? "" : ", ") + word.first;
                reject(name, "'" + text + "' is not known, allowed: " + known);
            }
            target = found->second;
        },
        help);
}

/// --type; `given` becomes true where the option stands.
void add_type(Command& command, DataType& type, bool& given);

/// --order: how the bytes of a value are sent.
void add_order(Command& command, ByteOrder& order);

/// TARGET and the options of every command that talks to one device.
void add_client(Command& command, ClientOptions& options);

/// --timeout, at least 1ms.
template <class Target>
void add_timeout(Command& command, Target& target, const std::string& help) {
    add_duration(
        command, "--timeout",
        [&target](Duration timeout) {
            if (timeout < std::chrono::milliseconds(1)) reject("--timeout", "the least is 1ms");
            target = timeout;
        },
        help);
}

}  // namespace takt::app
