// takt table: from a project to its request table, and a look into one.
#include "commands.hpp"

#include <algorithm>
#include <string_view>

#include "offline/input_files.hpp"
#include "output.hpp"
#include "takt/model/service.hpp"
#include "takt/os/replace.hpp"
#include "takt/plan/learning.hpp"
#include "takt/plan/proof.hpp"
#include "takt/poll/line_poller.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/plans/table_report.hpp"
#include "takt/table/owen.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

ExitCode write_table_image(const Texts& texts, const std::string& path, const table::Image& image,
                           std::size_t entries, std::size_t items) {
    const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
    if (const auto done = os::replace_file(path, bytes, {}); !done) return ended_by(texts, done.error());
    print_status(texts("app.table.built", {{"file", path},
                                           {"bytes", std::to_string(image.size())},
                                           {"entries", std::to_string(entries)},
                                           {"items", std::to_string(items)}}) +
                 '\n');
    return ExitCode::ok;
}

ExitCode build_for_owen(const Texts& texts, host::LoadedProject& loaded, const plan::Plan& plan,
                        const std::string& path) {
    auto built = table::build_owen(loaded.project, plan);
    loaded.findings = std::move(built.findings);
    print_status(report::findings_text(texts, loaded));
    const auto errors =
        std::ranges::count(loaded.findings, model::Severity::error, &model::Finding::severity);
    if (errors == 0)
        return write_table_image(texts, path, table::write_owen(built.table), built.table.entries.size(),
                                 built.table.places);
    return ended_with(texts("app.table.refused", {{"file", path}, {"count", std::to_string(errors)}}),
                      ExitCode::no);
}

ExitCode build_own(const Texts& texts, const host::LoadedProject& loaded, const plan::Plan& plan,
                   const TableBuildOptions& options) {
    table::BuildOptions build{.names = !options.no_names};
    for (const auto& line : loaded.project.lines)
        build.lines.push_back(poll::line_config(loaded.project, line));
    const auto image = table::build(loaded.project, plan, build);
    if (const auto* const service = model::service_of_lines(loaded.project))
        return ended_with(
            texts("table.service", {{"name", service->name}}) + ". " + texts("table.service.advice"),
            ExitCode::no);
    if (!image) return ended_with(texts.describe(image.error()), ExitCode::no);
    const auto view = table::View::open(*image);
    return write_table_image(texts, options.output, *image, view->entry_count(), view->item_count());
}

template <class Table>
ExitCode show(const Texts& texts, const TableShowOptions& options, const Result<Table>& opened, Bytes image) {
    if (!opened) {
        print_status("takt: " + report::table_error_text(texts, options.file, opened.error()));
        return ExitCode::usage;
    }
    if constexpr (std::is_same_v<Table, table::View>)
        print(options.json ? report::table_json(*opened).dump() + '\n' : report::table_text(texts, *opened));
    else
        print(options.json ? report::table_json(*opened, image).dump() + '\n'
                           : report::table_text(texts, *opened, image));
    return ExitCode::ok;
}

}  // namespace

ExitCode table_build(const CommonOptions& common, const TableBuildOptions& options) {
    const Texts texts(common.language);
    auto loaded = host::load_project(options.file, options.profile);
    static_cast<void>(host::recall_learnt(loaded, options.file));
    print_status(report::findings_text(texts, loaded));
    if (!loaded.readable) return ExitCode::usage;
    if (loaded.has_errors()) return ExitCode::no;
    const auto project = plan::without_learning(loaded.project);  // a controller does not learn
    auto plan = plan::make_plan(project);
    plan::put_ages(plan, plan::guarantee(project, plan));
    if (options.profile == model::Profile::owen_kc1)
        return build_for_owen(texts, loaded, plan, options.output);
    return build_own(texts, loaded, plan, options);
}

ExitCode table_show(const CommonOptions& common, const TableShowOptions& options) {
    const Texts texts(common.language);
    const auto file = read_table_file(texts, options.file);
    if (!file) return ExitCode::usage;
    if (file->owen) return show(texts, options, table::read_owen(file->image), file->image);
    return show(texts, options, table::View::open(file->image), file->image);
}

}  // namespace takt::app
