#include "commands/listen_output.hpp"

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "commands/input_files.hpp"
#include "output.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/report/texts.hpp"

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
    names_ = report::HeardNames(project_->project, port_);
    if (!names_.has_line())
        print_error(texts_("app.listen.no_line", {{"file", options_.project}, {"port", port_}}));
    return names_.has_line();
}

void ListenOutput::use_line(const std::string& name) {
    if (project_) names_ = report::HeardNames(project_->project, port_, name);
}

void ListenOutput::emit(const std::function<file::Json()>& json, const std::function<std::string()>& text) {
    if (options_.quiet) return;
    progress_.clear();
    print((options_.json ? json().dump() : text()) + '\n');
}

void ListenOutput::on_exchange(const listen::Exchange& exchange) {
    const auto time = time_text_(exchange.request.begin);
    emit([&] { return report::exchange_json(names_, time, exchange); },
         [&] { return report::exchange_line(texts_, names_, time, exchange); });
}

void ListenOutput::on_stray(const listen::LineFrame& frame) {
    const auto time = time_text_(frame.begin);
    emit([&] { return report::stray_json(time, frame); },
         [&] { return report::stray_line(texts_, names_, time, frame); });
}

void ListenOutput::on_damaged(const listen::DamagedBytes& damaged) {
    const auto time = time_text_(damaged.begin);
    emit([&] { return report::damaged_json(time, damaged); },
         [&] { return report::damaged_line(texts_, time, damaged); });
}

ExitCode ListenOutput::finish(const listen::LineStatistics& statistics, const model::Line& connection,
                              bool has_settings, std::uint64_t faulty_characters) {
    const auto& counts = statistics.counts();
    const report::ListenRun run{.port = port_,
                                .connection = connection,
                                .has_settings = has_settings,
                                .statistics = statistics,
                                .names = names_,
                                .faulty_characters = faulty_characters};
    progress_.clear();
    if (options_.json)
        print(report::listen_json(run).dump() + '\n');
    else
        print((options_.quiet ? "" : "\n") + report::listen_summary(texts_, run, columns_of(STDOUT_FILENO)));
    const auto written = write_project(run);
    if (written != ExitCode::ok) return written;
    return counts.frames > 0 ? ExitCode::ok : nothing_heard(counts.damaged_bytes);
}

ExitCode ListenOutput::nothing_heard(std::uint64_t bytes) const {
    print_error(texts_(bytes > 0 ? "app.listen.no_frame" : "app.listen.nothing",
                       {{"port", port_}, {"bytes", std::to_string(bytes)}}));
    return bytes > 0 ? ExitCode::bad_frame : ExitCode::no;
}

// Takt plans with more time for a response than devices need. Where it cannot hold the periods that were
// heard, they are lengthened until `takt check` accepts the project.
std::string ListenOutput::accepted_project(const report::ListenRun& run) const {
    constexpr int kMostStretched = 64;
    for (int stretch = 1;; stretch *= 2) {
        auto text = report::listen_project(texts_, run, stretch);
        auto loaded = host::load_project_text(options_.write, text);
        if (!loaded.has_errors()) host::add_findings(loaded, host::prove(loaded, false, false));
        if (!loaded.has_errors() || stretch >= kMostStretched) return text;
    }
}

ExitCode ListenOutput::write_project(const report::ListenRun& run) const {
    if (options_.write.empty()) return ExitCode::ok;
    if (!listen::has_devices(run.statistics)) {
        print_status(texts_("app.listen.no_project", {{"file", options_.write}}) + '\n');
        return ExitCode::ok;
    }
    const auto written = file::write_file(options_.write, accepted_project(run), options_.force);
    if (!written) {
        print_error(report::unwritten_text(texts_, options_.write, written.error()));
        return ExitCode::partly;
    }
    print_status(texts_("app.scan.project_written", {{"file", options_.write}}) + '\n');
    return ExitCode::ok;
}

}  // namespace takt::app
