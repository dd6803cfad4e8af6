// The demo: a project inside the program (examples/demo.yaml), its line simulated at byte times, polled by
// the real master.
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include "commands/demo_project.hpp"
#include "commands/run_command.hpp"
#include "commands/run_project.hpp"
#include "output.hpp"
#include "takt/base/assert.hpp"
#include "takt/host/project_file.hpp"
#include "takt/os/open.hpp"
#include "takt/report/comparison_report.hpp"
#include "takt/report/plan_report.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

/// The pump answers that it has no such register: the last of its variables, which the project asks for all
/// the same.
void refuse_one_register(const model::Line& line, sim::Devices& devices) {
    const auto& pump = line.devices.back();
    const auto& missing = pump.variables.back();
    // A changed project may have other devices.
    if (auto* const device = devices.find(pump.address))
        device->behaviour.refusals.push_back(
            {missing.area, {missing.start(), missing.start()}, wire::ExceptionCode::illegal_data_address});
}

/// A copy of the project that the page may change, in a folder that exists as long as the demo.
class DemoFolder {
public:
    [[nodiscard]] static Result<DemoFolder> create() {
        std::error_code error;
        const auto path = std::filesystem::temp_directory_path(error) / "takt-demo-XXXXXX";
        std::string name = path.string();
        if (error || ::mkdtemp(name.data()) == nullptr) return fail(Code::cannot_open, name, errno);
        DemoFolder folder(name);
        TAKT_TRY(const auto file, os::create_file(folder.file()));
        if (!os::write_all(file.get(), kDemoProject)) return fail(Code::io_failed, folder.file(), errno);
        return folder;
    }
    ~DemoFolder() {
        std::error_code ignored;
        if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
    }
    DemoFolder(DemoFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
    DemoFolder& operator=(DemoFolder&&) = delete;

    [[nodiscard]] std::string file() const { return path_ + "/demo.yaml"; }

private:
    explicit DemoFolder(std::string path) : path_(std::move(path)) {}
    std::string path_;
};

}  // namespace

ExitCode demo(const CommonOptions& common, const DemoOptions& options) {
    const Texts texts(common.language);
    const auto loaded = host::load_project_text("demo.yaml", std::string(kDemoProject));
    TAKT_ASSERT(!loaded.has_errors());
    const auto planned = host::prove(loaded, false, false).plan;
    if (!options.json) {
        const auto plan =
            report::plan_text(texts, loaded.project, planned, {}, {.columns = columns_of(STDOUT_FILENO)});
        print_wrapped(texts("app.demo.intro") + "\n\n" + plan + '\n');
        print(report::comparison_text(texts, loaded.project, planned, columns_of(STDOUT_FILENO)) + '\n');
    }
    RunOptions run;
    run.run_for = options.run_for;
    run.json = options.json;
    std::optional<DemoFolder> folder;
    if (options.web) {
        auto created = DemoFolder::create();
        if (!created) return ended_by(texts, created.error());
        folder.emplace(*std::move(created));
        run.file = folder->file();
        run.on_leave = [&folder] { folder.reset(); };
        run.web = {.address = line::ListenAddress{"127.0.0.1", 8502},
                   .or_free_port = true,
                   .allow_write = true,
                   .demo = true};
    }
    return run_project(texts, loaded.project, planned, run, [&](std::size_t line, sim::Devices& devices) {
        if (line < loaded.project.lines.size()) refuse_one_register(loaded.project.lines[line], devices);
    });
}

}  // namespace takt::app
