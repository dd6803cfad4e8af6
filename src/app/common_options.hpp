// Options that several commands share, read with CLI11. What cannot be read is thrown as CLI::ValidationError
// with the option's name, the text and what is allowed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <string>

#include "takt/app/commands.hpp"

namespace takt::app {

/// A duration with its unit (us, ms, s, min, h), at most a year, as in a project file.
CLI::Option* add_duration(CLI::App& command, const std::string& name, std::function<void(Duration)> set,
                          const std::string& help);

/// The words for the four areas.
inline const std::map<std::string, wire::Area> kAreas{{"coils", wire::Area::coil},
                                                      {"discrete", wire::Area::discrete_input},
                                                      {"input", wire::Area::input_register},
                                                      {"holding", wire::Area::holding_register}};

/// An option that takes one of a few words.
template <class T>
CLI::Option* add_word(CLI::App& command, const std::string& name, T& target,
                      const std::map<std::string, T>& words, const std::string& help) {
    return command.add_option_function<std::string>(
        name,
        [&target, &words, name](const std::string& text) {
            const auto found = words.find(text);
            if (found == words.end()) {
                std::string known;
                for (const auto& word : words) known += (known.empty() ? "" : ", ") + word.first;
                throw CLI::ValidationError(name, "'" + text + "' is not known, allowed: " + known);
            }
            target = found->second;
        },
        help);
}

/// --type; `given` becomes true where the option stands.
void add_type(CLI::App& command, DataType& type, bool& given);

/// --order: how the bytes of a value are sent.
void add_order(CLI::App& command, ByteOrder& order);

/// TARGET and the options of every command that talks to one device.
void add_client(CLI::App& command, ClientOptions& options);

/// --timeout, at least 1ms.
template <class Target>
void add_timeout(CLI::App& command, Target& target, const std::string& help) {
    add_duration(
        command, "--timeout",
        [&target](Duration timeout) {
            if (timeout < std::chrono::milliseconds(1))
                throw CLI::ValidationError("--timeout", "the least is 1ms");
            target = timeout;
        },
        help);
}

}  // namespace takt::app
