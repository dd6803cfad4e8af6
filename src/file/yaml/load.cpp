// Loading: read the file within limits, check its encoding, parse it, then replace each `variables: NAME` by
// the rows of that table, and each `device_template: NAME` by the keys of that template. Tables and templates
// are read relative to the file that names them. Limits on bytes and nodes are shared by all files.
#include "takt/file/load.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "tables/cell_words.hpp"
#include "tables/csv.hpp"
#include "tables/device_template.hpp"
#include "takt/file/edit.hpp"
#include "takt/file/read.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/notation.hpp"
#include "yaml/nodes.hpp"
#include "yaml/reporter.hpp"
#include "yaml/source.hpp"
#include "yaml/yaml.hpp"

namespace takt::file {
namespace {

using model::Node;
using model::SourceLocation;

constexpr std::string_view kMaxTableText = "64 MiB";
static_assert(kMaxFileBytes == 8 << 20 && kMaxTableBytes == 64 << 20);

std::string_view open_error_code(const Error& error) {
    if (error.code == Code::unsupported) return "file.not_regular";
    if (error.code == Code::too_long) return "file.too_large";
    if (error.code != Code::cannot_open) return "file.cannot_read";
    switch (error.numbers[0]) {
        case ENOENT:
        case ENOTDIR: return "file.not_found";
        case EACCES:
        case EPERM: return "file.no_permission";
        case EISDIR: return "file.is_directory";
        default: return "file.cannot_read";
    }
}

// Whether the file is a device template, which users may take for a project.
bool is_template(const Node& root) {
    return root.find("variables") != nullptr && root.find("lines") == nullptr &&
           root.find("servers") == nullptr && root.find("parameters") != nullptr;
}

// The interpretation reports an unknown word.
TableOptions table_options(const Node& owner) {
    const auto* const word = owner.find("notation");
    if (word == nullptr) return {};
    const auto at = std::ranges::find(model::kNotations, std::string_view(word->text));
    if (at == model::kNotations.end()) return {};
    return {.addresses = Addresses::reference,
            .notation = static_cast<Notation>(at - model::kNotations.begin())};
}

bool chooses_nothing(const Node& node) {
    return node.kind == Node::Kind::scalar && is_placeholder(node.text);
}

bool names_a_local(std::string_view key) {
    for (const auto object : {model::Object::variable, model::Object::device})
        if (const auto* const field = model::find_field(object, key))
            return field->kind == model::Kind::local_bool || field->kind == model::Kind::local_integer;
    return false;
}

bool is_function(std::string_view key) {
    const auto* const field = model::find_field(model::Object::variable, key);
    return field != nullptr && field->kind == model::Kind::function;
}

// The placeholder of a list of choices chooses nothing, as in tables: no local, no function, no variable.
void drop_placeholders(Node& node) {
    std::erase_if(node.items, [](const Node& item) {
        const auto* const name = item.find("name");
        return name != nullptr && chooses_nothing(*name) && item.find("type") != nullptr;
    });
    std::erase_if(node.entries, [](const Node::Entry& entry) {
        return names_a_local(entry.key.text) && chooses_nothing(entry.value);
    });
    for (auto& [key, value] : node.entries)
        if (is_function(key.text) && chooses_nothing(value)) value.text = "none";
    for (auto& item : node.items) drop_placeholders(item);
    for (auto& [key, value] : node.entries) drop_placeholders(value);
}

// Loads one project; its state is that of one call.
class Loader {
public:
    explicit Loader(Reader reader) : reader_(std::move(reader)) {}

    Loaded load_table(const std::string& name, const Result<std::string>& bytes,
                      const TableOptions& options) {
        loaded_.document.files = {"", name};
        if (bytes) {
            loaded_.document.root = read_csv_bytes(1, *bytes, options, budget_.nodes, reporter_).rows;
            loaded_.readable = loaded_.document.root.location.line > 0;
        } else {
            report(bytes.error(), {.file = 1}, name, {});
        }
        loaded_.findings = reporter_.take();
        return std::move(loaded_);
    }

    LoadedTables load_tables(const std::vector<std::pair<std::string, Result<std::string>>>& texts,
                             const TableOptions& options) {
        LoadedTables all;
        loaded_.document.files = {""};
        loaded_.readable = true;
        for (const auto& [name, bytes] : texts) {
            const auto file = static_cast<std::uint32_t>(loaded_.document.files.size());
            loaded_.document.files.push_back(name);
            auto& table = all.tables.emplace_back();
            if (bytes) {
                auto contents = read_csv_bytes(file, *bytes, options, budget_.nodes, reporter_);
                table = {std::move(contents.rows), contents.kind};
                loaded_.readable = loaded_.readable && table.rows.location.line > 0;
            } else {
                report(bytes.error(), {.file = file}, name, {});
                loaded_.readable = false;
            }
        }
        loaded_.findings = reporter_.take();
        all.loaded = std::move(loaded_);
        return all;
    }

    // The tables and templates that the text names are not read.
    Loaded load_alone(const std::string& name, const std::string& text) {
        loaded_.document.files.push_back(name);
        if (text.size() > kMaxFileBytes) {
            report(fail(Code::too_long, name).error(), {}, name, {});
        } else if (const auto source = check(0, text)) {
            if (auto root = read_yaml(*source, budget_.nodes, reporter_)) {
                loaded_.document.root = *std::move(root);
                loaded_.readable = true;
            }
        }
        loaded_.findings = reporter_.take();
        return std::move(loaded_);
    }

    Loaded load(const std::string& name, const Result<std::string>& text) {
        loaded_.document.files.push_back(name);
        if (!text) {
            report(text.error(), {}, name, {});
        } else if (const auto source = check(0, *text)) {
            if (auto root = read_yaml(*source, budget_.nodes, reporter_)) {
                complete(name, *std::move(root));
            }
        }
        loaded_.findings = reporter_.take();
        return std::move(loaded_);
    }

    Loaded load_root(const std::string& name, Node root) {
        loaded_.document.files.push_back(name);
        complete(name, std::move(root));
        loaded_.findings = reporter_.take();
        return std::move(loaded_);
    }

private:
    // Adds what the other files of the project contain.
    void complete(const std::string& name, Node root) {
        if (is_template(root)) return reporter_.error("file.template.alone", root.location);
        loaded_.document.root = std::move(root);
        loaded_.readable = true;
        drop_placeholders(loaded_.document.root);
        const auto folder = std::filesystem::path(name).parent_path();
        take_tables(folder);
        take_templates(folder);
    }

    void report(const Error& error, const SourceLocation& location, const std::string& name,
                const std::string& path) {
        const auto code = open_error_code(error);
        Details details{.value = name, .path = path};
        if (code == "file.too_large") details.allowed = kMaxFileText;
        if (code == "file.cannot_read")
            details.arguments.emplace_back(
                "detail", std::generic_category().message(static_cast<int>(error.numbers[0])));
        reporter_.error(code, location, std::move(details));
    }

    std::optional<Source> check(std::uint32_t file, const std::string& text) {
        Source source(file, text);
        const auto foreign = find_foreign(source.text());
        if (!foreign) return source;
        reporter_.error(foreign->utf8 ? "file.control_character" : "file.not_utf8",
                        source.location(foreign->offset), {.value = in_words(*foreign)});
        return std::nullopt;
    }

    void take_tables(const std::filesystem::path& folder) {
        auto* const locals = find_value(loaded_.document.root, "locals");
        if (locals != nullptr && locals->kind == Node::Kind::scalar)
            take_table(*locals, folder, {}, "locals");
        take_tables_of("lines", "devices", folder);
        take_tables_of("servers", "units", folder);
        add_locals();
    }

    void take_tables_of(const std::string& outer, const std::string& inner,
                        const std::filesystem::path& folder) {
        auto* owners = find_value(loaded_.document.root, outer);
        for (std::size_t i = 0; owners && i < owners->items.size(); ++i) {
            auto* parts = find_value(owners->items[i], inner);
            for (std::size_t j = 0; parts && j < parts->items.size(); ++j) {
                auto* variables = find_value(parts->items[j], "variables");
                if (variables && variables->kind == Node::Kind::scalar)
                    take_table(*variables, folder, table_options(parts->items[j]),
                               outer + "[" + std::to_string(i) + "]." + inner + "[" + std::to_string(j) +
                                   "].variables");
            }
        }
    }

    void take_templates(const std::filesystem::path& folder) {
        auto* const lines = find_value(loaded_.document.root, "lines");
        for (std::size_t i = 0; lines && i < lines->items.size(); ++i) {
            auto* const devices = find_value(lines->items[i], "devices");
            for (std::size_t j = 0; devices && j < devices->items.size(); ++j)
                take_template(devices->items[j], folder,
                              "lines[" + std::to_string(i) + "].devices[" + std::to_string(j) + "]");
        }
    }

    void take_template(Node& device, const std::filesystem::path& folder, const std::string& path) {
        const auto* const name = device.find("device_template");
        if (name == nullptr || name->kind != Node::Kind::scalar) return;
        const auto file = (folder / name->text).lexically_normal().string();
        const auto [found, added] = templates_.try_emplace(file);
        if (added) found->second = read_template(file, name->location, path + ".device_template");
        if (found->second) found->second->apply(device, path, budget_, reporter_);
        drop_template_keys(device);
    }

    std::optional<DeviceTemplate> read_template(const std::string& name, const SourceLocation& location,
                                                const std::string& path) {
        const auto text = reader_ ? reader_(name) : fail(Code::cannot_open, name, ENOENT);
        if (!text) {
            report(text.error(), location, name, path);
            return std::nullopt;
        }
        if (!take_bytes(text->size(), location, name, path)) return std::nullopt;
        const auto file = static_cast<std::uint32_t>(loaded_.document.files.size());
        loaded_.document.files.push_back(name);
        const auto source = check(file, *text);
        auto root = source ? read_yaml(*source, budget_.nodes, reporter_) : std::nullopt;
        if (!root) return std::nullopt;
        drop_placeholders(*root);
        auto* const variables = find_value(*root, "variables");
        if (variables != nullptr && variables->kind == Node::Kind::scalar)
            take_table(*variables, std::filesystem::path(name).parent_path(), table_options(*root),
                       "variables");
        return DeviceTemplate::create(*std::move(root), reporter_);
    }

    // Returns false, after a report, if the files of the project are too large together.
    bool take_bytes(std::size_t bytes, const SourceLocation& location, const std::string& name,
                    const std::string& path) {
        if (bytes > budget_.bytes) {
            reporter_.error("file.tables_too_large", location,
                            {.value = name, .allowed = std::string(kMaxTableText), .path = path});
            return false;
        }
        budget_.bytes -= bytes;
        return true;
    }

    // A table of locals given as `variables`: its rows become locals.
    void add_locals() {
        if (locals_.empty()) return;
        auto* list = find_value(loaded_.document.root, "locals");
        if (list == nullptr) {
            Node key;
            key.kind = Node::Kind::scalar;
            key.location = locals_.front().location;
            key.text = "locals";
            Node none;
            none.kind = Node::Kind::list;
            none.location = key.location;
            loaded_.document.root.entries.emplace_back(std::move(key), std::move(none));
            list = &loaded_.document.root.entries.back().value;
        }
        if (list->kind == Node::Kind::null) list->kind = Node::Kind::list;
        if (list->kind != Node::Kind::list) return;  // reported by the interpretation
        for (auto& row : locals_) list->items.push_back(std::move(row));
    }

    // Replaces the name in `variables` by the rows of that table; no rows if it cannot be read.
    void take_table(Node& variables, const std::filesystem::path& folder, const TableOptions& options,
                    const std::string& path) {
        const auto name = (folder / variables.text).lexically_normal().string();
        const auto location = variables.location;
        variables = {.kind = Node::Kind::list, .location = location};
        if (const auto [first, added] = tables_.emplace(name, location.line); !added) {
            reporter_.error(
                "file.table_twice", location,
                {.value = name, .path = path, .arguments = {{"first", std::to_string(first->second)}}});
            return;
        }
        const auto text = reader_ ? reader_(name) : fail(Code::cannot_open, name, ENOENT);
        if (!text) return report(text.error(), location, name, path);
        if (!take_bytes(text->size(), location, name, path)) return;
        const auto file = static_cast<std::uint32_t>(loaded_.document.files.size());
        loaded_.document.files.push_back(name);
        auto contents = read_csv_bytes(file, *text, options, budget_.nodes, reporter_);
        if (contents.kind == TableKind::devices)
            return reporter_.error("file.table_of_devices", location, {.value = name, .path = path});
        if (contents.kind == TableKind::locals && path != "locals") {
            std::ranges::move(contents.rows.items, std::back_inserter(locals_));
            contents.rows.items.clear();
        }
        // If the table cannot be read, the location of its name stays.
        if (contents.rows.location.line > 0) variables = std::move(contents.rows);
    }

    Reader reader_;
    Reporter reporter_;
    Loaded loaded_;
    Budget budget_{.nodes = kMaxNodes, .bytes = kMaxTableBytes};
    std::vector<Node> locals_;                                        // from tables in place of variables
    std::map<std::string, std::uint32_t> tables_;                     // by name: the line that names it
    std::map<std::string, std::optional<DeviceTemplate>> templates_;  // by name; nothing: cannot be used
};

}  // namespace

Reader file_reader() {
    return [](const std::string& name) { return read_file(name, kMaxFileBytes); };
}

Loaded load_project(const std::string& path) {
    const auto reader = file_reader();
    return Loader(reader).load(path, reader(path));
}

Loaded load_table_text(const std::string& name, const std::string& bytes, const TableOptions& options) {
    if (bytes.size() > kMaxFileBytes) return Loader({}).load_table(name, fail(Code::too_long, name), options);
    return Loader({}).load_table(name, bytes, options);
}

Loaded load_document(const std::string& name, model::Node root, const Reader& reader) {
    return Loader(reader).load_root(name, std::move(root));
}

Loaded read_project_text(const std::string& name, const std::string& text) {
    return Loader({}).load_alone(name, text);
}

LoadedTables load_tables(const std::vector<std::string>& paths, const TableOptions& options) {
    std::vector<std::pair<std::string, Result<std::string>>> texts;
    for (const auto& path : paths) texts.emplace_back(path, read_file(path, kMaxFileBytes));
    return Loader({}).load_tables(texts, options);
}

LoadedTables load_tables_text(const std::vector<std::pair<std::string, std::string>>& texts,
                              const TableOptions& options) {
    std::vector<std::pair<std::string, Result<std::string>>> all;
    for (const auto& [name, bytes] : texts)
        all.emplace_back(name, bytes.size() > kMaxFileBytes ? Result<std::string>(fail(Code::too_long, name))
                                                            : Result<std::string>(bytes));
    return Loader({}).load_tables(all, options);
}

Loaded load_text(const std::string& name, const std::string& text, const Reader& reader) {
    if (text.size() > kMaxFileBytes) return Loader(reader).load(name, fail(Code::too_long, name));
    return Loader(reader).load(name, text);
}

}  // namespace takt::file
