// takt latency: the packets of a capture to the statistics of their exchanges.
#include "offline/latency_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "offline/capture_input.hpp"
#include "offline/interface_packets.hpp"
#include "output.hpp"
#include "progress.hpp"
#include "stoppable_input.hpp"
#include "takt/capture/analysis.hpp"
#include "takt/capture/capture_reader.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/packet_socket.hpp"
#include "takt/report/times/latency_report.hpp"
#include "takt/report/times/latency_svg.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// Requests without a response are given up after this time, or later with a longer time-out.
constexpr Duration kForget = std::chrono::seconds(60);
constexpr Duration kShowInterval = std::chrono::milliseconds(200);

capture::TcpAnalyzerConfig tcp_config(const LatencyOptions& options) {
    capture::TcpAnalyzerConfig config;
    if (!options.ports.empty()) config.ports = options.ports;
    config.framing = options.framing;
    config.forget = std::max(kForget, 2 * options.timeout);
    return config;
}

class CaptureLatency {
public:
    CaptureLatency(const Texts& texts, const LatencyOptions& options)
        : texts_(texts),
          options_(options),
          report_({.grouping = options.grouping.value_or(capture::Grouping{}),
                   .timeout = options.timeout,
                   .limit = options.limit,
                   .microsecond_buckets = options.histogram}),
          analysis_(tcp_config(options), options.timeout, report_),
          reader_(analysis_) {}

    ExitCode run() {
        const bool live = !options_.interface.empty();
        if (const auto read = live ? listen() : read_all(); !read) return failed(read.error());
        analysis_.end();
        report_.end(std::max(end_ns_, analysis_.packets().last_ns));
        const bool is_capture = !reader_.error() || reader_.packets() > 0;
        if (reader_.error())
            print_error(report::capture_error_text(texts_, options_.source, *reader_.error()));
        if (!is_capture) return ExitCode::usage;
        if (reader_.error()) print_status(texts_("app.latency.partly") + '\n');
        if (report_.total().requests == 0)
            print_error(texts_(live ? "app.latency.none_live" : "app.latency.none", {{"file", name()}}));
        const auto printed = print_latency(texts_, options_,
                                           {.file = std::filesystem::path(name()).filename().string(),
                                            .report = report_,
                                            .packets = analysis_.packets(),
                                            .tcp = analysis_.tcp(),
                                            .serial = analysis_.serial()});
        if (printed != ExitCode::ok) return printed;
        const bool cut = !live && StoppableInput::stopped();
        return reader_.error() || cut ? ExitCode::partly : answer();
    }

private:
    Result<void> read_all() {
        Progress progress(texts_, line::now());
        TAKT_CHECK(read_capture(options_.source, reader_,
                                [&](const report::Done& done) { progress.show(line::now(), done, step()); }));
        analysis_.set_dropped(reader_.dropped());
        return {};
    }

    // A signal is the only end.
    Result<void> listen() {
        TAKT_TRY(auto socket, os::PacketSocket::open(options_.interface));
        Progress progress(texts_, line::now());
        const auto on_read = [&]() -> Result<bool> {
            progress.show(line::now(), {}, step());
            return true;
        };
        TAKT_CHECK(
            read_packets(texts_, options_.interface, socket, kShowInterval,
                         {.on_packet = [this](const auto& packet) { take(packet); }, .on_read = on_read}));
        analysis_.set_dropped(socket.dropped());
        const auto now = line::wall_clock(line::now()).time_since_epoch();
        end_ns_ = std::chrono::duration_cast<Duration>(now).count();
        return {};
    }

    void take(const os::ReceivedPacket& packet) {
        analysis_.on_packet({.number = ++packets_,
                             .time_ns = packet.time_ns,
                             .link = capture::LinkType::raw,
                             .original_length = static_cast<std::uint32_t>(packet.length),
                             .data = packet.data});
    }

    [[nodiscard]] ExitCode failed(const Error& error) const {
        if (error.code == Code::unsupported)
            return ended_with(texts_("app.latency.not_a_file", {{"file", name()}}), ExitCode::usage);
        const auto code = ended_by(texts_, error);
        if (error.code == Code::cannot_open && error.numbers[0] == EPERM && !options_.interface.empty())
            print_status("    " + texts_("app.latency.rights") + '\n');
        return code;
    }

    [[nodiscard]] std::string name() const {
        return options_.interface.empty() ? options_.source : options_.interface;
    }

    [[nodiscard]] std::string step() const {
        const auto language = texts_.language();
        return texts_("app.latency.progress",
                      {{"file", name()},
                       {"packets", report::grouped_number(analysis_.packets().packets, language)},
                       {"requests", report::grouped_number(report_.total().requests, language)}});
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
    std::uint64_t packets_ = 0;  // of an interface
    std::int64_t end_ns_ = 0;    // when listening ended; 0: with the last packet
};

}  // namespace

ExitCode latency(const CommonOptions& common, const LatencyOptions& options) {
    const Texts texts(common.language);
    return is_target(options.source) ? latency_of_target(texts, options)
                                     : CaptureLatency(texts, options).run();
}

ExitCode print_latency(const Texts& texts, const LatencyOptions& options, const report::LatencyRun& run) {
    if (options.json)
        print(report::latency_json(texts, run).dump() + '\n');
    else if (options.csv)
        print(report::latency_csv(run.report));
    else if (options.histogram > 0)
        print(report::latency_histogram(run.report));
    else if (options.svg != "-")
        print(report::latency_text(texts, run, columns_of(STDOUT_FILENO)));
    if (options.svg.empty()) return ExitCode::ok;
    const auto picture = report::latency_svg(texts, run);
    if (options.svg == "-") {
        print_raw(picture);
    } else if (const auto written = file::write_file(options.svg, picture, true); !written) {
        return ended_by(texts, written.error());
    }
    return ExitCode::ok;
}

}  // namespace takt::app
