// A display in place on a terminal: each refresh moves the cursor up and writes it again. Events other than
// values scroll away above it.
#include <algorithm>
#include <optional>
#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/console/run_view.hpp"
#include "takt/report/event_report.hpp"
#include "takt/report/live_screen.hpp"
#include "takt/report/panel.hpp"
#include "takt/report/summary_report.hpp"
#include "takt/report/word_wrap.hpp"

namespace takt::console {
namespace {

class LiveView final : public RunView {
public:
    LiveView(host::Session& session, const Texts& texts, os::LineWriter& out,
             std::function<report::Screen()> screen, report::LiveSelection selection)
        : session_(session),
          texts_(texts),
          out_(out),
          screen_(std::move(screen)),
          selection_(std::move(selection)) {}

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
    void end(const host::Snapshot& last) override {
        selection_.takes_keys = selection_.typing = false;
        draw(last);
        out_.put_last('\n' + report::summary_text(texts_, last, screen_().columns));
    }

private:
    void above_table(const std::string& text) {
        const report::Screen size = screen_();
        out_.put(panel_.above(size, report::wrapped(text, size.columns)));
    }

    void draw(const host::Snapshot& now) {
        const report::Screen size = screen_();
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
    report::Panel panel_;
    std::optional<host::Snapshot> shown_;  // that was drawn last
};

}  // namespace

std::unique_ptr<RunView> make_live_view(host::Session& session, const Texts& texts, os::LineWriter& out,
                                        std::function<report::Screen()> screen,
                                        report::LiveSelection selection) {
    return std::make_unique<LiveView>(session, texts, out, std::move(screen), std::move(selection));
}

}  // namespace takt::console
