// read, write and raw.
#include "command_line.hpp"

namespace takt::app {
namespace {

/// AREA:START[:COUNT]
WatchedRange watched_range(const std::string& text) {
    const auto wrong = [&] {
        return CLI::ValidationError("--also",
                                    "'" + text + "' is not known, allowed: AREA:START, AREA:START:COUNT");
    };
    const auto colon = text.find(':');
    const auto area = kAreas.find(text.substr(0, colon));
    if (area == kAreas.end() || colon == std::string::npos) throw wrong();
    const auto number = [&](const std::string& digits, std::uint64_t least, std::uint64_t greatest) {
        const bool good = !digits.empty() && digits.size() <= 5 &&
                          digits.find_first_not_of("0123456789") == std::string::npos;
        const auto value = good ? std::stoul(digits) : 0;
        if (!good || value < least || value > greatest) throw wrong();
        return value;
    };
    const auto second = text.find(':', colon + 1);
    WatchedRange range;
    range.area = area->second;
    range.start = static_cast<std::uint16_t>(number(text.substr(colon + 1, second - colon - 1), 0, 65535));
    if (second != std::string::npos)
        range.count = static_cast<std::uint32_t>(number(text.substr(second + 1), 1, 65536));
    return range;
}

void add_watch(CLI::App& read, ReadOptions& options) {
    auto* watch = add_duration(
        read, "--watch",
        [&options](Duration interval) {
            if (interval < std::chrono::milliseconds(1))
                throw CLI::ValidationError("--watch", "the least is 1ms");
            options.watch = interval;
            options.reconnect = true;
        },
        "help.watch");
    watch->type_name("[INTERVAL]");
    add_duration(
        read, "--for", [&options](Duration time) { options.run_for = time; }, "help.watch.for")
        ->needs(watch);
    read.add_flag("--changes", options.changes, "help.watch.changes")->needs(watch);
    read.add_option_function<std::vector<std::string>>(
            "--also",
            [&options](const std::vector<std::string>& ranges) {
                for (const auto& range : ranges) options.also.push_back(watched_range(range));
            },
            "help.watch.also")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->needs(watch)
        ->type_name("AREA:START[:COUNT]");
}

// A whole number is COUNT, a word with `://` the target, a word of areas AREA: they may all follow.
bool can_be_interval(const std::string& text) {
    if (text.empty() || text.starts_with('-') || kAreas.contains(text)) return false;
    return text.find_first_not_of("0123456789") != std::string::npos && text.find("://") == std::string::npos;
}

}  // namespace

std::vector<std::string> with_intervals(int argc, char** argv) {
    std::vector<std::string> arguments;
    for (int i = 1; i < argc; ++i) {
        arguments.emplace_back(argv[i]);
        if (arguments.back() != "--watch") continue;
        const std::string next = i + 1 < argc ? argv[i + 1] : "";
        const bool interval = can_be_interval(next);
        arguments.back() += '=' + (interval ? next : "1s");
        if (interval) ++i;
    }
    return arguments;
}

void add_client_commands(CLI::App& app, CommandLine& line) {
    auto& read =
        add_command(app, line, "read", "help.read", [&] { return app::read(line.common, line.read); });
    add_client(read, line.read);
    add_word(read, "area", line.read.area, kAreas, "help.areas")->required()->type_name("AREA");
    read.add_option("start", line.read.start, "help.start")->required()->type_name("START");
    read.add_option("count", line.read.count, "help.count")->check(CLI::Range(1, 65536))->type_name("COUNT");
    add_type(read, line.read.type, line.read.registers_only);
    read.add_option("--length", line.read.string_registers, "help.length")->check(CLI::Range(1, 125));
    add_order(read, line.read.order);
    add_watch(read, line.read);

    auto& write =
        add_command(app, line, "write", "help.write", [&] { return app::write(line.common, line.write); });
    add_client(write, line.write);
    add_word(write, "area", line.write.area, kAreas, "help.areas.written")->required()->type_name("AREA");
    write.add_option("start", line.write.start, "help.start")->required()->type_name("START");
    write.add_option("values", line.write.values, "help.values")->required()->type_name("VALUE");
    add_type(write, line.write.type, line.write.registers_only);
    add_order(write, line.write.order);
    write.add_flag("--multiple", line.write.multiple, "help.multiple");

    auto& raw = add_command(app, line, "raw", "help.raw", [&] { return app::raw(line.common, line.raw); });
    add_client(raw, line.raw);
    raw.add_option("bytes", line.raw.bytes, "help.raw.bytes")->required()->type_name("HEX");
}

}  // namespace takt::app
