#include "help_texts.hpp"

#include <string>

namespace takt::app {
namespace {

std::string in_words(const Texts& texts, const std::string& code) {
    return code.starts_with("help.") ? texts(code) : code;
}

void put_into_words(CLI::Option& option, const Texts& texts) {
    option.description(in_words(texts, option.get_description()));
    if (option.get_group() == "Options") option.group(texts("help.label.Options"));
}

}  // namespace

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

}  // namespace takt::app
