// An SVG picture, drawn element by element: standalone, no scripts, no fonts but the viewer's own.
#pragma once

#include <string>
#include <string_view>

#include "takt/text/language.hpp"

namespace takt::report {

/// Text as XML content or attribute value. Markup is escaped; characters that XML 1.0 does not allow (control
/// characters, broken UTF-8) are replaced by U+FFFD.
[[nodiscard]] std::string xml_text(std::string_view text);

/// An upper estimate of the width of the text in a sans-serif font, in pixels.
[[nodiscard]] double text_width(std::string_view text, double font_size);

/// The text, cut with "…" so that its text_width() is at most `width` pixels.
[[nodiscard]] std::string text_within(std::string_view text, double font_size, double width);

/// The language as pages name it: "en", "ru", "uk".
[[nodiscard]] std::string_view page_language(text::Language language);

/// Coordinates are pixels from the upper left corner. `style` names classes of the page's style sheet.
class Svg {
public:
    struct Box {
        double x = 0;
        double y = 0;
        double width = 0;
        double height = 0;
    };

    /// @param attributes  further attributes, ` data-ns="5"`, escaped by the caller
    void rect(const Box& box, std::string_view style, std::string_view attributes = {});
    void line(double x1, double y1, double x2, double y2, std::string_view style);
    void text(double x, double y, std::string_view style, std::string_view content);
    /// @param commands  of SVG paths: "M0 0H5V7"
    void path(std::string_view commands, std::string_view style);
    /// A pattern of lines at an angle, for `fill:url(#id)` in the style sheet.
    void hatch(std::string_view id, double degrees, double distance, std::string_view line_style);
    /// The tooltip of the current group; the first element of the group.
    void title(std::string_view content);
    void begin_group(std::string_view style, std::string_view attributes = {});
    void end_group();

    struct Page {
        double width = 0;
        double height = 0;
        std::string_view language;
        std::string_view title;
        std::string_view style_sheet;
    };
    /// The document: an XML declaration and all elements, on white.
    [[nodiscard]] std::string document(const Page& page) const;

private:
    std::string body_;
};

}  // namespace takt::report
