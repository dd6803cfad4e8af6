// read, write and raw.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {
namespace {

std::vector<std::string> split_all(const std::string& text, char separator) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0; begin <= text.size();) {
        const auto end = std::min(text.find(separator, begin), text.size());
        parts.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return parts;
}

std::optional<std::uint32_t> decimal_within(const std::string& digits, std::uint32_t least,
                                            std::uint32_t greatest) {
    const bool good =
        !digits.empty() && digits.size() <= 5 && digits.find_first_not_of("0123456789") == std::string::npos;
    const auto value = good ? std::stoul(digits) : 0;
    if (!good || value < least || value > greatest) return std::nullopt;
    return static_cast<std::uint32_t>(value);
}

/// AREA:START[:COUNT][:TYPE[:ORDER]]
client::WatchedRange watched_range(const std::string& text) {
    const auto wrong = [&] { reject({"app.option.form.watched", {{"option", "--also"}, {"value", text}}}); };
    const auto parts = split_all(text, ':');
    const auto area = kAreas.find(parts[0]);
    const auto start = parts.size() > 1 ? decimal_within(parts[1], 0, 65535) : std::nullopt;
    if (area == kAreas.end() || !start) wrong();
    client::WatchedRange range;
    range.area = area->second;
    range.start = static_cast<std::uint16_t>(*start);
    std::size_t next = 2;
    const auto count = next < parts.size() ? decimal_within(parts[next], 1, 65536) : std::nullopt;
    if (count) {
        range.count = *count;
        ++next;
    }
    if (next < parts.size()) {
        const auto type = type_words().find(parts[next]);
        if (type == type_words().end() || is_bit_area(range.area)) wrong();
        range.type = type->second;
        if (++next < parts.size()) range.order = order_of("--also", parts[next++]);
    }
    if (next < parts.size()) wrong();
    return range;
}

void add_watch(Command& read, ReadOptions& options) {
    auto watch = add_wait(
        read, "--watch",
        [&options](Duration interval) {
            options.watch = interval;
            options.reconnect = true;
        },
        "help.watch");
    watch.value_name("[INTERVAL]");
    add_duration(
        read, "--for", [&options](Duration time) { options.run_for = time; }, "help.watch.for")
        .needs(watch);
    read.flag("--changes", options.changes, "help.watch.changes").needs(watch);
    read.texts(
            "--also",
            [&options](const std::vector<std::string>& ranges) {
                for (const auto& range : ranges) options.also.push_back(watched_range(range));
            },
            "help.watch.also")
        .repeatable()
        .needs(watch)
        .value_name("AREA:START[:COUNT][:TYPE]");
}

void add_read(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<ReadOptions>();
    auto read = line.root().command("read", "help.read", [&] { return app::read(common, options); });
    add_client(read, options);
    auto& spec = options.spec;
    add_word(read, "AREA", spec.area, kAreas, "help.areas").required();
    read.value("START", spec.start, "help.start").required();
    read.value("COUNT", spec.count, "help.count").range(1, 65536).marks(options.count_given);
    add_type(read, spec.layout.type, {{"all", &options.all_types}, {"bool", &options.as_bool}},
             options.registers_only, "help.read.type");
    read.value("--length", spec.layout.registers, "help.length").range(1, 125);
    add_order(read, spec.layout.order);
    add_watch(read, options);
}

void add_write(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<WriteOptions>();
    auto write = line.root().command("write", "help.write", [&] { return app::write(common, options); });
    add_client(write, options);
    auto& spec = options.spec;
    add_word(write, "AREA", spec.area, kAreas, "help.areas.written").required();
    write.value("START", spec.start, "help.start").required();
    write.value("VALUE", spec.values, "help.values").required();
    add_type(write, spec.layout.type, {{"bool", &options.as_bool}}, options.registers_only, "help.type");
    add_order(write, spec.layout.order);
    write.flag("--multiple", spec.multiple, "help.multiple");
}

void add_raw(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<RawOptions>();
    auto raw = line.root().command("raw", "help.raw", [&] { return app::raw(common, options); });
    add_client(raw, options);
    raw.value("HEX", options.bytes, "help.raw.bytes").required();
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

void add_client_commands(CommandLine& line, const CommonOptions& common) {
    add_read(line, common);
    add_write(line, common);
    add_raw(line, common);
}

}  // namespace takt::app
