#include "takt/report/drawing/svg.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "takt/base/utf8.hpp"
#include "takt/report/drawing/text_table.hpp"

namespace takt::report {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";
constexpr double kMeanCharacter = 0.62;  // of the font size; digits and lower case of common sans-serif fonts

/// Bytes of the character at the front, as XML 1.0 allows it (section 2.2); 0: not allowed.
std::size_t character_length(std::string_view text) {
    const auto [code, bytes] = first_character(text);
    const bool control = code < 0x20 && code != '\t' && code != '\n';
    const bool noncharacter = code == 0xFFFE || code == 0xFFFF;
    return control || noncharacter ? 0 : bytes;
}

std::string svg_number(double value) {
    std::string text = fmt::format("{:.2f}", value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text == "-0" ? "0" : text;
}

}  // namespace

std::string xml_text(std::string_view text) {
    std::string escaped;
    while (!text.empty()) {
        const std::size_t length = character_length(text);
        switch (length == 1 ? text[0] : '\0') {
            case '<': escaped += "&lt;"; break;
            case '>': escaped += "&gt;"; break;
            case '&': escaped += "&amp;"; break;
            case '"': escaped += "&quot;"; break;
            default: escaped += length == 0 ? kReplacement : text.substr(0, length);
        }
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return escaped;
}

double text_width(std::string_view text, double font_size) {
    return static_cast<double>(display_width(text)) * font_size * kMeanCharacter;
}

std::string text_within(std::string_view text, double font_size, double width) {
    return fitted(text, static_cast<std::size_t>(std::max(width / (font_size * kMeanCharacter), 0.0)));
}

std::string_view page_language(text::Language language) {
    switch (language) {
        case text::Language::russian: return "ru";
        case text::Language::ukrainian: return "uk";
        case text::Language::english: break;
    }
    return "en";
}

void Svg::rect(const Box& box, std::string_view style, std::string_view attributes) {
    body_ += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}/>\n", style,
                         svg_number(box.x), svg_number(box.y), svg_number(box.width), svg_number(box.height),
                         attributes);
}

void Svg::line(double x1, double y1, double x2, double y2, std::string_view style) {
    body_ += fmt::format("<line class=\"{}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>\n", style,
                         svg_number(x1), svg_number(y1), svg_number(x2), svg_number(y2));
}

void Svg::text(double x, double y, std::string_view style, std::string_view content) {
    body_ += fmt::format("<text class=\"{}\" x=\"{}\" y=\"{}\">{}</text>\n", style, svg_number(x),
                         svg_number(y), xml_text(content));
}

void Svg::path(std::string_view commands, std::string_view style) {
    body_ += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", style, commands);
}

void Svg::hatch(std::string_view id, double degrees, double distance, std::string_view line_style) {
    body_ += fmt::format(
        "<defs><pattern id=\"{0}\" width=\"{1}\" height=\"{1}\" patternUnits=\"userSpaceOnUse\" "
        "patternTransform=\"rotate({2})\"><line class=\"{3}\" x1=\"0\" y1=\"0\" x2=\"0\" y2=\"{1}\"/>"
        "</pattern></defs>\n",
        id, svg_number(distance), svg_number(degrees), line_style);
}

void Svg::title(std::string_view content) {
    body_ += fmt::format("<title>{}</title>\n", xml_text(content));
}

void Svg::begin_group(std::string_view style, std::string_view attributes) {
    body_ += fmt::format("<g class=\"{}\"{}>\n", style, attributes);
}

void Svg::end_group() {
    body_ += "</g>\n";
}

std::string Svg::document(const Page& page) const {
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
        "role=\"img\" xml:lang=\"{2}\">\n<title>{3}</title>\n<style>\n{4}</style>\n"
        "<rect class=\"page\" x=\"0\" y=\"0\" width=\"{0}\" height=\"{1}\"/>\n{5}</svg>\n",
        svg_number(page.width), svg_number(page.height), page.language, xml_text(page.title),
        page.style_sheet, body_);
}

}  // namespace takt::report
