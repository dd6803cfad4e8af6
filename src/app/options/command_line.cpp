#include "options/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <sstream>
#include <string_view>
#include <type_traits>
#include <utility>

#include "takt/base/ascii.hpp"
#include "takt/model/nearest.hpp"

namespace takt::app {
namespace {

// Thrown through CLI11, which catches only its own exceptions.
class Rejected final : public std::exception {
public:
    explicit Rejected(OptionError error) : error_(std::move(error)) {}
    [[nodiscard]] const OptionError& error() const { return error_; }

private:
    OptionError error_;
};

/// An option is shown with the word for its value; its default and what it needs are in its description.
/// An argument is shown as in the usage.
class HelpFormatter final : public CLI::Formatter {
public:
    std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
        return CLI::detail::find_and_replace(Formatter::make_help(app, std::move(name), mode), "\n\n\n",
                                             "\n\n");
    }
    std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
        const auto name = Formatter::make_option_name(option, is_positional);
        return name.substr(0, name.find('{'));  // "--no-identify{false}"
    }
    std::string make_option_opts(const CLI::Option* option) const override {
        const bool flag = option->get_type_size() == 0 || option->get_expected_max() == 0;
        if (flag) return option->get_type_name().empty() ? "" : "[=" + option->get_type_name() + ']';
        std::string text;
        if (!option->get_positional()) text += ' ' + option->get_type_name();
        if (option->get_expected_max() > 1) text += " ...";
        if (!option->get_positional() && option->get_required()) text += ' ' + get_label("REQUIRED");
        return text;
    }
    std::string make_option_usage(const CLI::Option* option) const override {
        auto text = make_option_name(option, true);
        if (option->get_expected_max() > 1) text += "...";
        return option->get_required() ? text : '[' + text + ']';
    }
};

// CLI11 would read 0100 as an octal number.
bool has_leading_zero(std::string_view text) {
    if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
    return text.size() > 1 && text[0] == '0' && is_digit(text[1]);
}

// The validator that add_range() adds and range() changes.
constexpr const char* kRange = "range";

std::function<std::string(std::string&)> range_check(const CLI::Option& option, std::int64_t least,
                                                     std::int64_t greatest) {
    return [&option, least, greatest](const std::string& text) -> std::string {
        if (has_leading_zero(text))
            reject({"app.option.leading_zero", {{"option", option.get_name()}, {"value", text}}});
        std::int64_t value = 0;
        const bool number = CLI::detail::lexical_cast(text, value);
        if (number && value >= least && value <= greatest) return {};
        const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        reject({number || digits ? "app.option.range" : "app.option.number",
                {{"option", option.get_name()},
                 {"value", text},
                 {"least", std::to_string(least)},
                 {"greatest", std::to_string(greatest)}}});
    };
}

std::string range_text(std::int64_t least, std::int64_t greatest) {
    return std::to_string(least) + ".." + std::to_string(greatest);
}

template <class T>
struct Contained {
    using Type = T;
};
template <class T>
struct Contained<std::optional<T>> {
    using Type = T;
};

/// The greatest number of a target; 0: it is no number.
template <class T>
constexpr std::int64_t greatest_of() {
    using Value = typename Contained<T>::Type;
    if constexpr (!std::is_unsigned_v<Value>)
        return 0;
    else
        return std::min<std::uint64_t>(std::numeric_limits<Value>::max(),
                                       std::numeric_limits<std::int64_t>::max());
}

std::string in_words(const Texts& texts, const std::string& code) {
    return code.starts_with("help.") ? texts(code) : code;
}

void put_into_words(CLI::Option& option, const Texts& texts) {
    auto description = in_words(texts, option.get_description());
    if (const auto value = option.get_default_str(); !value.empty())
        description += ' ' + texts("help.default", {{"value", value}});
    option.description(description);
    option.group(option.get_group() == "Options" ? texts("help.label.Options")
                                                 : in_words(texts, option.get_group()));
}

OptionError unknown_option_of(const CLI::App& command, const std::string& text) {
    std::vector<std::string> names;
    for (const auto* app = &command; app != nullptr; app = app->get_parent())
        for (const auto* option : app->get_options()) {
            if (option->get_positional()) names.push_back(option->get_name());
            for (const auto& name : option->get_lnames()) names.push_back("--" + name);
        }
    const std::vector<std::string_view> candidates(names.begin(), names.end());
    return unknown_option(text, candidates);
}

bool is_option(const CLI::App* command, const std::string& name) {
    for (; command != nullptr; command = command->get_parent())
        if (command->get_option_no_throw(name) != nullptr) return true;
    return false;
}

const CLI::App& chosen_command(const CLI::App& app) {
    const CLI::App* command = &app;
    while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
    return *command;
}

/// The error about the first argument that is an unknown long option. The parser takes the value behind it
/// for an argument of the command, and reports that value.
std::optional<OptionError> find_unknown_option(const CLI::App& app, const std::vector<std::string>& given) {
    const auto& command = chosen_command(app);
    for (const auto& argument : given) {
        if (argument == "--") break;
        const auto name = argument.substr(0, argument.find('='));
        if (name.starts_with("--") && !is_option(&command, name)) return unknown_option_of(command, name);
    }
    return std::nullopt;
}

/// Of arguments that no command takes: the first unknown option, or all of them.
OptionError extras_error(const CLI::App& app) {
    const auto extras = app.remaining(true);
    const auto unknown = std::ranges::find_if(extras, [](const std::string& extra) {
        return extra.size() > 1 && extra[0] == '-' && !is_digit(extra[1]);
    });
    if (unknown == extras.end()) return {"app.option.extra", {{"value", CLI::detail::join(extras, " ")}}};
    return unknown_option_of(chosen_command(app), unknown->substr(0, unknown->find('=')));
}

/// An option of `app` or of a chosen command below it that has more values than it takes; nullptr: none.
const CLI::Option* find_excess(const CLI::App& app) {
    for (const auto* option : app.get_options())
        if (static_cast<int>(option->count()) > std::max(1, option->get_items_expected_max())) return option;
    for (const auto* command : app.get_subcommands())
        if (const auto* option = find_excess(*command)) return option;
    return nullptr;
}

OptionError excess_error(const CLI::Option& option) {
    const auto greatest = std::max(1, option.get_items_expected_max());
    return {greatest == 1 ? "app.option.repeated" : "app.option.too_many",
            {{"option", option.get_name()},
             {"count", std::to_string(option.count())},
             {"values", CLI::detail::join(option.results(), ", ")},
             {"greatest", std::to_string(greatest)}}};
}

// Replaces the codes of messages by the messages, of all commands below `app` too.
void put_into_words(CLI::App& app, const Texts& texts) {
    for (const char* label : {"Usage", "Positionals", "OPTIONS", "SUBCOMMAND", "REQUIRED"})
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

void reject(OptionError error) {
    throw Rejected(std::move(error));
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

Option& Option::add_range(std::int64_t least, std::int64_t greatest) {
    option_->check(CLI::Validator(range_check(*option_, least, greatest), "", kRange));
    return value_name(range_text(least, greatest));
}

Option& Option::range(int least, int greatest) {
    option_->get_validator(kRange)->operation(range_check(*option_, least, greatest));
    return value_name(range_text(least, greatest));
}

Option& Option::one_of(std::vector<std::string> words) {
    option_->check([option = option_, words = std::move(words)](const std::string& text) -> std::string {
        if (std::ranges::find(words, text) != words.end()) return {};
        reject(word_error(option->get_name(), text, CLI::detail::join(words, ", ")));
    });
    return *this;
}

Option& Option::check(std::function<void(const std::string&)> check) {
    option_->check([check = std::move(check)](const std::string& text) {
        check(text);
        return std::string();
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

Option& Option::group(const std::string& code) {
    option_->group(code);
    return *this;
}

template <class T>
Option Command::value(const std::string& name, T& target, const std::string& help) {
    Option option(app_->add_option(name, target, help));
    if constexpr (greatest_of<T>() != 0) option.add_range(0, greatest_of<T>());
    return option;
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

Option Command::flag_or_number(const std::string& name, int without, int& target, const std::string& help) {
    Option option(app_->add_flag(name + '{' + std::to_string(without) + '}', target, help));
    return option.add_range(0, std::numeric_limits<int>::max());
}

Option Command::text(const std::string& name, const std::function<void(const std::string&)>& read,
                     const std::string& help) {
    return Option(app_->add_option_function<std::string>(name, read, help));
}

Option Command::texts(const std::string& name,
                      const std::function<void(const std::vector<std::string>&)>& read,
                      const std::string& help) {
    return Option(app_->add_option_function<std::vector<std::string>>(name, read, help));
}

Option Command::number(const std::string& name, std::function<void(int)> read, const std::string& help) {
    Option option(app_->add_option_function<int>(
        name, [read = std::move(read)](const int& number) { read(number); }, help));
    return option.add_range(0, std::numeric_limits<int>::max());
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
    app_->formatter(std::make_shared<HelpFormatter>());
}

CommandLine::~CommandLine() = default;

Command CommandLine::root() {
    return Command(app_.get(), &chosen_);
}

std::vector<std::string> CommandLine::commands(const std::string& group) const {
    std::vector<std::string> names;
    const auto* const above = group.empty() ? app_.get() : app_->get_subcommand(group);
    for (const auto* command : above->get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(command->get_name());
    return names;
}

std::size_t CommandLine::command_index(std::span<const std::string> arguments) const {
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const auto& argument = arguments[i];
        if (!argument.starts_with('-')) return i;
        const auto equals = argument.find('=');
        const auto* const option = app_->get_option_no_throw(argument.substr(0, equals));
        if (option == nullptr) break;
        if (option->get_items_expected_min() > 0 && equals == std::string::npos) ++i;
    }
    return arguments.size();
}

CommandLine::Parsed CommandLine::parse(std::vector<std::string> arguments,
                                       const std::function<Texts()>& texts) {
    const auto given = arguments;
    const auto invalid = [&](OptionError error) {
        if (auto unknown = find_unknown_option(*app_, given)) error = *std::move(unknown);
        return Parsed{Asked::nothing_valid, {}, std::move(error), {}};
    };
    try {
        std::ranges::reverse(arguments);
        app_->parse(arguments);
    } catch (const CLI::Success& asked) {  // --help, --version
        put_into_words(*app_, texts());
        std::ostringstream text;
        app_->exit(asked, text, text);
        return {Asked::text, text.str(), {}, {}};
    } catch (const Rejected& rejected) {
        return invalid(rejected.error());
    } catch (const CLI::ExtrasError&) {
        return invalid(extras_error(*app_));
    } catch (const CLI::ArgumentMismatch& mismatch) {
        const auto* const option = find_excess(*app_);
        return invalid(option ? excess_error(*option) : option_error(mismatch.what()));
    } catch (const CLI::ParseError& failure) {
        auto error = option_error(failure.what());
        if (error.code != "app.option.no_command" || find_unknown_option(*app_, given))
            return invalid(std::move(error));
        put_into_words(*app_, texts());
        return {Asked::nothing_valid, app_->help(), std::move(error), {}};
    }
    return {Asked::command, {}, {}, chosen_};
}

}  // namespace takt::app
