// What takt listen prints and writes, for a port as for a capture.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "commands.hpp"
#include "progress.hpp"
#include "takt/capture/heard_exchange.hpp"
#include "takt/host/project_file.hpp"
#include "takt/report/times/listen_report.hpp"
#include "texts.hpp"

namespace takt::app {

/// Prints what a listener reports, then the summary; writes the project. One owner, one thread.
class ListenOutput final : public capture::ListenObserver {
public:
    /// @param time_text  the time of an instant, as it is printed
    ListenOutput(const Texts& texts, const ListenOptions& options, std::string port,
                 std::function<std::string(Instant)> time_text);

    /// Loads the project of the names, if there is one, and checks that the file for what is heard may be
    /// written. @returns false: the reason was printed
    [[nodiscard]] bool prepare();

    /// A line of a capture.
    struct CapturedLine {
        std::string name;
        report::HeardNames names;
    };
    /// The line with the names of the project's line of that name, if there is one.
    [[nodiscard]] CapturedLine line_of(const std::string& name) const;
    /// What is reported from now on is of that line, which must outlive the reports.
    /// @param several  the texts name the line
    void use_line(const CapturedLine& line, bool several);

    void on_exchange(const capture::Exchange& exchange) override;
    void on_stray(const capture::LineFrame& frame) override;
    void on_damaged(const capture::DamagedBytes& damaged) override;

    /// @param connection  the line without devices
    /// @param faulty_characters  that the port reported
    [[nodiscard]] ExitCode finish(const capture::LineStatistics& statistics, const model::Line& connection,
                                  bool has_settings, bool settings_given, std::uint64_t faulty_characters);
    /// The same for the lines of a capture: a summary for each, and the project of all.
    [[nodiscard]] ExitCode finish(std::span<const report::ListenRun> runs);
    /// No frame can be expected of the line.
    [[nodiscard]] ExitCode nothing_heard(std::uint64_t bytes) const;

    [[nodiscard]] Progress& progress() { return progress_; }

private:
    [[nodiscard]] bool may_write() const;
    void emit(const std::function<file::Json()>& json, const std::function<std::string()>& text);
    [[nodiscard]] std::string place_text(const std::string& time) const;
    void print_summary(const report::ListenRun& run) const;
    [[nodiscard]] std::string accepted_project(std::span<const report::ListenRun> runs) const;
    [[nodiscard]] ExitCode write_project(std::span<const report::ListenRun> runs) const;

    Texts texts_;
    const ListenOptions& options_;
    std::string port_;
    std::function<std::string(Instant)> time_text_;
    Progress progress_;
    std::optional<host::LoadedProject> project_;
    CapturedLine port_line_;  // of a port; without a name
    const CapturedLine* line_ = &port_line_;
    bool several_ = false;  // lines
};

/// `takt listen FILE`: the serial frames of a capture, of the first line that has some.
[[nodiscard]] ExitCode listen_to_capture(const Texts& texts, const ListenOptions& options);

}  // namespace takt::app
