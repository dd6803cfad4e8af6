// takt read --watch: reads the ranges again and again, in the requests that the planner makes of them.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "commands.hpp"
#include "online/one_off.hpp"
#include "output.hpp"
#include "takt/console/clock_text.hpp"
#include "takt/console/keyboard.hpp"
#include "takt/plan/plan.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/panel.hpp"
#include "takt/report/states/watch_report.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kWatchRedrawEvery = 500ms;

class Watch {
public:
    Watch(const Texts& texts, const ReadOptions& options, model::Project project)
        : texts_(texts),
          options_(options),
          project_(std::move(project)),
          plan_(plan::make_plan(project_)),
          values_(variables().size()),
          report_(texts, variables(), options.changes, target_text(options)),
          terminal_(!options.json && ::isatty(STDOUT_FILENO) != 0) {}

    ExitCode run() {
        auto opened = OneOff::open(texts_, options_);
        if (!opened) {
            if (options_.json) print(report::watch_error_json(texts_, opened.error()).dump() + '\n');
            return ended_by(texts_, opened.error());
        }
        one_off_ = *std::move(opened);
        if (terminal_ && ::isatty(STDIN_FILENO) != 0) take_keys();
        start_ = line::now();
        const Instant end = options_.run_for ? after(start_, *options_.run_for) : kNever;
        for (Instant next = start_; next <= end && go_on();) {
            sample();
            next = std::max(after(next, *options_.watch), line::now());
            wait_until(std::min(next, end));
            if (next >= end) break;
        }
        finish();
        return statistics_.time.count() > 0 ? ExitCode::ok : last_code_;
    }

private:
    [[nodiscard]] const std::vector<model::Variable>& variables() const {
        return project_.lines[0].devices[0].variables;
    }
    [[nodiscard]] client::Client& device() const { return one_off_->device(); }
    [[nodiscard]] bool go_on() const { return !device().interrupted() && stdout_error() == 0; }

    /// "tcp://host:502, unit 1"
    static std::string target_text(const ReadOptions& options) {
        return fmt::format("{}, unit {}", options.target, options.unit);
    }

    void take_keys() {
        selection_.takes_keys = true;
        keyboard_.emplace(one_off_->loop(), STDIN_FILENO, [this](const console::Key& key) {
            if (!console::apply_key(selection_, key, {})) return one_off_->loop().stop();
            redraw();
        });
    }

    void sample() {
        ++statistics_.samples;
        for (auto& value : values_) value.changed = false;
        std::vector<report::FailedRequest> failures;
        for (const auto& request : plan_.lines[0].requests) {
            const Instant begin = line::now();
            const auto done = carry_out(request);
            if (device().interrupted()) {
                --statistics_.samples;  // it is not complete
                return;
            }
            if (done) {
                statistics_.time.record(line::now() - begin);
                continue;
            }
            ++statistics_.errors;
            last_code_ = exit_code(done.error());
            failures.push_back({&request, done.error()});
            const auto reason = report::reason_text(texts_, done.error());
            for (const auto index : request.variables) values_[index].trouble = reason;
        }
        failures_ = failures;
        print_sample(failures);
    }

    void print_sample(const std::vector<report::FailedRequest>& failures) {
        if (terminal_) return redraw();
        const Instant now = line::now();
        if (options_.json) {
            const auto object = report_.sample_json(console::iso_time(now), now - start_, statistics_.samples,
                                                    values_, failures);
            if (object != file::Json()) print(object.dump() + '\n');
            return;
        }
        const auto clock_time = console::iso_time(now);
        if (const auto lines = report_.lines(clock_time, values_); !lines.empty()) print(lines);
        for (const auto& failed : failures) print_error(report_.failure_line(clock_time, failed));
    }

    Result<void> carry_out(const plan::Request& request) {
        TAKT_TRY(auto read, client::read_variables(device(), request, variables()));
        const Instant t = line::now();
        for (std::size_t i = 0; i < read.size(); ++i)
            values_[request.variables[i]].update(std::move(read[i]), t);
        return {};
    }

    // ---- the table in place

    void wait_until(Instant t) {
        while (go_on() && line::now() < t) {
            device().pause(terminal_ ? std::min<Duration>(t - line::now(), kWatchRedrawEvery)
                                     : t - line::now());
            if (keyboard_) keyboard_->renew();
            if (terminal_ && go_on()) redraw();
        }
    }

    void redraw() {
        const report::Screen screen = screen_of(STDOUT_FILENO);
        print_raw(panel_.draw(
            screen, report_.table(screen, line::now(), values_, statistics_, failures_, selection_)));
    }

    void finish() const {
        if (options_.json)
            print(report::watch_summary_json(statistics_).dump() + '\n');
        else if (!terminal_)
            print_status(report_.statistics_text(statistics_) + '\n');
    }

    Texts texts_;
    const ReadOptions& options_;
    model::Project project_;
    plan::Plan plan_;
    std::vector<report::WatchedValue> values_;
    report::WatchReport report_;
    bool terminal_;
    std::unique_ptr<OneOff> one_off_;
    Instant start_;
    report::WatchStatistics statistics_;
    ExitCode last_code_ = ExitCode::timed_out;
    report::Panel panel_;
    report::LiveSelection selection_;
    std::vector<report::FailedRequest> failures_;  // of the last sample
    std::optional<console::Keyboard> keyboard_;
};

}  // namespace

ExitCode watch(const CommonOptions& common, const ReadOptions& options) {
    const Texts texts(common.language);
    client::WatchSpec spec{.ranges = {{options.spec.area, options.spec.start, options.spec.count}},
                           .layout = options.spec.layout,
                           .period = *options.watch,
                           .name = report::item_text};
    spec.ranges.insert(spec.ranges.end(), options.also.begin(), options.also.end());
    auto project = client::watch_project(options, spec);
    if (!project) return ended_with(texts.describe(project.error()), ExitCode::usage);
    return Watch(texts, options, *std::move(project)).run();
}

}  // namespace takt::app
