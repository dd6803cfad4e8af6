// An interval of time of one line as a picture: as wide as the page, with a row for each device and the time
// axis below.
#pragma once

#include <map>
#include <span>
#include <string>

#include "drawing/picture.hpp"
#include "takt/plan/shares.hpp"

namespace takt::report::picture {

inline constexpr double kLabelGap = 2;  ///< pixels between a label and the next bar

inline double ms(Duration time) {
    return static_cast<double>(time.count()) / 1e6;
}

/// The items of a request, without its function.
[[nodiscard]] std::string items_text(const plan::Request& request);

/// The bars of an interval.
class Strip {
public:
    struct Shape {
        Duration begin{};
        Duration end{};
        double row_height = 0;
        double bar_height = 0;
        bool labels = false;
        const char* name = "";  // data-strip in the document, for programs
    };

    Strip(Svg& svg, const Texts& texts, const model::Project& project, const plan::LinePlan& plan,
          const Shape& shape, std::span<const plan::Bar> bars, double top);

    void highlight(Duration begin, Duration end);
    void draw(Legend& legend);
    [[nodiscard]] std::size_t left_out() const { return left_out_; }
    [[nodiscard]] double bottom() const { return axis_ + 20; }

private:
    struct Row {
        std::size_t index = 0;            // from the top
        const plan::Bar* last = nullptr;  // not drawn yet: its label ends where the next bar begins
        double merged_from = 0;           // a run of very short bars, drawn as one
        double merged_to = -1;
        std::size_t merged = 0;
    };

    [[nodiscard]] double x(Duration time) const { return kPlotLeft + ms(time - shape_.begin) * scale_; }
    void draw_rows();
    void draw_axis();
    void draw_bar(const Row& row, const plan::Bar& bar, double next, Legend& legend);
    void draw_parts(const plan::Bar& bar, double y, Legend& legend);
    void draw_merged(Row& row, Legend& legend);
    void draw_label(const plan::Request& request, double left, double available, double y);
    [[nodiscard]] std::string tooltip(const plan::Bar& bar) const;
    [[nodiscard]] double bar_top(const Row& row) const;

    Svg& svg_;
    const Texts& texts_;
    const model::Project& project_;
    const plan::LinePlan& plan_;
    const model::Line& line_;
    plan::Shares shares_;
    std::span<const plan::Bar> bars_;
    Shape shape_;
    double top_;
    double axis_;
    double scale_;
    std::map<std::size_t, Row> rows_;  // by device
    std::size_t left_out_ = 0;         // devices beyond the most rows
};

}  // namespace takt::report::picture
