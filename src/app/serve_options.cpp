// serve: where, what the blank device has, and what clients may take.
#include "blank_options.hpp"
#include "command_line.hpp"

namespace takt::app {
namespace {

/// An option that may be given several times, each value read by `parse`.
template <class T>
CLI::Option* add_parsed(CLI::App& command, const std::string& name, std::vector<T>& target,
                        std::optional<T> (*parse)(std::string_view), const std::string& form,
                        const std::string& help) {
    return command
        .add_option_function<std::vector<std::string>>(
            name,
            [=, &target](const std::vector<std::string>& texts) {
                for (const auto& text : texts) {
                    auto parsed = parse(text);
                    if (!parsed)
                        throw CLI::ValidationError(name, "'" + text + "' is not of the form " + form);
                    target.push_back(*std::move(parsed));
                }
            },
            help)
        ->allow_extra_args(false)
        ->type_name("VALUE");
}

void add_blank_device(CLI::App& serve, BlankSpec& blank) {
    add_parsed(serve, "--range", blank.ranges, parse_item_range, "holding:0..99, 0..65535 each",
               "help.serve.range");
    add_parsed(serve, "--read-only", blank.read_only, parse_item_range, "holding:90..99, 0..65535 each",
               "help.serve.read_only");
    add_parsed(serve, "--retain", blank.retain, parse_item_range, "holding:0..99, 0..65535 each",
               "help.serve.retain");
    add_parsed(serve, "--limit", blank.limits, parse_value_limits,
               "holding:0..9=-5..100, the least value first, both of int16 or of uint16", "help.serve.limit");
    serve.add_flag("--overlay", blank.overlay, "help.serve.overlay");
    add_parsed(serve, "--object", blank.objects, parse_object, "0=text, ids 0..255, texts up to 244 bytes",
               "help.serve.object");
    serve.add_option("--server-id", blank.server_id, "help.serve.server_id")
        ->check([](const std::string& text) {
            constexpr std::size_t kMost = 248;
            return text.size() <= kMost ? std::string()
                                        : "is longer than " + std::to_string(kMost) + " bytes";
        })
        ->type_name("TEXT");
    add_parsed(serve, "--file", blank.files, parse_file_records, "4:100, files 1..65535, records 1..10000",
               "help.serve.records");
    add_parsed(serve, "--fifo", blank.fifos, parse_fifo, "1246:440,4740, at most 31 values",
               "help.serve.fifo");
    serve.add_flag("--allow-restart", blank.may_restart, "help.serve.allow_restart");
    serve.add_flag("--allow-listen-only", blank.may_listen_only, "help.serve.allow_listen_only");
    serve.add_option("--exception-coils", blank.status_coils, "help.serve.exception_coils")
        ->check(CLI::Range(0, 65535))
        ->type_name("COIL");
}

void add_serve_limits(CLI::App& serve, endpoint::LimitOverrides& limits) {
    constexpr int kMostConnections = 20'000;
    const auto add_count = [&](const std::string& name, std::optional<std::uint32_t>& limit,
                               const std::string& help) {
        serve.add_option(name, limit, help)->check(CLI::Range(1, kMostConnections))->type_name("N");
    };
    const auto add_time = [&](const std::string& name, std::optional<Duration>& limit,
                              const std::string& help) {
        add_duration(
            serve, name,
            [&limit, name](Duration time) {
                if (time < std::chrono::milliseconds(1)) throw CLI::ValidationError(name, "the least is 1ms");
                limit = time;
            },
            help);
    };
    add_count("--max-connections", limits.max_connections, "help.serve.max_connections");
    add_count("--max-per-peer", limits.max_per_peer, "help.serve.max_per_peer");
    add_time("--frame-timeout", limits.frame_timeout, "help.serve.frame_timeout");
    add_time("--idle-timeout", limits.idle_timeout, "help.serve.idle_timeout");
    add_time("--write-timeout", limits.write_timeout, "help.serve.write_timeout");
}

void add_serve_state(CLI::App& serve, ServeOptions& options) {
    static const std::map<std::string, model::Durability> kDurabilities{
        {"ack", model::Durability::acknowledged},
        {"100ms", model::Durability::interval},
        {"none", model::Durability::at_end}};
    serve.add_option("--state", options.state, "help.serve.state")->type_name("FILE");
    add_word(serve, "--durability", options.durability, kDurabilities, "help.serve.durability")
        ->type_name("WHEN");
    serve.add_option("--access", options.access, "help.serve.access")->type_name("FILE");
    serve.add_option("--audit", options.audit, "help.serve.audit")->type_name("FILE");
}

void add_serve_faults(CLI::App& serve, ServeOptions& options) {
    add_parsed(
        serve, "--fault", options.faults, sim::parse_fault,
        "silence, delay=50ms..2s, exception=1..255, bad_crc, wrong_unit or cut, with :10% or @10s behind it",
        "help.serve.fault");
    serve.add_option("--control", options.control_path, "help.serve.control")->type_name("PATH");
}

}  // namespace

void add_serve(CLI::App& app, CommandLine& line) {
    static const std::map<std::string, sim::Fill> kFills{
        {"zero", sim::Fill::zero}, {"ramp", sim::Fill::ramp}, {"random", sim::Fill::random}};
    auto& serve =
        add_command(app, line, "serve", "help.serve", [&] { return app::serve(line.common, line.serve); });
    serve.add_option("file", line.serve.file, "help.serve.file")->type_name("FILE");
    serve.add_option("--listen", line.serve.listen, "help.serve.listen")->type_name("HOST:PORT");
    serve.add_option("--port", line.serve.port, "help.serve.port")->type_name("PORT");
    serve.add_option("--unit", line.serve.blank.unit.value, "help.serve.unit")
        ->check(CLI::Range(0, 255))
        ->default_str("1");
    add_word(serve, "--fill", line.serve.blank.fill, kFills, "help.serve.fill")->type_name("FILL");
    add_blank_device(serve, line.serve.blank);
    serve.add_flag("--strict", line.serve.strict, "help.serve.strict");
    add_duration(serve, "--for", [&](Duration time) { line.serve.run_for = time; }, "help.for");
    serve.add_option("--traffic", line.serve.traffic, "help.traffic")->type_name("FILE");
    serve.add_flag("--json", line.serve.json, "help.serve.json");
    add_serve_limits(serve, line.serve.limits);
    add_serve_state(serve, line.serve);
    add_serve_faults(serve, line.serve);
    // A project says itself what its devices and servers have.
    for (const auto* const name :
         {"--unit", "--fill", "--range", "--read-only", "--retain", "--limit", "--overlay", "--object",
          "--server-id", "--file", "--fifo", "--allow-restart", "--allow-listen-only", "--exception-coils",
          "--state", "--durability"})
        serve.get_option(name)->excludes("file");
}

}  // namespace takt::app
