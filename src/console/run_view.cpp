#include "takt/console/run_view.hpp"

#include <cstdint>
#include <utility>

#include "takt/console/clock_text.hpp"
#include "takt/report/drawing/word_wrap.hpp"
#include "takt/report/states/event_report.hpp"
#include "takt/report/states/outputs_report.hpp"
#include "takt/report/states/summary_report.hpp"

namespace takt::console {
namespace {

/// docs/commands/run.md describes the objects.
class JsonView final : public RunView {
public:
    JsonView(Instant started, const Texts& texts, os::LineWriter& out)
        : started_(started), texts_(texts), out_(out) {}

    void on_event(const host::Configuration& configuration, const host::Event& event) override {
        auto object = report::event_json(texts_, configuration, started_, event);
        if (object.is_null()) return;
        object.set("time", iso_time(event.t));
        put(object);
    }
    void on_missed(std::uint64_t events) override { put(report::missed_json(events)); }
    void on_answer(Instant t, const Answer& answer) override {
        auto object = answer.json;
        object.set("time_ms", static_cast<double>((t - started_).count()) / 1e6);
        object.set("time", iso_time(t));
        put(object);
    }
    void on_output(Instant t, const publish::OutputStatus& status) override {
        auto object = file::Json::object();
        object.set("event", "output");
        object.set("output", report::output_json(texts_, status, wall_ns(t)));
        object.set("time_ms", static_cast<double>((t - started_).count()) / 1e6);
        object.set("time", iso_time(t));
        put(object);
    }
    void end(const host::Snapshot& last, const std::vector<publish::OutputStatus>& outputs) override {
        auto object = report::summary_json(last);
        if (!outputs.empty()) object.set("outputs", report::outputs_json(texts_, outputs, wall_ns(last.t)));
        object.set("time", iso_time(last.t));
        out_.put_last(object.dump() + '\n');
    }

private:
    void put(const file::Json& object) { out_.put(object.dump() + '\n'); }

    Instant started_;
    Texts texts_;
    os::LineWriter& out_;
};

class LineView final : public RunView {
public:
    LineView(const Texts& texts, os::LineWriter& out, std::function<report::Screen()> screen)
        : texts_(texts), out_(out), screen_(std::move(screen)) {}

    void on_event(const host::Configuration& configuration, const host::Event& event) override {
        const auto text = report::event_text(texts_, configuration, event);
        if (!text.empty()) out_.put(report::wrapped(iso_time(event.t) + ' ' + text + '\n', columns()));
    }
    void on_missed(std::uint64_t events) override { out_.put(report::missed_text(texts_, events) + '\n'); }
    void on_answer(Instant, const Answer& answer) override { out_.put(answer.line); }
    void on_output(Instant t, const publish::OutputStatus& status) override {
        const auto text = report::output_text(texts_, status, wall_ns(t));
        out_.put(report::wrapped(iso_time(t) + ' ' + text + '\n', columns()));
    }
    void end(const host::Snapshot& last, const std::vector<publish::OutputStatus>& outputs) override {
        out_.put_last('\n' + report::summary_text(texts_, last, columns()) +
                      outputs_summary(texts_, outputs, last.t, columns()));
    }

private:
    [[nodiscard]] std::size_t columns() const { return screen_ ? screen_().columns : SIZE_MAX; }

    Texts texts_;
    os::LineWriter& out_;
    std::function<report::Screen()> screen_;
};

std::string json_gap_line(std::uint64_t missed) {
    return report::missed_json(missed).dump() + '\n';
}
std::string text_gap_line(std::uint64_t missed) {
    return "… " + std::to_string(missed) + "\n";
}

}  // namespace

os::WriterOptions output_options(bool json) {
    os::WriterOptions options;
    options.gap_line = json ? json_gap_line : text_gap_line;
    return options;
}

std::string outputs_summary(const Texts& texts, const std::vector<publish::OutputStatus>& outputs, Instant t,
                            std::size_t columns) {
    return outputs.empty()
               ? std::string()
               : '\n' + report::wrapped(report::outputs_text(texts, outputs, wall_ns(t)), columns);
}

std::unique_ptr<RunView> make_json_view(Instant started, const Texts& texts, os::LineWriter& out) {
    return std::make_unique<JsonView>(started, texts, out);
}

std::unique_ptr<RunView> make_line_view(const Texts& texts, os::LineWriter& out,
                                        std::function<report::Screen()> screen) {
    return std::make_unique<LineView>(texts, out, std::move(screen));
}

}  // namespace takt::console
