// listen.
#include "commands/listen_command.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/line/target.hpp"

namespace takt::app {
namespace {

constexpr const char* kListenPortForms =
    "/dev/ttyUSB0; rtu:///dev/ttyUSB0?baud=9600; ascii:///dev/ttyUSB0; FILE.pcapng";

// A port alone is no URL.
void check_serial_port(const std::string& port) {
    if (port.empty()) reject_word("PORT", port, kListenPortForms);
    if (port.find("://") == std::string::npos) return;
    check_target("PORT", port);
    if (line::parse_target(port)->transport != model::Transport::serial)
        reject_word("PORT", port, kListenPortForms);
}

}  // namespace

void add_listen(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ListenOptions>();
    auto listen = line.root().command("listen", "help.listen", [&] { return app::listen(common, options); });
    listen.value("PORT", options.port, "help.listen.port").required().check(check_serial_port);
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

}  // namespace takt::app
