// The demo: a project inside the program (examples/demo.yaml), its line simulated at byte times, polled by
// the real master.
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>

#include "commands.hpp"
#include "online/demo_plant.hpp"
#include "online/demo_project.hpp"
#include "online/run_project.hpp"
#include "output.hpp"
#include "takt/base/assert.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/loop.hpp"
#include "takt/os/open.hpp"
#include "takt/publish/project_outputs.hpp"
#include "takt/report/plans/comparison_report.hpp"
#include "takt/report/plans/plan_report.hpp"
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
    [[nodiscard]] static Result<DemoFolder> create(const std::string& project) {
        std::error_code error;
        const auto path = std::filesystem::temp_directory_path(error) / "takt-demo-XXXXXX";
        std::string name = path.string();
        if (error || ::mkdtemp(name.data()) == nullptr) return fail(Code::cannot_open, name, errno);
        DemoFolder folder(name);
        TAKT_TRY(const auto file, os::create_file(folder.file()));
        if (!os::write_all(file.get(), project)) return fail(Code::io_failed, folder.file(), errno);
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

/// The project, with a history where there is a folder for it.
std::string demo_text(bool history) {
    std::string text(kDemoProject);
    if (history) text += "outputs:\n  - {name: history, transport: history}\n";
    return text;
}

void print_intro(const Texts& texts, const host::LoadedProject& loaded, const plan::Plan& planned,
                 bool history) {
    const auto plan =
        report::plan_text(texts, loaded.project, planned, {}, {.columns = columns_of(STDOUT_FILENO)});
    auto intro = texts("app.demo.intro");
    if (history) intro = texts("app.demo.past") + '\n' + intro;
    print_wrapped(intro + "\n\n" + plan + '\n');
    print(report::comparison_text(texts, loaded.project, planned, columns_of(STDOUT_FILENO)) + '\n');
}

}  // namespace

ExitCode demo(const CommonOptions& common, const DemoOptions& options) {
    const Texts texts(common.language);
    const auto text = demo_text(options.web);
    const auto loaded = host::load_project_text("demo.yaml", text);
    TAKT_ASSERT(!loaded.has_errors());
    const auto planned = host::prove(loaded, false, false).plan;
    if (!options.json) print_intro(texts, loaded, planned, options.web);
    const auto start = line::now();
    DemoPlant plant(start);
    RunOptions run;
    run.run_for = options.run_for;
    run.json = options.json;
    std::optional<DemoFolder> folder;
    if (options.web) {
        auto created = DemoFolder::create(text);
        if (!created) return ended_by(texts, created.error());
        folder.emplace(*std::move(created));
        run.file = folder->file();
        const auto& line = loaded.project.lines.front();
        if (const auto past = write_demo_past(publish::history_database(run.file), line, plant, start); !past)
            return ended_by(texts, past.error());
        run.on_leave = [&folder] { folder.reset(); };
        run.web = {.address = line::ListenAddress{"127.0.0.1", 8502},
                   .or_free_port = true,
                   .allow_write = true,
                   .demo = true};
    }
    return run_project(texts, loaded.project, planned, run, [&](std::size_t line, sim::Devices& devices) {
        if (line >= loaded.project.lines.size()) return;
        refuse_one_register(loaded.project.lines[line], devices);
        plant.show(devices);
    });
}

}  // namespace takt::app
