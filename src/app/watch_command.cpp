// takt read --watch: the named ranges again and again, in the requests the planner makes of them.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "one_off.hpp"
#include "takt/app/client.hpp"
#include "takt/app/client_commands.hpp"
#include "takt/app/console.hpp"
#include "takt/app/texts.hpp"
#include "takt/app/traffic_log.hpp"
#include "takt/bus/counters.hpp"
#include "takt/file/json.hpp"
#include "takt/plan/plan.hpp"
#include "takt/report/formatting.hpp"
#include "takt/report/panel.hpp"
#include "takt/report/text_table.hpp"
#include "takt/report/value_json.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"
#include "watch_project.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kRedrawEvery = 500ms;

struct Watched {
    value::Value value;
    std::optional<Instant> read_at;
    std::uint64_t changes = 0;
    bool changed = false;  // by the last sample
    std::string trouble;   // why the last sample has no value for it
};

/// What went wrong with one request of a sample.
struct Failure {
    const plan::Request* request;
    Error error;
};

class Watch {
public:
    Watch(const Texts& texts, const ReadOptions& options, model::Project project)
        : texts_(texts),
          options_(options),
          project_(std::move(project)),
          plan_(plan::make_plan(project_)),
          values_(variables().size()),
          terminal_(!options.json && ::isatty(STDOUT_FILENO) != 0) {}

    ExitCode run() {
        auto opened = Client::open(options_);
        if (!opened) {
            if (options_.json) {
                auto object = report::error_json(texts_, opened.error());
                object.set("event", "error");
                print(object.dump() + "\n");
            }
            return ended_by(texts_, opened.error());
        }
        client_ = *std::move(opened);
        start_ = line::now();
        const Instant end = options_.run_for ? after(start_, *options_.run_for) : kNever;
        for (Instant next = start_; next <= end && go_on();) {
            sample();
            next = std::max(after(next, *options_.watch), line::now());
            wait_until(std::min(next, end));
            if (next >= end) break;
        }
        finish();
        return time_.count() > 0 ? ExitCode::ok : last_code_;
    }

private:
    [[nodiscard]] const std::vector<model::Variable>& variables() const {
        return project_.lines[0].devices[0].variables;
    }
    [[nodiscard]] bool go_on() const { return !client_->interrupted() && stdout_error() == 0; }

    void sample() {
        ++samples_;
        for (auto& value : values_) value.changed = false;
        std::vector<Failure> failures;
        for (const auto& request : plan_.lines[0].requests) {
            const Instant begin = line::now();
            const auto done = carry_out(request);
            if (client_->interrupted()) {
                --samples_;  // it is not whole
                return;
            }
            if (done) {
                time_.record(line::now() - begin);
                continue;
            }
            ++errors_;
            last_code_ = exit_code(done.error());
            failures.push_back({&request, done.error()});
            for (const auto index : request.variables) values_[index].trouble = texts_.describe(done.error());
        }
        if (options_.json)
            tell_json(failures);
        else if (terminal_)
            redraw();
        else
            tell_lines(failures);
    }

    Result<void> carry_out(const plan::Request& request) {
        TAKT_TRY(const auto response, client_->ask(wire::ReadRequest{
                                          *request.read, DataAddress{request.start}, request.quantity}));
        const Instant t = line::now();
        for (const auto index : request.variables) {
            const auto& variable = variables()[index];
            const std::size_t offset = std::size_t{variable.start()} - request.start;
            value::Value read;
            if (const auto bits = response.bits(); !bits.empty()) {
                read = bits[offset];
            } else {
                std::vector<std::uint16_t> registers(variable.registers);
                response.registers().subview(offset, variable.registers).copy_to(registers);
                TAKT_TRY(read, value::decode({.type = variable.type,
                                              .order = variable.order,
                                              .registers = variable.registers,
                                              .bit = {},
                                              .scale = 1,
                                              .offset = 0},
                                             registers));
            }
            take(values_[index], std::move(read), t);
        }
        return {};
    }

    static void take(Watched& watched, value::Value read, Instant t) {
        watched.changed = !watched.read_at || watched.value != read;
        if (watched.read_at && watched.changed) ++watched.changes;
        watched.value = std::move(read);
        watched.read_at = t;
        watched.trouble.clear();
    }

    [[nodiscard]] std::string shown(std::size_t index) const {
        const auto type = variables()[index].type;
        const auto& value = values_[index].value;
        if (value::is_empty(value)) return "–";
        if (type == DataType::boolean) return std::get<bool>(value) ? "1" : "0";
        return value::format(type, false, value);
    }

    [[nodiscard]] bool to_be_told(const Watched& value) const {
        return value.read_at && value.trouble.empty() && (value.changed || !options_.changes);
    }

    [[nodiscard]] static std::string span_text(const plan::Request& request) {
        return fmt::format("{} {}..{}", report::function_text(*request.read), request.start,
                           request.start + request.quantity - 1);
    }

    void tell_lines(const std::vector<Failure>& failures) const {
        const auto stamp = time_stamp(line::now()).substr(11);
        std::string text;
        for (std::size_t i = 0; i < values_.size(); ++i)
            if (to_be_told(values_[i]))
                text += fmt::format("{} {} = {}\n", stamp, variables()[i].name, shown(i));
        if (!text.empty()) print(text);
        for (const auto& failure : failures)
            print_error(
                fmt::format("{} {}: {}", stamp, span_text(*failure.request), texts_.describe(failure.error)));
    }

    void tell_json(const std::vector<Failure>& failures) const {
        auto values = file::Json::array();
        std::size_t told = 0;
        for (std::size_t i = 0; i < values_.size(); ++i) {
            if (!to_be_told(values_[i])) continue;
            ++told;
            auto entry = file::Json::object();
            entry.set("area", report::area_word(variables()[i].area));
            entry.set("address", variables()[i].start());
            entry.set("value", report::to_json(variables()[i].type, false, values_[i].value));
            entry.set("changed", values_[i].changed);
            values.push_back(std::move(entry));
        }
        if (options_.changes && told == 0 && failures.empty()) return;
        auto errors = file::Json::array();
        for (const auto& failure : failures) {
            auto entry = report::error_json(texts_, failure.error);
            entry.set("function", static_cast<int>(*failure.request->read));
            entry.set("start", failure.request->start);
            entry.set("quantity", failure.request->quantity);
            errors.push_back(std::move(entry));
        }
        auto object = file::Json::object();
        object.set("event", "sample");
        object.set("sample", samples_);
        object.set("time", time_stamp(line::now()));
        object.set("time_ms", (line::now() - start_) / 1ms);
        object.set("values", std::move(values));
        object.set("errors", std::move(errors));
        print(object.dump() + "\n");
    }

    // ---- the table in place

    void wait_until(Instant t) {
        while (go_on() && line::now() < t) {
            client_->pause(terminal_ ? std::min<Duration>(t - line::now(), kRedrawEvery) : t - line::now());
            if (terminal_ && go_on()) redraw();
        }
    }

    void redraw() {
        const report::Screen size = screen_of(STDOUT_FILENO);
        const std::size_t rows = std::max<std::size_t>(size.rows, 6) - 3;
        report::TextTable table({report::TextTable::Align::left, report::TextTable::Align::right,
                                 report::TextTable::Align::left, report::TextTable::Align::right,
                                 report::TextTable::Align::right, report::TextTable::Align::left});
        table.add({"", texts_("app.value"), "", texts_("app.age"), texts_("app.watch.changes"), ""});
        const Instant t = line::now();
        for (std::size_t i = 0; i < values_.size(); ++i) {
            const auto& value = values_[i];
            table.add({variables()[i].name, shown(i), value.changed && value.changes > 0 ? "*" : "",
                       value.read_at ? report::milliseconds_text(t - *value.read_at) : "",
                       std::to_string(value.changes), value.trouble});
        }
        auto lines = table.lines(size.columns - 1);
        if (lines.size() > rows) {
            const auto hidden = lines.size() - rows;
            lines.resize(rows);
            lines.push_back(texts_("app.more_rows", {{"count", std::to_string(hidden)}}));
        }
        lines.push_back(statistics());
        print(panel_.draw(size, lines));
    }

    [[nodiscard]] std::string statistics() const {
        const auto shown = [this](Duration time) {
            return time_.count() == 0 ? std::string("–") : report::milliseconds_text(time);
        };
        return texts_("app.watch.statistics", {{"samples", std::to_string(samples_)},
                                               {"answers", std::to_string(time_.count())},
                                               {"errors", std::to_string(errors_)},
                                               {"min", shown(time_.min())},
                                               {"mean", shown(time_.mean())},
                                               {"max", shown(time_.max())}});
    }

    void finish() const {
        if (options_.json) {
            const auto milliseconds = [this](Duration time) {
                return time_.count() == 0 ? file::Json()
                                          : file::Json(static_cast<double>(time.count()) / 1e6);
            };
            auto object = file::Json::object();
            object.set("event", "summary");
            object.set("samples", samples_);
            object.set("answers", time_.count());
            object.set("errors", errors_);
            object.set("min_ms", milliseconds(time_.min()));
            object.set("mean_ms", milliseconds(time_.mean()));
            object.set("max_ms", milliseconds(time_.max()));
            print(object.dump() + "\n");
        } else if (!terminal_) {
            print_status(statistics() + '\n');
        }
    }

    Texts texts_;
    const ReadOptions& options_;
    model::Project project_;
    plan::Plan plan_;
    std::vector<Watched> values_;
    bool terminal_;
    std::unique_ptr<Client> client_;
    Instant start_;
    std::uint64_t samples_ = 0;
    std::uint64_t errors_ = 0;
    bus::TimeStatistics time_;
    ExitCode last_code_ = ExitCode::timed_out;
    report::Panel panel_;
};

}  // namespace

ExitCode watch(const CommonOptions& common, const ReadOptions& options) {
    const Texts texts(common.language);
    auto project = watch_project(options);
    if (!project) return bad_arguments(texts, project.error());
    return Watch(texts, options, *std::move(project)).run();
}

}  // namespace takt::app
