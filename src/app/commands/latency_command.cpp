// takt latency: the packets of a capture to the statistics of their exchanges.
#include "commands/latency_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "output.hpp"
#include "progress.hpp"
#include "stoppable_input.hpp"
#include "takt/capture/analysis.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/latency_report.hpp"
#include "takt/report/latency_svg.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// Requests without a response are given up after this time, or later with a longer time-out.
constexpr Duration kForget = std::chrono::seconds(60);

capture::TcpAnalyzerConfig tcp_config(const LatencyOptions& options) {
    capture::TcpAnalyzerConfig config;
    if (!options.ports.empty()) config.ports = options.ports;
    config.forget = std::max(kForget, 2 * options.timeout);
    return config;
}

class Latency {
public:
    Latency(const Texts& texts, const LatencyOptions& options)
        : texts_(texts),
          options_(options),
          report_({.grouping = options.grouping,
                   .timeout = options.timeout,
                   .limit = options.limit,
                   .microsecond_buckets = options.histogram}),
          analysis_(tcp_config(options), options.timeout, report_),
          reader_(analysis_) {}

    ExitCode run() {
        if (const auto read = read_all(); !read) return ended_by(texts_, read.error());
        analysis_.end();
        report_.end(analysis_.packets().last_ns);
        const bool is_capture = !reader_.error() || reader_.packets() > 0;
        if (reader_.error())
            print_error(report::capture_error_text(texts_, options_.capture, *reader_.error()));
        if (!is_capture) return ExitCode::usage;
        if (reader_.error()) print_status(texts_("app.latency.partly") + '\n');
        if (report_.total().requests == 0)
            print_error(texts_("app.latency.none", {{"file", options_.capture}}));
        const auto printed = print_report();
        if (printed != ExitCode::ok) return printed;
        return reader_.error() || StoppableInput::stopped() ? ExitCode::partly : answer();
    }

private:
    Result<void> read_all() {
        TAKT_TRY(auto input, StoppableInput::open(options_.capture));
        Progress progress(texts_, line::now());
        std::uint64_t bytes = 0;
        for (;;) {
            TAKT_TRY(const auto count, input.read(reader_.space()));
            if (count == 0) break;
            bytes += count;
            if (!reader_.filled(count)) return {};
            progress.show(line::now(), {.done = bytes, .total = input.size().value_or(0)}, step());
        }
        if (!StoppableInput::stopped()) reader_.end();
        return {};
    }

    [[nodiscard]] std::string step() const {
        const auto language = texts_.language();
        return texts_("app.latency.progress",
                      {{"file", options_.capture},
                       {"packets", report::grouped_number(reader_.packets(), language)},
                       {"requests", report::grouped_number(report_.total().requests, language)}});
    }

    [[nodiscard]] ExitCode print_report() const {
        const report::LatencyRun run{.file = std::filesystem::path(options_.capture).filename().string(),
                                     .report = report_,
                                     .packets = analysis_.packets(),
                                     .tcp = analysis_.tcp(),
                                     .serial = analysis_.serial()};
        if (options_.json)
            print(report::latency_json(texts_, run).dump() + '\n');
        else if (options_.csv)
            print(report::latency_csv(report_));
        else if (options_.histogram > 0)
            print(report::latency_histogram(report_));
        else if (options_.svg != "-")
            print(report::latency_text(texts_, run, columns_of(STDOUT_FILENO)));
        if (options_.svg.empty()) return ExitCode::ok;
        const auto picture = report::latency_svg(texts_, run);
        if (options_.svg == "-") {
            print_raw(picture);
        } else if (const auto written = file::write_file(options_.svg, picture, true); !written) {
            return ended_by(texts_, written.error());
        }
        return ExitCode::ok;
    }

    [[nodiscard]] ExitCode answer() const {
        if (report_.total().requests == 0) return ExitCode::no;
        return !options_.limit || report::latency_verdict(report_).kept() ? ExitCode::ok : ExitCode::no;
    }

    Texts texts_;
    const LatencyOptions& options_;
    capture::LatencyReport report_;
    capture::Analysis analysis_;
    capture::CaptureReader reader_;
};

}  // namespace

ExitCode latency(const CommonOptions& common, const LatencyOptions& options) {
    return Latency(Texts(common.language), options).run();
}

}  // namespace takt::app
