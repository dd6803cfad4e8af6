#include "options/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <sstream>
#include <utility>

namespace takt::app {
namespace {

std::string in_words(const Texts& texts, const std::string& code) {
    return code.starts_with("help.") ? texts(code) : code;
}

void put_into_words(CLI::Option& option, const Texts& texts) {
    option.description(in_words(texts, option.get_description()));
    if (option.get_group() == "Options") option.group(texts("help.label.Options"));
}

// Replaces the codes of messages by the messages, of all commands below `app` too.
void put_into_words(CLI::App& app, const Texts& texts) {
    for (const char* label :
         {"Usage", "Positionals", "OPTIONS", "SUBCOMMAND", "REQUIRED", "Needs", "Excludes"})
        app.get_formatter()->label(label, texts(std::string("help.label.") + label));
    app.description(in_words(texts, app.get_description()));
    if (auto* help = app.get_help_ptr()) help->description(texts("help.help"));
    if (auto* version = app.get_version_ptr()) version->description(texts("help.version"));
    for (auto* option : app.get_options([](const CLI::Option*) { return true; }))
        put_into_words(*option, texts);
    for (auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        put_into_words(*command, texts);
        command->group(texts("help.label.Subcommands"));
    }
}

}  // namespace

void reject(const std::string& option, const std::string& why) {
    throw CLI::ValidationError(option, why);
}

void reject_missing(const std::string& what) {
    throw CLI::RequiredError(what);
}

Option& Option::required() {
    option_->required();
    return *this;
}

Option& Option::value_name(const std::string& name) {
    option_->type_name(name);
    return *this;
}

Option& Option::needs(Option other) {
    option_->needs(other.option_);
    return *this;
}

Option& Option::excludes(Option other) {
    option_->excludes(other.option_);
    return *this;
}

Option& Option::range(int least, int greatest) {
    option_->check(CLI::Range(least, greatest));
    return *this;
}

Option& Option::one_of(std::vector<std::string> words) {
    option_->check(CLI::IsMember(std::move(words)));
    return *this;
}

Option& Option::longest(std::size_t bytes) {
    option_->check([bytes](const std::string& text) {
        return text.size() <= bytes ? std::string() : "is longer than " + std::to_string(bytes) + " bytes";
    });
    return *this;
}

Option& Option::count(int least, int most) {
    option_->expected(least, most);
    return *this;
}

Option& Option::repeatable() {
    option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    return *this;
}

Option& Option::one_value_each() {
    option_->allow_extra_args(false);
    return *this;
}

Option& Option::default_text(const std::string& text) {
    option_->default_str(text);
    return *this;
}

Option& Option::show_default() {
    option_->capture_default_str();
    return *this;
}

Option& Option::marks(bool& given) {
    option_->each([&given](const std::string&) { given = true; });
    return *this;
}

template <class T>
Option Command::value(const std::string& name, T& target, const std::string& help) {
    return Option(app_->add_option(name, target, help));
}
template Option Command::value(const std::string&, std::string&, const std::string&);
template Option Command::value(const std::string&, std::uint8_t&, const std::string&);
template Option Command::value(const std::string&, std::uint16_t&, const std::string&);
template Option Command::value(const std::string&, std::uint32_t&, const std::string&);
template Option Command::value(const std::string&, std::size_t&, const std::string&);
template Option Command::value(const std::string&, std::optional<std::uint16_t>&, const std::string&);
template Option Command::value(const std::string&, std::optional<std::uint32_t>&, const std::string&);
template Option Command::value(const std::string&, std::vector<std::string>&, const std::string&);

Option Command::flag(const std::string& name, bool& target, const std::string& help) {
    return Option(app_->add_flag(name, target, help));
}

Option Command::text(const std::string& name, std::function<void(const std::string&)> read,
                     const std::string& help) {
    return Option(app_->add_option_function<std::string>(name, std::move(read), help));
}

Option Command::texts(const std::string& name, std::function<void(const std::vector<std::string>&)> read,
                      const std::string& help) {
    return Option(app_->add_option_function<std::vector<std::string>>(name, std::move(read), help));
}

Option Command::number(const std::string& name, std::function<void(int)> read, const std::string& help) {
    return Option(app_->add_option_function<int>(
        name, [read = std::move(read)](const int& number) { read(number); }, help));
}

Option Command::find(const std::string& name) const {
    return Option(app_->get_option(name));
}

Command Command::command(const std::string& name, const std::string& help,
                         std::function<ExitCode()> execute) {
    Command command(app_->add_subcommand(name, help), chosen_);
    command.execute_ = std::move(execute);
    command.app_->fallthrough();
    command.check([] {});
    return command;
}

Command Command::group(const std::string& name, const std::string& help) {
    Command group(app_->add_subcommand(name, help), chosen_);
    group.app_->require_subcommand(1);
    group.app_->fallthrough();
    return group;
}

void Command::check(std::function<void()> check) {
    app_->callback([chosen = chosen_, execute = execute_, check = std::move(check)] {
        check();
        *chosen = execute;
    });
}

CommandLine::CommandLine(const std::string& help, const std::string& name, const std::string& version)
    : app_(std::make_unique<CLI::App>(help, name)) {
    app_->set_version_flag("--version", version);
    app_->require_subcommand(1);
}

CommandLine::~CommandLine() = default;

Command CommandLine::root() {
    return Command(app_.get(), &chosen_);
}

std::vector<std::string> CommandLine::commands() const {
    std::vector<std::string> names;
    for (const auto* command : app_->get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

CommandLine::Parsed CommandLine::parse(std::vector<std::string> arguments,
                                       const std::function<Texts()>& texts) {
    try {
        std::ranges::reverse(arguments);
        app_->parse(arguments);
    } catch (const CLI::Success& asked) {  // --help, --version
        put_into_words(*app_, texts());
        std::ostringstream text;
        app_->exit(asked, text, text);
        return {Asked::text, text.str(), {}};
    } catch (const CLI::ParseError& error) {
        return {Asked::nothing_valid, error.what(), {}};
    }
    return {Asked::command, {}, chosen_};
}

}  // namespace takt::app
