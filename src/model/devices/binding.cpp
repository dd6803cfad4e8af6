// Bindings: the source and the sink of a variable of a server.
#include <algorithm>
#include <utility>

#include "devices/binding.hpp"
#include "takt/model/service.hpp"

namespace takt::model {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kMostArguments = 64;
constexpr std::size_t kMostArgumentBytes = 1000;
constexpr int kPeriodsBeforeStale = 3;
constexpr Duration kLeastAge = 1s;
constexpr Duration kAgeWithoutPeriod = 5s;

/// The key of a mapping that must have exactly one.
std::optional<std::string_view> only_key(Reader& outer, std::string_view key, const Reader& reader,
                                         Object object) {
    std::optional<std::string_view> found;
    std::size_t count = 0;
    for (const auto& field : fields(object))
        if (reader.given(field.key)) {
            found = field.key;
            ++count;
        }
    if (count == 1) return found;
    if (count > 1 || reader.node().entries.empty())
        outer.report(Rule::group_one_of, key, keys_of(object), {{"keys", keys_of(object)}});
    return std::nullopt;
}

/// The pattern of a file or a command, whose only placeholder is `value`.
TextTemplate read_value_pattern(Reader& reader, const Variable& variable) {
    const bool text = variable.type == DataType::string;
    auto whole = *parse_template(text ? "{value:text}" : "{value}");
    if (!reader.given("pattern")) return whole;
    auto read = read_template(reader, "pattern");
    if (!read) return whole;
    if (read->has("value")) return *std::move(read);
    reader.report(Rule::template_without, "pattern", "{value}", {{"name", "value"}});
    return whole;
}

Command read_command_fields(Reader& reader) {
    Command command;
    command.timeout = reader.duration("timeout").value_or(command.timeout);
    const Node* const list = reader.list("run");
    if (list == nullptr) return command;
    std::size_t bytes = 0;
    for (const auto& item : list->items) {
        bytes += item.text.size();
        if (item.kind != Node::Kind::scalar || item.text.find('\0') != std::string::npos) break;
        command.run.push_back(item.text);
    }
    const bool whole = command.run.size() == list->items.size();
    if (!whole || command.run.empty() || command.run[0].empty() || command.run.size() > kMostArguments ||
        bytes > kMostArgumentBytes) {
        reader.report(Rule::command_empty, "run");
        command.run.clear();
    }
    return command;
}

Source read_file(Interpretation& state, Reader& outer, const Node& node, const Variable& variable) {
    auto reader = inner(state, outer, "file", node, Object::file_source);
    FileSource file;
    file.path = reader.text("path").value_or("");
    file.every = reader.duration("every").value_or(file.every);
    file.pattern = read_value_pattern(reader, variable);
    return file;
}

Source read_command_source(Interpretation& state, Reader& outer, const Node& node, const Variable& variable) {
    auto reader = inner(state, outer, "command", node, Object::command_source);
    CommandSource source;
    source.command = read_command_fields(reader);
    source.every = reader.duration("every").value_or(source.every);
    source.pattern = read_value_pattern(reader, variable);
    return source;
}

Source read_replay(Interpretation& state, Reader& outer, const Node& node) {
    auto reader = inner(state, outer, "replay", node, Object::replay);
    Replay replay;
    replay.path = reader.text("file").value_or("");
    replay.column = reader.text("column").value_or("");
    replay.every = reader.duration("every").value_or(replay.every);
    replay.loop = reader.boolean("loop").value_or(true);
    return replay;
}

/// Numeric formats only.
bool check_numeric(Reader& reader, std::string_view key, const Variable& variable) {
    if (variable.type != DataType::string) return true;
    reader.report(Rule::source_type, key, {}, {{"type", std::string(name(variable.type))}});
    return false;
}

std::optional<Source> read_source_of(Interpretation& state, Reader& reader, std::string_view key,
                                     const Variable& variable, std::optional<Duration>& age) {
    if (key == "constant") {
        auto constant = read_constant(reader, key,
                                      {.type = variable.type,
                                       .most_bytes = variable.registers * std::size_t{2},
                                       .scale = variable.scale,
                                       .offset = variable.offset});
        if (!constant) return std::nullopt;
        return Source(*std::move(constant));
    }
    if ((key == "variable" || key == "local") && names_service(reader, key)) {
        auto service = read_service_name(state, reader, key, variable);
        if (!service) return std::nullopt;
        return Source(*std::move(service));
    }
    if (key == "variable") {
        const auto* const polled = read_polled(state, reader, variable);
        if (polled == nullptr) return std::nullopt;
        age = stale_after(polled->period);
        return VariableSource{polled->name};
    }
    if (key == "local") {
        auto local = read_local_name(state, reader, variable);
        if (!local) return std::nullopt;
        return Source(*std::move(local));
    }
    if (key == "instrument") {
        auto measurement = read_instrument_name(state, reader);
        if (!measurement) return std::nullopt;
        if (measurement->measurement.empty()) {  // its state: always of now
            if (!check_numeric(reader, key, variable)) return std::nullopt;
            return Source(*std::move(measurement));
        }
        const auto& instrument = state.project.instruments[measurement->instrument];
        age = instrument.is_asked() ? stale_after(instrument.every) + instrument.timeout : kAgeWithoutPeriod;
        return Source(*std::move(measurement));
    }
    const Node* const node = reader.mapping(key);
    if (node == nullptr) return std::nullopt;
    if (key == "file") {
        auto source = read_file(state, reader, *node, variable);
        age = stale_after(std::get<FileSource>(source).every);
        return source;
    }
    if (key == "command") {
        auto source = read_command_source(state, reader, *node, variable);
        const auto& command = std::get<CommandSource>(source);
        age = stale_after(command.every) + command.command.timeout;
        return source;
    }
    if (!check_numeric(reader, key, variable)) return std::nullopt;
    if (key == "replay") return read_replay(state, reader, *node);
    return read_generator(state, reader, key, *node);
}

std::optional<Sink> read_sink(Interpretation& state, Reader& outer, const Variable& variable) {
    const Node* const node = outer.mapping("writes_to");
    if (node == nullptr) return std::nullopt;
    auto reader = inner(state, outer, "writes_to", *node, Object::sink);
    const auto key = only_key(outer, "writes_to", reader, Object::sink);
    if (!key) return std::nullopt;
    if (*key == "command") {
        const Node* const run = reader.mapping("command");
        if (run == nullptr) return std::nullopt;
        auto command = inner(state, reader, "command", *run, Object::command);
        return read_command_fields(command);
    }
    if (names_service(reader, *key)) {
        reader.report(Rule::service_read_only, *key);
        return std::nullopt;
    }
    if (*key == "local") {
        auto local = read_local_name(state, reader, variable);
        if (!local) return std::nullopt;
        return Sink(*std::move(local));
    }
    if (*key == "instrument") {
        const auto command = read_instrument_command(state, reader, variable);
        return command ? std::optional<Sink>(*command) : std::nullopt;
    }
    auto* const polled = read_polled(state, reader, variable);
    if (polled == nullptr) return std::nullopt;
    if (polled->write) {
        polled->written_by_clients = true;
        return VariableSource{polled->name};
    }
    reader.report(Rule::source_not_writable, "variable", {}, {{"name", polled->name}});
    return std::nullopt;
}

}  // namespace

Duration stale_after(Duration every) {
    return every == Duration::zero() ? kAgeWithoutPeriod : std::max(kPeriodsBeforeStale * every, kLeastAge);
}

Reader inner(Interpretation& state, const Reader& outer, std::string_view key, const Node& node,
             Object object) {
    return Reader(state.findings, node, outer.path_of(key), object, state.context);
}

std::optional<TextTemplate> read_template(Reader& reader, std::string_view key) {
    const Node* const node = reader.scalar(key);
    if (node == nullptr) return std::nullopt;
    auto parsed = parse_template(node->text);
    if (parsed) return *std::move(parsed);
    reader.report(Rule::template_malformed, key, {}, {{"position", std::to_string(parsed.error().position)}});
    return std::nullopt;
}

std::optional<Binding> read_binding(Interpretation& state, Reader& reader, const Variable& variable) {
    Binding binding{.location = variable.location};
    std::optional<Duration> age;
    if (const Node* const node = reader.mapping("source")) {
        auto source = inner(state, reader, "source", *node, Object::source);
        if (const auto key = only_key(reader, "source", source, Object::source))
            binding.source = read_source_of(state, source, *key, variable, age);
    }
    binding.sink = read_sink(state, reader, variable);
    // A local has no access rights of its own: a client that may write the variable may write the local.
    if (!reader.given("writes_to") && binding.source)
        if (const auto* const local = std::get_if<LocalSource>(&*binding.source);
            local && !is_service_name(local->name))
            binding.sink = *local;
    const bool at_once = reader.choice<bool>("answer").value_or(false);
    if (reader.given("answer") && !reader.given("writes_to"))
        reader.report_without_effect("answer", "writes_to: none");
    binding.answer_at_once = at_once;
    const auto limit = reader.duration("max_age");
    const bool ages = age || (binding.source && std::holds_alternative<LocalSource>(*binding.source));
    if (limit && !ages && binding.source) reader.report_without_effect("max_age", "source");
    if (limit && !reader.given("source")) reader.report_without_effect("max_age", "source: none");
    if (ages) binding.max_age = limit ? limit : age;
    if (!binding.source && !binding.sink) return std::nullopt;
    return binding;
}

}  // namespace takt::model
