#include "offline/listen_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "offline/input_files.hpp"
#include "output.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::app {

ListenOutput::ListenOutput(const Texts& texts, const ListenOptions& options, std::string port,
                           std::function<std::string(Instant)> time_text)
    : texts_(texts),
      options_(options),
      port_(std::move(port)),
      time_text_(std::move(time_text)),
      progress_(texts, line::now()) {}

// Long listening must not end with a file that cannot be written.
bool ListenOutput::may_write() const {
    std::error_code ignored;
    if (options_.write.empty() || options_.force || !std::filesystem::exists(options_.write, ignored))
        return true;
    const auto exists = fail(Code::cannot_open, options_.write, EEXIST).error();
    print_error(report::unwritten_text(texts_, options_.write, exists));
    return false;
}

bool ListenOutput::prepare() {
    if (!may_write()) return false;
    if (options_.project.empty()) return true;
    project_ = load_to_run(texts_, options_.project);
    if (!project_) return false;
    port_line_ = line_of({});
    if (!port_line_.names.has_line())
        print_error(texts_("app.listen.no_line", {{"file", options_.project}, {"port", port_}}));
    return port_line_.names.has_line();
}

ListenOutput::CapturedLine ListenOutput::line_of(const std::string& name) const {
    if (!project_) return {name, {}};
    return {name, report::HeardNames(project_->project, port_, name)};
}

void ListenOutput::use_line(const CapturedLine& line, bool several) {
    line_ = &line;
    several_ = several;
}

std::string ListenOutput::place_text(const std::string& time) const {
    return several_ ? time + "  " + line_->name : time;
}

void ListenOutput::emit(const std::function<file::Json()>& json, const std::function<std::string()>& text) {
    if (options_.quiet) return;
    progress_.clear();
    if (!options_.json) return print(text() + '\n');
    auto object = json();
    if (!line_->name.empty()) object.set("line", line_->name);
    print(object.dump() + '\n');
}

void ListenOutput::on_exchange(const capture::Exchange& exchange) {
    const auto time = time_text_(exchange.request.begin);
    emit([&] { return report::exchange_json(line_->names, time, exchange); },
         [&] { return report::exchange_line(texts_, line_->names, place_text(time), exchange); });
}

void ListenOutput::on_stray(const capture::LineFrame& frame) {
    const auto time = time_text_(frame.begin);
    emit([&] { return report::stray_json(time, frame); },
         [&] { return report::stray_line(texts_, line_->names, place_text(time), frame); });
}

void ListenOutput::on_damaged(const capture::DamagedBytes& damaged) {
    const auto time = time_text_(damaged.begin);
    emit([&] { return report::damaged_json(time, damaged); },
         [&] { return report::damaged_line(texts_, place_text(time), damaged); });
}

ExitCode ListenOutput::finish(const capture::LineStatistics& statistics, const model::Line& connection,
                              bool has_settings, bool settings_given, std::uint64_t faulty_characters) {
    return finish(std::array{report::ListenRun{.port = port_,
                                               .connection = connection,
                                               .has_settings = has_settings,
                                               .settings_given = settings_given,
                                               .statistics = statistics,
                                               .names = port_line_.names,
                                               .faulty_characters = faulty_characters}});
}

ExitCode ListenOutput::finish(std::span<const report::ListenRun> runs) {
    progress_.clear();
    std::uint64_t frames = 0;
    std::uint64_t damaged_bytes = 0;
    for (const auto& run : runs) {
        print_summary(run);
        frames += run.statistics.counts().frames;
        damaged_bytes += run.statistics.counts().damaged_bytes;
    }
    const auto written = write_project(runs);
    if (written != ExitCode::ok) return written;
    return frames > 0 ? ExitCode::ok : nothing_heard(damaged_bytes);
}

void ListenOutput::print_summary(const report::ListenRun& run) const {
    if (options_.json) return print(report::listen_json(run).dump() + '\n');
    const bool apart = !options_.quiet || run.one_of_several;
    print((apart ? "\n" : "") + report::listen_summary(texts_, run, columns_of(STDOUT_FILENO)));
}

ExitCode ListenOutput::nothing_heard(std::uint64_t bytes) const {
    print_error(texts_(bytes > 0 ? "app.listen.no_frame" : "app.listen.nothing",
                       {{"port", port_}, {"bytes", std::to_string(bytes)}}));
    return bytes > 0 ? ExitCode::bad_frame : ExitCode::no;
}

// Takt plans with more time for a response than devices need. Where it cannot hold the periods that were
// heard, they are lengthened until `takt check` accepts the project.
std::string ListenOutput::accepted_project(std::span<const report::ListenRun> runs) const {
    constexpr int kMostStretched = 64;
    for (int stretch = 1;; stretch *= 2) {
        auto text = report::listen_project(texts_, runs, stretch);
        auto loaded = host::load_project_text(options_.write, text);
        if (!loaded.has_errors()) host::add_findings(loaded, host::prove(loaded, false, false));
        if (!loaded.has_errors() || stretch >= kMostStretched) return text;
    }
}

ExitCode ListenOutput::write_project(std::span<const report::ListenRun> runs) const {
    if (options_.write.empty()) return ExitCode::ok;
    if (std::ranges::none_of(runs,
                             [](const auto& run) { return capture::heard_devices(run.statistics) > 0; })) {
        print_status(texts_("app.listen.no_project", {{"file", options_.write}}) + '\n');
        return ExitCode::ok;
    }
    const auto written = file::write_file(options_.write, accepted_project(runs), options_.force);
    if (!written)
        return ended_with(report::unwritten_text(texts_, options_.write, written.error()), ExitCode::partly);
    print_status(texts_("app.scan.project_written", {{"file", options_.write}}) + '\n');
    return ExitCode::ok;
}

}  // namespace takt::app
