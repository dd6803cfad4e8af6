// capture and listen.
#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/line/target.hpp"

namespace takt::app {
namespace {

constexpr const char* kListenPortForms =
    "/dev/ttyUSB0; rtu:///dev/ttyUSB0?baud=9600; ascii:///dev/ttyUSB0; FILE.pcapng";

constexpr const char* kCaptureTargetForms =
    "rtu:///dev/ttyUSB0?baud=9600; ascii:///dev/ttyUSB0; --interface IF";

void check_serial_target(const std::string& option, const std::string& url, const std::string& forms) {
    check_target(option, url);
    if (line::parse_target(url)->transport != model::Transport::serial) reject_word(option, url, forms);
}

}  // namespace

void add_listen(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ListenOptions>();
    auto listen = line.root().command("listen", "help.listen", [&] { return app::listen(common, options); });
    listen.value("PORT", options.port, "help.listen.port").required().check([](const std::string& port) {
        if (port.empty()) reject_word("PORT", port, kListenPortForms);
        if (port.find("://") != std::string::npos)  // a port alone is no URL
            check_serial_target("PORT", port, kListenPortForms);
    });
    listen.value("--project", options.project, "help.listen.project").value_name("FILE");
    listen.value("--write", options.write, "help.listen.write").value_name("FILE.yaml");
    listen.flag("--force", options.force, "help.scan.force");
    add_wait(listen, "--for", [&options](Duration time) { options.run_for = time; }, "help.listen.for");
    add_wait(
        listen, "--timeout", [&options](Duration time) { options.timeout = time; }, "help.listen.timeout")
        .default_text("1s");
    listen.flag("--quiet", options.quiet, "help.listen.quiet");
    listen.flag("--json", options.json, "help.listen.json");
}

void add_capture_command(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<CaptureOptions>();
    auto capture =
        line.root().command("capture", "help.capture", [&] { return app::capture(common, options); });
    auto target = capture.value("TARGET", options.target, "help.capture.target");
    target.check([](const std::string& url) { check_serial_target("TARGET", url, kCaptureTargetForms); });
    capture.value("--interface", options.interface, "help.latency.interface")
        .value_name("IF")
        .excludes(target);
    auto output = capture.value("-o,--output", options.file.path, "help.capture.output");
    output.required().value_name("FILE.pcapng");
    add_capture_files(capture, options.file, "--", output);
    add_duration(capture, "--for", [&](Duration time) { options.run_for = time; }, "help.for");
    capture.check([&options] {
        if (options.target.empty() == options.interface.empty())
            reject({"app.option.nothing_to_capture", {}});
    });
}

}  // namespace takt::app
