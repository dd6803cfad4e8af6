// capture.
#include "commands/capture_command.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/line/target.hpp"

namespace takt::app {

namespace {

constexpr const char* kCaptureTargetForms =
    "rtu:///dev/ttyUSB0?baud=9600; ascii:///dev/ttyUSB0; --interface IF";

void check_serial_target(const std::string& url) {
    check_target("TARGET", url);
    if (line::parse_target(url)->transport != model::Transport::serial)
        reject_word("TARGET", url, kCaptureTargetForms);
}

}  // namespace

void add_capture_command(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<CaptureOptions>();
    auto capture =
        line.root().command("capture", "help.capture", [&] { return app::capture(common, options); });
    auto target = capture.value("TARGET", options.target, "help.capture.target");
    target.check(check_serial_target);
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
