#include "commands.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>

#include "offline/input_files.hpp"
#include "online/demo_plant.hpp"
#include "online/run_project.hpp"
#include "options/option_error.hpp"
#include "output.hpp"
#include "stop_signals.hpp"
#include "takt/file/read.hpp"
#include "takt/file/write.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/target.hpp"
#include "takt/plan/proof.hpp"
#include "takt/report/plans/table_report.hpp"
#include "takt/table/restore.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// A target as near as possible to another one that has the framing of the line of a table.
std::string fitting_target(const line::Target& target, const std::string& text, wire::Framing framing) {
    const auto rest = text.substr(text.find("://"));
    const bool serial = target.transport == model::Transport::serial;
    if (framing == wire::Framing::tcp) return serial ? "tcp://HOST:502" : "tcp" + rest;
    if (serial) return std::string(wire::name(framing)) + rest;
    return framing == wire::Framing::rtu ? "rtu+tcp" + rest : "ascii:///dev/ttyUSB0";
}

/// Puts the line of a table to another port or host. Its framing is the table's.
bool move_line(const Texts& texts, model::Project& project, const std::string& text) {
    if (project.lines.size() != 1) {
        print_error(texts("app.table.many_lines", {{"count", std::to_string(project.lines.size())}}));
        return false;
    }
    auto& line = project.lines[0];
    if (text.find("://") == std::string::npos && line.transport == model::Transport::serial) {
        line.port = text;
        return true;
    }
    const auto target = line::parse_target(text);
    if (!target) {
        print_error(option_error_text(texts, target_error("--port", text, target.error())));
        return false;
    }
    if (target->framing != line.framing) {
        print_error(texts("app.table.other_framing",
                          {{"target", text}, {"framing", std::string(wire::name(line.framing))}}));
        print_status("    " +
                     texts("app.table.other_framing.advice",
                           {{"fitting", fitting_target(*target, text, line.framing)}}) +
                     '\n');
        return false;
    }
    line.transport = target->transport;
    line.port = target->port;
    line.tcp_port = target->tcp_port;
    line.format = target->format;
    line.rs485 = target->rs485;
    return true;
}

ExitCode run_restored(const Texts& texts, table::Restored restored, const RunOptions& options) {
    if (!options.target.empty() && !move_line(texts, restored.project, options.target))
        return ExitCode::usage;
    RunOptions exact = options;
    exact.learn = false;
    return run_project(texts, restored.project, restored.plan, exact);
}

// The table of a controller has no port.
ExitCode run_owen_table(const Texts& texts, const RunOptions& options, Bytes image) {
    const auto opened = table::OwenView::open(image);
    const auto made = opened ? table::restored(*opened) : std::unexpected(opened.error());
    if (!made) {
        print_status("takt: " + report::table_error_text(texts, options.table, made.error()));
        return ExitCode::usage;
    }
    if (options.target.empty()) {
        print_error(texts("app.table.no_port", {{"file", options.table}}));
        print_status("    " + texts("app.table.no_port.advice", {{"file", options.table}}) + '\n');
        return ExitCode::usage;
    }
    return run_restored(texts, *made, options);
}

// The poller runs the plan that is in the table, so that nothing can differ from the project's own run; the
// executor is for controllers (docs/decisions/0008-what-runs-a-table.md).
ExitCode run_table(const Texts& texts, const RunOptions& options) {
    const auto file = read_table_file(texts, options.table);
    if (!file) return ExitCode::usage;
    if (file->owen) return run_owen_table(texts, options, file->image);
    const auto view = table::View::open(file->image);
    if (!view) {
        print_status("takt: " + report::table_error_text(texts, options.table, view.error()));
        return ExitCode::usage;
    }
    return run_restored(texts, {table::project_of(*view), table::plan_of(*view)}, options);
}

/// Where the page of a run is served, as it is written on the command line; empty: nowhere.
std::string page_address(const RunOptions& options) {
    const auto& address = options.web.address;
    return address ? model::host_and_port(address->host, address->port) : std::string();
}

std::string empty_project(const RunOptions& options) {
    const auto page = page_address(options);
    return "takt: 1\n"
           "# Lines and devices are added on the page (takt run FILE --web " +
           (page.empty() ? "127.0.0.1:8080" : page) +
           " --allow-write), or here.\n"
           "lines: []\n";
}

bool create_project(const Texts& texts, const RunOptions& options) {
    const auto& file = options.file;
    const auto written = file::write_file(file, empty_project(options), false);
    if (written) return true;
    const auto& error = written.error();
    const bool exists = error.code == Code::cannot_open && error.numbers[0] == EEXIST;
    print_error(exists ? texts("app.run.exists", {{"file", file}}) : texts.describe(error));
    return false;
}

// After a start that failed, as with a port in use: the next `--new` would refuse the file.
void remove_untouched_project(const RunOptions& options) {
    const auto empty = empty_project(options);
    if (const auto text = file::read_file(options.file, empty.size()); text && *text == empty)
        std::filesystem::remove(options.file);
}

std::optional<host::LoadedProject> load(const Texts& texts, const RunOptions& options, std::string& learnt) {
    if (options.create && !create_project(texts, options)) return std::nullopt;
    auto loaded = load_to_run(texts, options.file, &learnt, page_address(options));
    if (!loaded && !std::filesystem::exists(options.file))
        print_status(texts("app.run.create", {{"file", options.file}}) + '\n');
    return loaded;
}

}  // namespace

ExitCode run(const CommonOptions& common, const RunOptions& options) {
    hold_reload();
    const Texts texts(common.language);
    if (options.state.empty()) {
        RunOptions placed = options;
        placed.state = host::default_state_path(options.table.empty() ? options.file : options.table);
        return run(common, placed);
    }
    if (!options.table.empty()) return run_table(texts, options);
    std::string learnt;
    const auto loaded = load(texts, options, learnt);
    if (!loaded) return ExitCode::usage;
    const auto proof = host::prove(*loaded, false, false);
    const auto errors = std::count_if(proof.findings.begin(), proof.findings.end(), [](const auto& finding) {
        return finding.severity == model::Severity::error;
    });
    if (errors > 0) print_error(texts("app.run.infeasible", {{"count", std::to_string(errors)}}));
    RunOptions learning = options;
    learning.learnt = learnt;
    // The example of the demo shows the same plant here.
    DemoPlant plant(line::now());
    const auto& lines = loaded->project.lines;
    const auto show_plant = [&](std::size_t line, sim::Devices& devices) {
        if (line < lines.size() && DemoPlant::fits(lines[line])) plant.show(devices);
    };
    const ExitCode code = run_project(texts, loaded->project, proof.plan, learning, show_plant);
    if (options.create && code == ExitCode::cannot_open) remove_untouched_project(options);
    return code;
}

}  // namespace takt::app
