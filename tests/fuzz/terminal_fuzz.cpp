// Arbitrary text from outside in the places where a terminal shows it: nothing of it is obeyed.
#include <string>
#include <string_view>

#include "input.hpp"
#include "takt/base/utf8.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/svg.hpp"
#include "takt/report/drawing/text_table.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/text/escape.hpp"

namespace {

using namespace takt;

void require_printable(std::string_view text, bool line_feeds) {
    while (!text.empty()) {
        const auto character = first_character(text);
        fuzz::require(character.bytes > 0);
        fuzz::require(is_printable(character.code) || (line_feeds && character.code == '\n'));
        text.remove_prefix(character.bytes);
    }
}

// Removes the escape sequences of the display itself.
std::string shown(std::string text) {
    for (const std::string_view own : {"\x1b[K", "\x1b[J"})
        for (auto at = text.find(own); at != std::string::npos; at = text.find(own))
            text.erase(at, own.size());
    return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string outside(reinterpret_cast<const char*>(data), size);
    require_printable(text::escape_line(outside), false);
    require_printable(text::escape_lines(outside), true);
    fuzz::require(text::escape_line(text::escape_line(outside)) == text::escape_line(outside));

    const report::Texts texts(text::Language::english);
    require_printable(texts("app.access.kept", {{"file", outside}}), false);
    report::TextTable table({report::TextTable::Align::left, report::TextTable::Align::right});
    table.add({outside, "1"});
    for (const auto& line : table.lines(40)) require_printable(line, false);
    report::Panel panel;
    require_printable(shown(panel.draw({24, 80}, {outside, "x"})), true);

    std::string_view xml = outside;
    const std::string escaped = report::xml_text(xml);
    fuzz::require(escaped.find_first_of("<>\"") == std::string::npos);
    return 0;
}
