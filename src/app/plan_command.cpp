#include <cerrno>
#include <cstdio>

#include "takt/app/commands.hpp"
#include "takt/app/comparison_report.hpp"
#include "takt/app/plan_report.hpp"
#include "takt/app/plan_svg.hpp"
#include "takt/app/project.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {
namespace {

Result<void> write_file(const std::string& path, const std::string& content) {
    std::FILE* const file = std::fopen(path.c_str(), "wb");
    if (!file) return fail(Code::cannot_open, path, errno);
    const bool written = std::fwrite(content.data(), 1, content.size(), file) == content.size();
    const int why = errno;
    if (std::fclose(file) != 0) return fail(Code::io_failed, path, errno);
    if (!written) return fail(Code::io_failed, path, why);
    return {};
}

std::string file_name(const std::string& path) {
    return path.substr(path.rfind('/') + 1);
}

}  // namespace

ExitCode plan(const CommonOptions& common, const PlanOptions& options) {
    const Texts texts(common.language);
    const auto loaded = load_project(options.file);
    const bool svg_only = options.svg == "-" && !options.json;
    const auto planned = loaded.has_errors() ? plan::Plan() : plan::make_plan(loaded.project);
    if (options.json) {
        auto object = file::Json::object();
        object.set("lines", plan_json(texts, loaded.project, planned, options.compare));
        object.set("findings", findings_json(texts, loaded));
        print(object.dump() + '\n');
    } else {
        talk(findings_text(texts, loaded));
        if (!loaded.has_errors() && !svg_only)
            print(options.compare ? comparison_text(texts, loaded.project, planned)
                                  : plan_text(texts, loaded.project, planned));
    }
    if (!loaded.readable) return ExitCode::usage;
    if (loaded.has_errors()) return ExitCode::no;
    if (options.svg.empty()) return ExitCode::ok;
    const std::string picture = plan_svg(texts, file_name(options.file), loaded.project, planned);
    if (svg_only) {
        print(picture);
    } else if (const auto written = write_file(options.svg, picture); !written) {
        texts.complain(texts.describe(written.error()));
        return exit_code(written.error());
    }
    return ExitCode::ok;
}

}  // namespace takt::app
