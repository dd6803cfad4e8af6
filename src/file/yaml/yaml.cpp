#include "yaml/yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "takt/model/fields.hpp"
#include "yaml/yaml_builder.hpp"

namespace takt::file {
namespace {

namespace messages = YAML::ErrorMsg;

// The messages of yaml-cpp, grouped by their remedy. Other messages are shown unchanged.
struct Meaning {
    std::string_view beginning;
    std::string_view code;
};
const Meaning kMeanings[] = {
    {messages::END_OF_MAP, "file.indentation"},
    {messages::END_OF_SEQ, "file.indentation"},
    {messages::MAP_KEY, "file.indentation"},
    {messages::BLOCK_ENTRY, "file.list_entry"},
    {messages::MAP_VALUE, "file.colon"},
    {messages::END_OF_MAP_FLOW, "file.unclosed_bracket"},
    {messages::END_OF_SEQ_FLOW, "file.unclosed_bracket"},
    {messages::FLOW_END, "file.bracket"},
    {messages::TAB_IN_INDENTATION, "file.tab"},
    {messages::UNKNOWN_TOKEN, "file.reserved_character"},
    {messages::UNKNOWN_ANCHOR, "file.alias"},
    {messages::ALIAS_NOT_FOUND, "file.alias"},
    {messages::CHAR_IN_ALIAS, "file.alias"},
    {messages::INVALID_ESCAPE, "file.escape"},
    {messages::INVALID_HEX, "file.escape"},
    {messages::INVALID_UNICODE, "file.escape"},
    {messages::EOF_IN_SCALAR, "file.unclosed_quote"},
    {messages::DOC_IN_SCALAR, "file.unclosed_quote"},
};

std::string_view syntax_error_code(const std::string& message) {
    const auto found = std::ranges::find_if(
        kMeanings, [&](const Meaning& meaning) { return message.starts_with(meaning.beginning); });
    return found == std::end(kMeanings) ? "file.syntax" : found->code;
}

// An error at the end of the file is reported behind the last character, not on the empty line after it.
model::SourceLocation location_of_error(const Source& source, std::size_t offset) {
    const auto text = source.text();
    if (offset < text.size()) return source.location(offset);
    const auto last = text.find_last_not_of(" \t\r\n");
    return source.location(last == std::string_view::npos ? 0 : last + 1);
}

// The tab in the indentation of the line of `offset`, or npos. yaml-cpp often reports such a tab as another
// error.
std::size_t indenting_tab(std::string_view text, std::size_t offset) {
    const auto before = text.substr(0, offset);
    const auto line = before.substr(before.rfind('\n') + 1);
    const auto tab = line.substr(0, line.find_first_not_of(" \t")).find('\t');
    return tab == std::string_view::npos ? tab : before.size() - line.size() + tab;
}

// A line such as `- name:l1`, which YAML reads as the text `name:l1`, so that the colon of a later line is
// too many.
struct MissingSpace {
    std::size_t offset = 0;
    std::string_view key;
    std::string_view rest;
};

std::optional<MissingSpace> missing_space_in(std::string_view line, std::size_t offset) {
    const auto begin = std::min(line.find_first_not_of(" -"), line.size());
    const auto text = line.substr(begin);
    const auto colon = text.find(':');
    if (colon == std::string_view::npos || text.find(": ") != std::string_view::npos) return std::nullopt;
    const auto rest = text.substr(colon + 1);
    const auto key = text.substr(0, colon);
    const bool known = std::ranges::any_of(
        model::kObjects, [&](model::Object object) { return model::find_field(object, key) != nullptr; });
    const bool blank = rest.find_first_not_of(" \r") == std::string_view::npos;
    if (!known || blank || rest.starts_with("//")) return std::nullopt;
    return MissingSpace{offset + begin, key, rest.substr(0, rest.find_last_not_of(" \r") + 1)};
}

// Searches the line of `offset` and those before it that may belong to the same text.
std::optional<MissingSpace> missing_space(std::string_view text, std::size_t offset) {
    constexpr int kMostLines = 3;
    auto begin = text.rfind('\n', offset == 0 ? 0 : offset - 1) + 1;
    auto end = std::min(text.find('\n', begin), text.size());
    for (int line = 0; line < kMostLines; ++line) {
        if (auto found = missing_space_in(text.substr(begin, end - begin), begin)) return found;
        if (begin == 0) break;
        end = begin - 1;
        begin = end == 0 ? 0 : text.rfind('\n', end - 1) + 1;
    }
    return std::nullopt;
}

void report(const YAML::Exception& trouble, const Source& source, const YamlBuilder& builder,
            Reporter& reporter) {
    const auto offset = offset_of(trouble.mark, source);
    const auto tab = indenting_tab(source.text(), offset);
    if (tab != std::string_view::npos && builder.open_bracket().line == 0)
        return reporter.error("file.tab", source.location(tab), {.path = builder.path()});
    auto code = syntax_error_code(trouble.msg);
    Details details{.path = builder.path()};
    const auto quote = builder.quote_before(offset);
    if (quote.line > 0 && (code == "file.indentation" || code == "file.unclosed_bracket")) {
        code = "file.quote_ended";
        details.arguments.emplace_back("line", std::to_string(quote.line));
    } else if (code == "file.unclosed_bracket") {
        details.arguments.emplace_back("line", std::to_string(builder.open_bracket().line));
    } else if (const auto slip = code == "file.colon" || code == "file.indentation"
                                     ? missing_space(source.text(), offset)
                                     : std::nullopt) {
        details.arguments = {{"key", std::string(slip->key)}, {"rest", std::string(slip->rest)}};
        return reporter.error("file.no_space", source.location(slip->offset), std::move(details));
    } else if (code == "file.reserved_character") {
        details.value = source.character(offset);
    } else if (code == "file.syntax") {
        details.arguments.emplace_back("detail", trouble.msg);
    }
    reporter.error(code, location_of_error(source, offset), std::move(details));
}

}  // namespace

std::optional<model::Node> read_yaml(const Source& source, std::size_t& nodes_left, Reporter& reporter) {
    YamlBuilder builder(source, nodes_left, reporter);
    // Without the final line break yaml-cpp reports an open quote at the end of the file, not at its
    // beginning.
    std::istringstream stream(std::string(source.text()) + "\n");
    try {
        YAML::Parser parser(stream);
        while (parser.HandleNextDocument(builder)) {}
    } catch (const Stop&) {
        return std::nullopt;
    } catch (const YAML::Exception& trouble) {
        report(trouble, source, builder, reporter);
        return std::nullopt;
    }
    if (builder.has_content()) return builder.take_root();
    const bool blank = source.text().find_first_not_of(" \t\r\n") == std::string_view::npos;
    reporter.error(blank ? "file.empty" : "file.no_content", {.file = source.file()});
    return std::nullopt;
}

}  // namespace takt::file
