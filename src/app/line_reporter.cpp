// A line of text for each change: for pipes and files, and the words that the live view shows too.
#include <fmt/format.h>

#include "takt/app/reporter.hpp"
#include "takt/app/summary.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/learnt_report.hpp"

namespace takt::app {
namespace {

class LineReporter final : public Reporter {
public:
    LineReporter(const Scene& scene, const Texts& texts, os::LineWriter& out)
        : scene_(scene), texts_(texts), out_(out) {}

    void on_value(const value::Event& event) override {
        const std::string device = device_name(scene_, event.slot);
        std::string line = device.empty() ? "" : device + ' ';
        line += scene_.master.store().info(event.slot).name + " = " +
                shown_value(scene_, event.slot, event.value);
        if (event.quality != value::Quality::good)
            line += " (" + texts_.quality(event.quality, event.reason) + ")";
        put(event.t, line);
    }

    void on_missed(std::uint64_t events) override {
        out_.put(texts_("app.missed", {{"count", std::to_string(events)}}) + '\n');
    }

    void on_device(Instant t, std::size_t line, std::size_t device, poll::DeviceState state) override {
        put(t, scene_.project.lines[line].devices[device].name + ": " +
                   texts_(fmt::format("app.state.{}", poll::name(state))));
    }

    void on_overrun(Instant t, std::size_t line, const plan::Request& request,
                    const Overrun& overrun) override {
        put(t, overrun_text(scene_, texts_, line, request, overrun));
    }

    void on_write_waiting(Instant t, std::size_t line, const plan::Request& request,
                          std::size_t variable) override {
        put(t, write_waiting_text(scene_, texts_, line, request, variable));
    }

    void on_verify_failed(Instant t, value::SlotId slot, const value::Value& written,
                          const value::Value& read) override {
        put(t, verify_failed_text(scene_, texts_, slot, written, read));
    }

    void on_learnt(Instant t, std::size_t line, const poll::GapEvent& lesson) override {
        put(t, report::lesson_text(texts_, scene_.project.lines[line], lesson));
    }

    void on_unwritten(Instant t, const Unwritten& what, const Answer&) override {
        if (what.reason == value::Reason::differs) return;  // told with what was read back
        put(t, unwritten_text(scene_, texts_, what));
    }

    void on_link(Instant t, std::size_t line, bool up, const std::optional<Error>& why) override {
        put(t, link_text(scene_, texts_, line, up, why));
    }

    void on_answer(Instant, const Answer& answer) override { out_.put(to_line(answer)); }

    void refresh(Instant) override {}

    void end(Instant t) override { out_.put_last('\n' + summary_text(scene_, texts_, t)); }

private:
    void put(Instant t, const std::string& text) { out_.put(time_stamp(t).substr(11) + ' ' + text + '\n'); }

    Scene scene_;
    Texts texts_;
    os::LineWriter& out_;
};

}  // namespace

std::unique_ptr<Reporter> make_line_reporter(const Scene& scene, const Texts& texts, os::LineWriter& out) {
    return std::make_unique<LineReporter>(scene, texts, out);
}

}  // namespace takt::app
