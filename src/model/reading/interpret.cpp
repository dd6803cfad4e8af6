// Interpretation in one pass over the document, in the order of dependencies: host and defaults, locals,
// lines with devices and variables, instruments, servers. Names of locals are known before the variables that
// use them. Bindings of servers find polled variables in an index that is made after the lines.
#include "servers/interpretation.hpp"

#include <algorithm>
#include <charconv>
#include <tuple>
#include <utility>

#include "takt/model/service.hpp"
#include "takt/model/target_url.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kDevicesOnASegment = 32;

std::string indexed(std::string_view key, std::size_t index) {
    return std::string(key) + "[" + std::to_string(index) + "]";
}

void read_version(Interpretation& state, Reader& reader) {
    const Node* const node = reader.scalar("takt");
    if (node == nullptr) return;
    const auto version =
        is_quoted(*node) ? std::unexpected(ScalarError::malformed) : parse_integer(node->text);
    if (version && (version->negative || version->magnitude != 1))
        reader.report(Rule::project_version, "takt",
                      allowed(*find_field(Object::project, "takt"), state.context));
    else
        reader.integer("takt");
}

void interpret_locals(Interpretation& state, Reader& reader) {
    const Node* const list = reader.list("locals");
    if (list == nullptr) return;
    state.local_type_known.resize(list->items.size());
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = indexed("locals", i);
        auto local = is_mapping(state, item, path) ? interpret_local(state, item, path) : Local{};
        state.project.locals.push_back(std::move(local));
    }
}

void interpret_lines(Interpretation& state, Reader& reader) {
    const Node* const list = reader.list("lines");
    if (list == nullptr) return;
    if (list->items.empty())
        reader.report(Rule::lines_none, "lines", {},
                      {{"file", state.describe({{}, ""})}, {"web", "127.0.0.1:8080"}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = indexed("lines", i);
        state.project.lines.push_back(is_mapping(state, item, path) ? interpret_line(state, item, path)
                                                                    : Line{});
    }
}

void note_polled(Interpretation& state) {
    for (auto& line : state.project.lines)
        for (auto& device : line.devices)
            for (auto& variable : device.variables) state.polled.try_emplace(variable.name, &variable);
}

void interpret_instruments(Interpretation& state, Reader& reader) {
    const Node* const list = reader.list("instruments");
    if (list == nullptr) return;
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = indexed("instruments", i);
        state.project.instruments.push_back(
            is_mapping(state, item, path) ? interpret_instrument(state, item, path) : Instrument{});
    }
}

void interpret_servers(Interpretation& state, Reader& reader) {
    const Node* const list = reader.list("servers");
    if (list == nullptr) return;
    if (list->items.empty()) reader.report(Rule::field_empty, "servers", {}, {{"key", "servers"}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        const auto path = indexed("servers", i);
        state.project.servers.push_back(is_mapping(state, item, path) ? interpret_server(state, item, path)
                                                                      : Server{});
    }
}

// Two values that share some of their registers, and not all: one of them is likely to have a wrong type or
// register. Bits of a register and a second scale of the same registers are usual.
void note_overlaps(Interpretation& state, const Device& device, const std::string& path) {
    std::vector<std::size_t> values;
    for (std::size_t v = 0; v < device.variables.size(); ++v)
        if (device.variables[v].read && device.variables[v].type != DataType::boolean) values.push_back(v);
    const auto place = [&](std::size_t v) {
        const auto& variable = device.variables[v];
        return std::tuple(variable.area, *variable.read, std::uint32_t{variable.start()}, variable.items());
    };
    std::ranges::sort(values, {}, place);
    for (std::size_t i = 1; i < values.size(); ++i) {
        const auto [area, read, start, items] = place(values[i - 1]);
        const auto [next_area, next_read, next_start, next_items] = place(values[i]);
        const bool same_kind = area == next_area && read == next_read;
        const bool equal = start == next_start && items == next_items;
        if (!same_kind || equal || next_start >= start + items) continue;
        const auto& second = device.variables[values[i]];
        state.findings.add(Rule::device_overlap, second.location, path, second.name, {},
                           {{"first", device.variables[values[i - 1]].name}, {"second", second.name}});
        return;
    }
}

void note_overlaps(Interpretation& state) {
    for (std::size_t l = 0; l < state.project.lines.size(); ++l)
        for (std::size_t d = 0; d < state.project.lines[l].devices.size(); ++d)
            note_overlaps(state, state.project.lines[l].devices[d],
                          indexed("lines", l) + "." + indexed("devices", d) + ".variables");
}

// Many devices accept one connection at a time, or few.
void note_shared_hosts(Interpretation& state) {
    const auto& lines = state.project.lines;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (!is_network(lines[i].transport) || lines[i].connection.per_host) continue;
        const auto same = [&](const Line& other) {
            return is_network(other.transport) && other.port == lines[i].port &&
                   other.tcp_port == lines[i].tcp_port;
        };
        const auto first = std::find_if(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(i), same);
        if (first != lines.begin() + static_cast<std::ptrdiff_t>(i))
            state.findings.add(Rule::line_host_shared, lines[i].location, indexed("lines", i) + ".host",
                               host_and_port(lines[i].port, lines[i].tcp_port), {}, {{"first", first->name}});
    }
}

void check_segments(Interpretation& state) {
    for (std::size_t i = 0; i < state.project.lines.size(); ++i) {
        const auto& line = state.project.lines[i];
        if (!line.is_serial() || line.devices.size() <= kDevicesOnASegment) continue;
        state.findings.add(Rule::line_many_devices, line.location, indexed("lines", i) + ".devices",
                           std::to_string(line.devices.size()), "1.." + std::to_string(kDevicesOnASegment),
                           {{"count", std::to_string(line.devices.size())}});
    }
}

void read_assumptions(Interpretation& state, Reader& reader) {
    auto& project = state.project;
    if (const Node* const node = reader.mapping("host")) {
        Reader host(state.findings, *node, reader.path_of("host"), Object::host, state.context);
        project.host.jitter = host.duration("jitter").value_or(project.host.jitter);
        project.host.overhead = host.duration("overhead").value_or(project.host.overhead);
    }
    if (const Node* const node = reader.mapping("faults")) {
        Reader faults(state.findings, *node, reader.path_of("faults"), Object::faults, state.context);
        project.faults_set = true;
        project.faults.burst =
            static_cast<std::uint16_t>(faults.integer("burst").value_or(project.faults.burst));
        project.faults.every = faults.duration("every").value_or(project.faults.every);
    }
    state.backoff_given = reader.given("backoff");
    project.backoff = read_backoff(state, reader, project.backoff).value_or(project.backoff);
}

void interpret_project(Interpretation& state) {
    Reader reader(state.findings, state.document.root, "", Object::project, state.context);
    auto& project = state.project;
    read_version(state, reader);
    project.profile = reader.choice<Profile>("profile").value_or(Profile::generic);
    state.context.profile = project.profile;
    project.derive_timeouts = reader.boolean("derive_timeouts").value_or(project.derive_timeouts);
    project.timeout_margin = reader.duration("timeout_margin").value_or(project.timeout_margin);
    read_assumptions(state, reader);
    interpret_locals(state, reader);
    if (!reader.given("lines") && !reader.given("servers") && !reader.misspelt("lines"))
        reader.report(reader.node().find("lines") != nullptr ? Rule::field_empty : Rule::field_missing,
                      "lines", {}, {{"key", "lines"}});
    interpret_lines(state, reader);
    interpret_instruments(state, reader);
    note_polled(state);
    interpret_servers(state, reader);
    use_services_of_outputs(state, reader);
    check_services(state);
    state.polled.clear();
    check_lines_without_devices(state);
    apply_profile(state);
    interpret_outputs(state, reader);
    check_segments(state);
    note_shared_hosts(state);
    if (!state.findings.any_error()) note_overlaps(state);  // a wrong register counts as 0
}

// "Line, Boiler, Level": the names of the items on a path, or their addresses.
std::string names_along(const Node& root, std::string_view path) {
    std::string names;
    const Node* node = &root;
    while (node != nullptr) {
        const auto open = path.find('[');
        if (open == std::string_view::npos) break;
        const auto* const list = node->find(path.substr(0, open));
        std::size_t index = 0;
        const auto [end, error] = std::from_chars(path.data() + open + 1, path.data() + path.size(), index);
        if (list == nullptr || error != std::errc{} || index >= list->items.size()) break;
        node = &list->items[index];
        path.remove_prefix(std::min(path.size(), static_cast<std::size_t>(end - path.data()) + 2));  // "]."
        const auto* const name = node->find(node->find("name") != nullptr ? "name" : "address");
        if (name != nullptr) names += (names.empty() ? "" : ", ") + name->text;
    }
    return names;
}

}  // namespace

bool Checked::has_errors() const {
    return std::ranges::any_of(findings, [](const Finding& f) { return f.severity == Severity::error; });
}

Interpretation::FirstUse::FirstUse(const Reader& reader, std::string_view key)
    : FirstUse(reader.value(key)->location, reader.path_of(key)) {}

Interpretation::FirstUse::FirstUse(const SourceLocation& where, const std::string& field)
    : location(where), path(where.line == 0 ? field : std::string()) {}

std::string Interpretation::describe(const FirstUse& first) const {
    if (auto text = names_along(document.root, first.path); !text.empty()) return text;
    const auto& [file, line, column] = first.location;
    const auto name = file < document.files.size() ? document.files[file] : std::string();
    return line == 0 ? name : name + ":" + std::to_string(line);
}

bool is_mapping(Interpretation& state, const Node& item, const std::string& path) {
    if (item.kind == Node::Kind::mapping) return true;
    state.findings.add(Rule::field_not_a_mapping, item.location, path, item.text);
    return false;
}

std::string read_name(Interpretation& state, Reader& reader, Interpretation::FirstUses& taken) {
    auto name = reader.text("name");
    if (!name) return {};
    const auto [first, is_new] = taken.try_emplace(*name, reader, "name");
    if (&taken == &state.names && is_service_name(*name)) reader.report(Rule::name_reserved, "name");
    if (!is_new) reader.report(Rule::name_duplicate, "name", {}, {{"first", state.describe(first->second)}});
    return *std::move(name);
}

Checked interpret(const Document& document) {
    Interpretation state(document);
    state.project.files = document.files;
    const Node& root = document.root;
    if (root.kind == Node::Kind::null)
        state.findings.add(Rule::document_empty, root.location, "", "");
    else if (root.kind != Node::Kind::mapping)
        state.findings.add(Rule::document_not_a_project, root.location, "", root.text);
    else
        interpret_project(state);
    return {std::move(state.project), std::move(state.findings).take()};
}

}  // namespace takt::model
