// A display in place on a terminal: each refresh moves the cursor up and writes it again. Events other than
// values scroll away above it.
#include <algorithm>
#include <optional>
#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/console/run_view.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/drawing/word_wrap.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/live_screen.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/states/summary_report.hpp"

namespace takt::console {
namespace {

class LiveView final : public RunView {
public:
    LiveView(host::Session& session, const Texts& texts, os::LineWriter& out,
             std::function<report::Screen()> screen, report::LiveSelection selection, OutputStates outputs)
        : session_(session),
          texts_(texts),
          out_(out),
          screen_(std::move(screen)),
          selection_(std::move(selection)),
          outputs_(std::move(outputs)) {}

    void on_event(const host::Configuration& configuration, const host::Event& event) override {
        if (std::holds_alternative<host::ValueChanged>(event.body)) return;
        const auto text = report::event_text(texts_, configuration, event);
        if (!text.empty()) above_table(iso_time(event.t) + ' ' + text + '\n');
    }
    void on_missed(std::uint64_t) override {}
    void on_answer(Instant, const Answer& answer) override { above_table(answer.line); }

    bool on_key(const Key& key) override {
        const bool goes_on = apply_key(selection_, key, devices());
        if (shown_) draw(*shown_);
        return goes_on;
    }

    void refresh() override {
        auto now = session_.snapshot({.values = true, .statistics = true});
        if (!now) return;
        shown_ = *std::move(now);
        draw(*shown_);
    }
    void on_output(Instant t, const publish::OutputStatus& status) override {
        above_table(iso_time(t) + ' ' + report::output_text(texts_, status, wall_ns(t)) + '\n');
    }
    void end(const host::Snapshot& last, const std::vector<publish::OutputStatus>& outputs) override {
        selection_.takes_keys = selection_.typing = false;
        draw(last);
        const auto columns = screen_().columns;
        out_.put_last('\n' + report::summary_text(texts_, last, columns) +
                      outputs_summary(texts_, outputs, last.t, columns));
    }

private:
    void above_table(const std::string& text) {
        const report::Screen size = screen_();
        out_.put(panel_.above(size, report::wrapped(text, size.columns)));
    }

    void draw(const host::Snapshot& now) {
        const report::Screen size = screen_();
        selection_.outputs.clear();
        if (outputs_)
            for (const auto& status : outputs_())
                selection_.outputs.push_back(report::output_text(texts_, status, wall_ns(now.t)));
        out_.put(panel_.draw(size, report::live_screen(texts_, now, selection_, size)));
    }

    /// Names of devices, each once.
    [[nodiscard]] std::vector<std::string> devices() const {
        std::vector<std::string> names;
        for (const auto& line : session_.configuration()->project().lines)
            for (const auto& device : line.devices)
                if (std::ranges::find(names, device.name) == names.end()) names.push_back(device.name);
        return names;
    }

    host::Session& session_;
    Texts texts_;
    os::LineWriter& out_;
    std::function<report::Screen()> screen_;
    report::LiveSelection selection_;
    OutputStates outputs_;
    report::Panel panel_;
    std::optional<host::Snapshot> shown_;  // that was drawn last
};

}  // namespace

std::unique_ptr<RunView> make_live_view(host::Session& session, const Texts& texts, os::LineWriter& out,
                                        std::function<report::Screen()> screen,
                                        report::LiveSelection selection, OutputStates outputs) {
    return std::make_unique<LiveView>(session, texts, out, std::move(screen), std::move(selection),
                                      std::move(outputs));
}

}  // namespace takt::console
