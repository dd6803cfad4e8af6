// Values in place on a terminal: each refresh moves the cursor up and writes the table again. Rows that do
// not fit on the screen are left out and counted. Events other than values scroll away above the table.
#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/console/run_view.hpp"
#include "takt/report/event_report.hpp"
#include "takt/report/panel.hpp"
#include "takt/report/summary_report.hpp"
#include "takt/report/values_report.hpp"

namespace takt::console {
namespace {

class LiveView final : public RunView {
public:
    LiveView(host::Session& session, const Texts& texts, os::LineWriter& out,
             std::function<report::Screen()> screen)
        : session_(session), texts_(texts), out_(out), screen_(std::move(screen)) {}

    void on_event(const host::Configuration& configuration, const host::Event& event) override {
        if (std::holds_alternative<host::ValueChanged>(event.body)) return;
        const auto text = report::event_text(texts_, configuration, event);
        if (!text.empty()) above_table(time_of_day(event.t) + ' ' + text + '\n');
    }
    void on_missed(std::uint64_t) override {}
    void on_answer(Instant, const Answer& answer) override { above_table(answer.line); }

    void refresh() override {
        if (const auto now = session_.snapshot({.values = true})) draw(*now);
    }
    void end(const host::Snapshot& last) override {
        draw(last);
        out_.put_last('\n' + report::summary_text(texts_, last));
    }

private:
    void above_table(const std::string& text) { out_.put(panel_.above(screen_(), text)); }

    void draw(const host::Snapshot& values) {
        const report::Screen size = screen_();
        out_.put(panel_.draw(size, report::values_table(texts_, values, size)));
    }

    host::Session& session_;
    Texts texts_;
    os::LineWriter& out_;
    std::function<report::Screen()> screen_;
    report::Panel panel_;
};

}  // namespace

std::unique_ptr<RunView> make_live_view(host::Session& session, const Texts& texts, os::LineWriter& out,
                                        std::function<report::Screen()> screen) {
    return std::make_unique<LiveView>(session, texts, out, std::move(screen));
}

}  // namespace takt::console
