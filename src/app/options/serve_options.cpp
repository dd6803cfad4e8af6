// serve: where, what clients may take, and faults.
#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"
#include "takt/line/target.hpp"

namespace takt::app {
namespace {

void add_listen_addresses(Command& serve, std::string& listen) {
    serve
        .text(
            "--listen",
            [&listen](const std::string& text) {
                if (!line::parse_listen(text))
                    reject({"app.option.form.listen", {{"option", "--listen"}, {"value", text}}});
                listen = text;
            },
            "help.serve.listen")
        .value_name("HOST:PORT");
}

void add_serve_limits(Command& serve, endpoint::LimitOverrides& limits) {
    constexpr int kMostConnections = 20'000;
    const auto add_count = [&](const std::string& name, std::optional<std::uint32_t>& limit,
                               const std::string& help) {
        serve.value(name, limit, help).range(1, kMostConnections);
    };
    const auto add_time = [&](const std::string& name, std::optional<Duration>& limit,
                              const std::string& help) {
        add_wait(serve, name, [&limit](Duration time) { limit = time; }, help);
    };
    add_count("--max-connections", limits.max_connections, "help.serve.max_connections");
    add_count("--max-per-peer", limits.max_per_peer, "help.serve.max_per_peer");
    add_time("--byte-timeout", limits.byte_timeout, "help.serve.byte_timeout");
    add_time("--frame-timeout", limits.frame_timeout, "help.serve.frame_timeout");
    add_time("--idle-timeout", limits.idle_timeout, "help.serve.idle_timeout");
    add_time("--write-timeout", limits.write_timeout, "help.serve.write_timeout");
}

void add_serve_faults(Command& serve, ServeOptions& options) {
    add_parsed(serve, "--fault", options.faults, sim::parse_fault, "FAULT", "app.option.form.fault",
               "help.serve.fault");
    serve.value("--control", options.control_path, "help.serve.control").value_name("PATH");
    serve.flag("--stdin", options.commands_from_stdin, "help.serve.stdin");
}

}  // namespace

void add_serve(CommandLine& line, const CommonOptions& common) {
    static const std::map<std::string, sim::Fill> kFills{
        {"zero", sim::Fill::zero}, {"ramp", sim::Fill::ramp}, {"random", sim::Fill::random}};
    auto& options = line.keep<ServeOptions>();
    auto serve = line.root().command("serve", "help.serve", [&] { return app::serve(common, options); });
    auto file = serve.value("FILE", options.file, "help.serve.file");
    serve.value("--line", options.line, "help.serve.line").value_name("NAME").needs(file);
    add_listen_addresses(serve, options.listen);
    serve.value("--port", options.port, "help.serve.port").value_name("PORT");
    serve.value("--unit", options.unit.value, "help.serve.unit")
        .range(0, 255)
        .default_text("1")
        .excludes(file);
    add_word(serve, "--fill", options.fill, kFills, "help.serve.fill").value_name("FILL");
    serve.flag("--strict", options.strict, "help.serve.strict");
    add_duration(serve, "--for", [&](Duration time) { options.run_for = time; }, "help.for");
    serve.value("--traffic", options.traffic, "help.traffic").value_name("FILE");
    add_capture(serve, options.capture);
    serve.flag("--json", options.json, "help.serve.json");
    add_serve_limits(serve, options.limits);
    serve.value("--access", options.access, "help.serve.access").value_name("FILE");
    serve.value("--audit", options.audit, "help.serve.audit").value_name("FILE");
    add_serve_faults(serve, options);
    add_realtime(serve, options.realtime);
}

}  // namespace takt::app
