// takt latency TARGET: sends requests to a device, and reports the times of its responses.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "offline/latency_command.hpp"
#include "online/one_off.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "takt/client/load.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/states/client_report.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

constexpr Duration kDefaultTime = std::chrono::seconds(10);
constexpr Duration kProgressEvery = std::chrono::seconds(1);

client::LoadOptions load_options(const LatencyOptions& options, const wire::PreparedRequest& request) {
    const auto& given = options.load;
    client::LoadOptions load;
    load.target.target = options.source;
    load.target.unit = static_cast<std::uint8_t>(given.unit.value_or(1));
    load.target.timeout = options.timeout;
    load.request = request;
    load.connections = given.connections.value_or(1);
    load.in_flight = given.in_flight.value_or(1);
    load.rate = given.rate;
    load.time = given.run_for;
    load.count = given.requests;
    if (!given.run_for && !given.requests) load.time = kDefaultTime;
    load.same_content = given.same_content;
    return load;
}

class TargetLatency {
public:
    TargetLatency(const Texts& texts, const LatencyOptions& options, const wire::PreparedRequest& request)
        : texts_(texts),
          options_(options),
          load_options_(load_options(options, request)),
          report_({.grouping = {.client = false, .server = false},
                   .timeout = options.timeout,
                   .limit = options.limit,
                   .microsecond_buckets = options.histogram}) {}

    ExitCode run() {
        if (const auto begun = work_loop_.begin(); !begun) return ended_by(texts_, begun.error());
        const auto steps = begin_realtime(options_.load.realtime, work_loop_.loop());
        print_realtime(texts_, options_.load.realtime, steps, false);
        load_.emplace(work_loop_.loop(), load_options_, report_);
        if (const auto connected = load_->connect(); !connected) return refused(connected.error());
        Progress progress(texts_, line::now(), true,
                          {.silent_for = kProgressEvery, .line_every = kProgressEvery});
        const auto ended = load_->run([&](const client::LoadProgress& second) {
            progress.show(line::now(), done(second), step(second));
        });
        progress.clear();
        const auto printed = print();
        if (!ended) return ended_by(texts_, ended.error());
        if (printed != ExitCode::ok) return printed;
        return work_loop_.loop().stopped() ? ExitCode::partly : answer();
    }

private:
    ExitCode refused(const Error& error) const {
        if (error.code != Code::unsupported || error.numbers[0] == 0) return ended_by(texts_, error);
        const bool connections = error.subject.view() == "connections";
        return ended_with(
            texts_("app.latency.load.line", {{"option", connections ? "--connections" : "--in-flight"},
                                             {"value", std::to_string(error.numbers[0])},
                                             {"target", options_.source}}),
            ExitCode::usage);
    }

    [[nodiscard]] report::Done done(const client::LoadProgress& second) const {
        const auto nanoseconds = [](Duration time) { return static_cast<std::size_t>(time.count()); };
        if (load_options_.time)
            return {.done = nanoseconds(second.elapsed), .total = nanoseconds(*load_options_.time)};
        return {.done = second.sent, .total = load_options_.count.value_or(0)};
    }

    [[nodiscard]] std::string step(const client::LoadProgress& second) const {
        const auto language = texts_.language();
        return texts_("app.latency.load.progress",
                      {{"target", options_.source},
                       {"sent", report::grouped_number(second.sent, language)},
                       {"responses", report::grouped_number(second.responses, language)},
                       {"longest", fmt::format("{:.3f}", report::milliseconds(second.longest))}});
    }

    [[nodiscard]] ExitCode print() const {
        const auto& counts = load_->counts();
        return print_latency(
            texts_, options_,
            {.file = options_.source,
             .report = report_,
             .packets = {.first_ns = counts.begin_ns, .last_ns = counts.begin_ns + counts.elapsed.count()},
             .tcp = {},
             .serial = {},
             .load = report::LoadRun{load_options_, counts}});
    }

    [[nodiscard]] ExitCode answer() const {
        const auto& total = report_.total();
        const auto& counts = load_->counts();
        if (total.answered == 0)
            return ended_with(
                texts_("app.latency.load.unanswered",
                       {{"target", options_.source}, {"count", std::to_string(total.requests)}}),
                ExitCode::timed_out);
        const bool kept = !options_.limit || report::latency_verdict(report_).kept();
        const bool good = counts.wrong == 0 && counts.unexpected == 0 && counts.different == 0;
        return kept && good ? ExitCode::ok : ExitCode::no;
    }

    const Texts& texts_;
    const LatencyOptions& options_;
    client::LoadOptions load_options_;
    capture::LatencyReport report_;
    WorkLoop work_loop_;
    std::optional<client::Load> load_;
};

}  // namespace

ExitCode latency_of_target(const Texts& texts, const LatencyOptions& options) {
    const auto& given = options.load;
    const auto start = given.start.value_or(0);
    const auto quantity = given.quantity.value_or(1);
    if (is_beyond(texts, start, quantity)) return ExitCode::usage;
    const auto request = wire::prepare(wire::ReadRequest{
        wire::read_function(given.area.value_or(wire::Area::holding_register)),
        DataAddress{static_cast<std::uint16_t>(start)}, static_cast<std::uint16_t>(quantity)});
    if (!request) return ended_with(texts.describe(request.error()), ExitCode::usage);
    return TargetLatency(texts, options, *request).run();
}

}  // namespace takt::app
