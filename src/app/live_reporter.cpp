// Values in place on a terminal: each refresh moves the cursor back up and writes the table again. What does
// not fit on the screen is left out and counted; news (a device stops answering, a link goes) stand above the
// table and scroll away.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "takt/app/console.hpp"
#include "takt/app/reporter.hpp"
#include "takt/app/summary.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/learnt_report.hpp"
#include "takt/report/panel.hpp"
#include "takt/report/text_table.hpp"

namespace takt::app {
namespace {

class LiveReporter final : public Reporter {
public:
    LiveReporter(const Scene& scene, const Texts& texts, os::LineWriter& out)
        : scene_(scene), texts_(texts), out_(out) {}

    void on_value(const value::Event&) override {}
    void on_missed(std::uint64_t) override {}

    void on_device(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) override {
        news(t, scene_.project.lines[line].devices[device].name + ": " +
                    texts_(fmt::format("app.state.{}", poll::name(state))));
    }
    void on_overrun(Instant t, std::size_t line, const plan::Request& request,
                    const Overrun& overrun) override {
        news(t, overrun_text(scene_, texts_, line, request, overrun));
    }
    void on_write_waiting(Instant t, std::size_t line, const plan::Request& request,
                          std::size_t variable) override {
        news(t, write_waiting_text(scene_, texts_, line, request, variable));
    }
    void on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                          const value::Value& read) override {
        news(t, verify_failed_text(scene_, texts_, slot, written, read));
    }
    void on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) override {
        news(t, report::lesson_text(texts_, scene_.project.lines[line], lesson));
    }
    void on_unwritten(Instant t, const Unwritten& what, const Answer&) override {
        if (what.reason == value::Reason::differs) return;  // told with what was read back
        news(t, unwritten_text(scene_, texts_, what));
    }
    void on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why) override {
        news(t, link_text(scene_, texts_, line, up, why));
    }
    void on_answer(Instant, const Answer& answer) override { above_table(to_line(answer)); }

    void refresh(Instant t) override {
        const report::Screen size = screen_of(STDOUT_FILENO);
        out_.put(panel_.draw(size, table(t, size)));
    }

    void end(Instant t) override {
        refresh(t);
        out_.put_last('\n' + summary_text(scene_, texts_, t));
    }

private:
    void news(Instant t, const std::string& text) {
        above_table(time_stamp(t).substr(11) + ' ' + text + '\n');
    }

    void above_table(const std::string& text) { out_.put(panel_.above(screen_of(STDOUT_FILENO), text)); }

    [[nodiscard]] std::vector<std::string> table(Instant t, const report::Screen& size) const {
        report::TextTable table({report::TextTable::Align::left, report::TextTable::Align::left,
                                 report::TextTable::Align::right, report::TextTable::Align::right,
                                 report::TextTable::Align::left});
        table.add({texts_("app.device"), texts_("app.variable"), texts_("app.value"), texts_("app.age"), ""});
        const auto& store = scene_.master.store();
        const std::size_t most = std::max<std::size_t>(size.rows, 6) - 3;
        const std::size_t shown = store.size() < most ? store.size() : most - 1;  // below the headings
        for (std::uint32_t id = 0; id < shown; ++id) add_row(table, value::SlotId{id}, t);
        std::vector<std::string> lines = table.lines(size.columns - 1);
        if (const auto hidden = store.size() - shown; hidden > 0)
            lines.push_back(texts_("app.more_rows", {{"count", std::to_string(hidden)}}));
        return lines;
    }

    void add_row(report::TextTable& table, value::SlotId id, Instant t) const {
        const auto& slot = scene_.master.store()[id];
        const auto& info = scene_.master.store().info(id);
        const bool aged = !info.local && slot.good_at;
        table.add({device_name(scene_, id), info.name, shown_value(scene_, id, slot.value),
                   aged ? report::milliseconds_text(std::max(Duration{}, t - *slot.good_at)) : "",
                   slot.quality == value::Quality::good ? "" : texts_.quality(slot.quality, slot.reason)});
    }

    Scene scene_;
    Texts texts_;
    os::LineWriter& out_;
    report::Panel panel_;
};

}  // namespace

std::unique_ptr<Reporter> make_live_reporter(const Scene& scene, const Texts& texts, os::LineWriter& out) {
    return std::make_unique<LiveReporter>(scene, texts, out);
}

}  // namespace takt::app
