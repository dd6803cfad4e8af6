// demo, run and ctl.
#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/base/network.hpp"
#include "takt/line/target.hpp"
#include "takt/web/web_server.hpp"

namespace takt::app {
namespace {

constexpr std::uint16_t kWebPort = 8502;

/// --web: an address as line::parse_listen(), with another port where none is given.
void add_web(Command& command, WebOptions& web) {
    auto address = command.text(
        "--web",
        [&web](const std::string& text) {
            const auto read = line::parse_listen(text);
            if (!read) reject({"app.option.form.web", {{"option", "--web"}, {"value", text}}});
            web.address = *read;
            if (const auto colon = text.rfind(':'); colon == std::string::npos || text.back() == ']')
                web.address->port = kWebPort;
        },
        "help.run.web");
    address.value_name("HOST:PORT");
    command.flag("--allow-write", web.allow_write, "help.run.allow_write").needs(address);
    command.value("--web-token", web.token_file, "help.run.web_token").needs(address).value_name("FILE");
    add_parsed(command, "--web-name", web.names, web::parse_web_name, "NAME", "app.option.form.web_name",
               "help.run.web_name")
        .needs(address);
    add_parsed(command, "--web-proxy", web.proxies, parse_network, "ADDRESS", "app.option.form.web_proxy",
               "help.run.web_proxy")
        .needs(address);
}

void add_demo(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<DemoOptions>();
    auto demo = line.root().command("demo", "help.demo", [&] { return app::demo(common, options); });
    add_duration(demo, "--for", [&](Duration time) { options.run_for = time; }, "help.for");
    demo.flag("--json", options.json, "help.json.lines");
    demo.flag("!--no-web", options.web, "help.demo.no_web");
}

void add_run(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<RunOptions>();
    auto run = line.root().command("run", "help.run", [&] { return app::run(common, options); });
    auto file = run.value("FILE", options.file, "help.project");
    run.flag("--new", options.create, "help.run.new").needs(file);
    auto table = run.value("--table", options.table, "help.run.table").value_name("TABLE");
    table.excludes(file);
    run.value("--port", options.target, "help.run.port").needs(table).value_name("PORT");
    run.check([&] {
        if (options.file.empty() && options.table.empty()) reject({"app.option.nothing_to_run", {}});
    });
    add_duration(run, "--for", [&](Duration time) { options.run_for = time; }, "help.for");
    run.flag("--json", options.json, "help.json.lines");
    run.flag("--quiet", options.quiet, "help.run.quiet");
    run.value("--device", options.device, "help.run.device").value_name("NAME");
    run.value("--traffic", options.traffic, "help.traffic").value_name("FILE");
    add_capture(run, options.capture);
    run.flag("--stdin", options.commands_from_stdin, "help.run.stdin");
    run.value("--control", options.control_path, "help.run.control").value_name("PATH");
    run.value("--state", options.state, "help.run.state").value_name("FILE");
    add_realtime(run, options.realtime);
    add_web(run, options.web);
}

void add_ctl(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<CtlOptions>();
    auto ctl = line.root().command("ctl", "help.ctl", [&] { return app::ctl(common, options); });
    ctl.value("PATH", options.path, "help.ctl.path").required();
    ctl.value("COMMAND", options.words, "help.ctl.command").required();
    ctl.flag("--json", options.json, "help.json");
}

}  // namespace

void add_running_commands(CommandLine& line, const CommonOptions& common) {
    add_demo(line, common);
    add_run(line, common);
    add_ctl(line, common);
}

}  // namespace takt::app
