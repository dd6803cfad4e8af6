#include <sstream>
#include <utility>
#include <vector>

#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/command_line.hpp"
#include "parsed.hpp"

namespace takt::app {
namespace {

std::any g_options;  // of the command that ran last

template <class Options>
ExitCode keep(const Options& options) {
    g_options = options;
    return ExitCode::ok;
}

}  // namespace

ExitCode check(const CommonOptions&, const CheckOptions& options) {
    return keep(options);
}
ExitCode convert(const CommonOptions&, const ConvertOptions& options) {
    return keep(options);
}
ExitCode ctl(const CommonOptions&, const CtlOptions& options) {
    return keep(options);
}
ExitCode demo(const CommonOptions&, const DemoOptions& options) {
    return keep(options);
}
ExitCode history(const CommonOptions&, const HistoryOptions& options) {
    return keep(options);
}
ExitCode capture(const CommonOptions&, const CaptureOptions& options) {
    return keep(options);
}
ExitCode latency(const CommonOptions&, const LatencyOptions& options) {
    return keep(options);
}
ExitCode listen(const CommonOptions&, const ListenOptions& options) {
    return keep(options);
}
ExitCode plan(const CommonOptions&, const PlanOptions& options) {
    return keep(options);
}
ExitCode probe(const CommonOptions&, const ProbeOptions& options) {
    return keep(options);
}
ExitCode raw(const CommonOptions&, const RawOptions& options) {
    return keep(options);
}
ExitCode read(const CommonOptions&, const ReadOptions& options) {
    return keep(options);
}
ExitCode replay(const CommonOptions&, const ReplayOptions& options) {
    return keep(options);
}
ExitCode run(const CommonOptions&, const RunOptions& options) {
    return keep(options);
}
ExitCode scan(const CommonOptions&, const ScanOptions& options) {
    return keep(options);
}
ExitCode schema(const CommonOptions& options) {
    return keep(options);
}
ExitCode selftest(const CommonOptions&, const SelftestOptions& options) {
    return keep(options);
}
ExitCode serve(const CommonOptions&, const ServeOptions& options) {
    return keep(options);
}
ExitCode table_build(const CommonOptions&, const TableBuildOptions& options) {
    return keep(options);
}
ExitCode table_show(const CommonOptions&, const TableShowOptions& options) {
    return keep(options);
}
ExitCode write(const CommonOptions&, const WriteOptions& options) {
    return keep(options);
}

namespace test {

Parsed parse(const std::string& line) {
    std::vector<std::string> words{"takt"};
    std::istringstream stream(line);
    for (std::string word; stream >> word;) words.push_back(word == "''" ? "" : word);
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());

    CommandLine command_line("help.takt", "takt", "takt 1.2.3");
    const CommonOptions common;
    add_running_commands(command_line, common);
    add_serve(command_line, common);
    add_project_commands(command_line, common);
    add_convert(command_line, common);
    add_table_commands(command_line, common);
    add_history(command_line, common);
    add_latency(command_line, common);
    add_capture_command(command_line, common);
    add_listen(command_line, common);
    add_client_commands(command_line, common);
    add_finding_commands(command_line, common);
    g_options.reset();
    auto parsed = command_line.parse(with_intervals(static_cast<int>(arguments.size()), arguments.data()),
                                     [] { return Texts(text::Language::english); });
    if (parsed.asked == CommandLine::Asked::text) return {{}, {}, std::move(parsed.text)};
    if (parsed.asked == CommandLine::Asked::nothing_valid)
        return {{}, std::move(parsed.error), std::move(parsed.text)};
    EXPECT_EQ(parsed.execute(), ExitCode::ok);
    return {std::exchange(g_options, {}), {}, {}};
}

}  // namespace test
}  // namespace takt::app
