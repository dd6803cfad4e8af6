// The command line as a tree of commands with options. command_line.cpp alone includes CLI11, which takes
// longer to compile than the commands.
//
// A help text is the code of a message (`help.…`); CommandLine::parse() puts the message in its place.
// Option and Command are handles: they may be copied, and are valid as long as their CommandLine.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "exit_code.hpp"
#include "options/option_error.hpp"
#include "takt/base/time.hpp"
#include "texts.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace takt::app {

/// An option, or an argument without a name.
class Option {
public:
    Option& required();
    /// The word for the value in the help. Without it the help shows the range of a number.
    Option& value_name(const std::string& name);
    Option& needs(Option other);
    Option& excludes(Option other);
    /// Numbers from `least` to `greatest` only.
    Option& range(int least, int greatest);
    /// These words only.
    Option& one_of(std::vector<std::string> words);
    /// Calls `check` with each value; it may call reject().
    Option& check(std::function<void(const std::string&)> check);
    /// From `least` to `most` values.
    Option& count(int least, int most);
    /// One value each time it is given; all are taken.
    Option& repeatable();
    /// As many values as it is given; the word after a value is not taken for another one.
    Option& one_value_each();
    /// The default that the help shows.
    Option& default_text(const std::string& text);
    /// The help shows the value that the variable has now.
    Option& show_default();
    /// Sets `given` to true where the option is given.
    Option& marks(bool& given);
    /// The heading of the option in the help: the code of a message.
    Option& group(const std::string& code);

private:
    friend class Command;
    explicit Option(CLI::Option* option) : option_(option) {}
    /// The range of a number whose option has none yet.
    Option& add_range(std::int64_t least, std::int64_t greatest);
    CLI::Option* option_;
};

class Command {
public:
    /// Reads a value into `target`, which must outlive the parsing. Targets: std::string, std::uint8_t,
    /// std::uint16_t, std::uint32_t, an std::optional of the last two, std::size_t, std::vector<std::string>.
    /// A number has the range of its type.
    /// @param name  "--name", "-n,--name", or "NAME" for an argument
    template <class T>
    Option value(const std::string& name, T& target, const std::string& help);

    /// @param name  "!--name" sets `target` to false.
    Option flag(const std::string& name, bool& target, const std::string& help);
    /// A flag that may have a number, "--name" or "--name=NUMBER".
    /// @param without  what "--name" alone sets
    Option flag_or_number(const std::string& name, int without, int& target, const std::string& help);

    /// The readers below call reject() for a value that they do not accept.
    Option text(const std::string& name, const std::function<void(const std::string&)>& read,
                const std::string& help);
    Option texts(const std::string& name, const std::function<void(const std::vector<std::string>&)>& read,
                 const std::string& help);
    Option number(const std::string& name, std::function<void(int)> read, const std::string& help);

    /// A command below this one. `execute` is run when it is chosen.
    Command command(const std::string& name, const std::string& help, std::function<ExitCode()> execute);
    /// A command that needs one of its own commands.
    Command group(const std::string& name, const std::string& help);
    /// Is called before the command is chosen, after its options were read; may call reject().
    void check(std::function<void()> check);

private:
    friend class CommandLine;
    Command(CLI::App* app, std::function<ExitCode()>* chosen) : app_(app), chosen_(chosen) {}
    CLI::App* app_;
    std::function<ExitCode()>* chosen_;
    std::function<ExitCode()> execute_;
};

/// Ends the parsing.
[[noreturn]] void reject(OptionError error);

class CommandLine {
public:
    CommandLine(const std::string& help, const std::string& name, const std::string& version);
    ~CommandLine();
    CommandLine(const CommandLine&) = delete;
    CommandLine& operator=(const CommandLine&) = delete;

    /// The command above all others: its options go with each command.
    [[nodiscard]] Command root();
    /// Options of a command that live as long as the command line.
    template <class Options>
    Options& keep() {
        auto options = std::make_shared<Options>();
        kept_.push_back(options);
        return *options;
    }
    /// The names of the commands below root(), or below one of those.
    [[nodiscard]] std::vector<std::string> commands(const std::string& group = {}) const;
    /// Where the command stands: behind options of all commands and their values. Without one, or behind an
    /// option that no command has: the number of arguments.
    [[nodiscard]] std::size_t command_index(std::span<const std::string> arguments) const;

    enum class Asked { command, text, nothing_valid };
    struct Parsed {
        Asked asked = Asked::command;
        std::string text;  ///< Asked::text: help or version; nothing_valid: the help, if a command is missing
        OptionError error;                  ///< Asked::nothing_valid
        std::function<ExitCode()> execute;  ///< of the chosen command
    };
    /// @param texts  is called where help is to be shown
    [[nodiscard]] Parsed parse(std::vector<std::string> arguments, const std::function<Texts()>& texts);

private:
    std::unique_ptr<CLI::App> app_;
    std::function<ExitCode()> chosen_;
    std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace takt::app
