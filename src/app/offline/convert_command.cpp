#include "commands.hpp"

#include <cerrno>
#include <filesystem>
#include <utility>

#include "output.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/write.hpp"
#include "takt/host/project_file.hpp"
#include "takt/line/target.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/report/plans/findings_report.hpp"
#include "takt/report/plans/register_map.hpp"
#include "texts.hpp"

namespace takt::app {
namespace {

using Rows = std::vector<model::Node>;

/// The kind that an option names, else the one of the file name.
FileKind kind_of(FileKind named, const std::string& path, FileKind otherwise) {
    if (named != FileKind::by_ending) return named;
    const auto ending = std::filesystem::path(path).extension();
    if (ending == ".csv" || ending == ".CSV" || ending == ".txt" || ending == ".tsv") return FileKind::csv;
    if (ending == ".md") return FileKind::markdown;
    if (ending == ".yaml" || ending == ".yml") return FileKind::yaml;
    return otherwise;
}

// takt convert: one conversion. A step that fails has printed its error, sets `code_` and returns nothing.
class Conversion {
public:
    Conversion(const CommonOptions& common, const ConvertOptions& options)
        : texts_(common.language), options_(options) {}

    ExitCode run() {
        const auto from = kind_of(options_.from, input(), FileKind::by_ending);
        const auto other = from == FileKind::csv ? FileKind::yaml : FileKind::csv;
        const bool to_stdout = options_.output.empty();
        const auto to = kind_of(options_.to, options_.output, to_stdout ? other : FileKind::by_ending);
        for (const auto& other_input : options_.inputs)
            if (options_.inputs.size() > 1 &&
                (to != FileKind::yaml ||
                 kind_of(options_.from, other_input, FileKind::by_ending) != FileKind::csv))
                return refuse(texts_("app.convert.several"));
        const bool of_project = from == FileKind::yaml && to != FileKind::yaml;
        if ((options_.map && !of_project) || (!options_.map && to == FileKind::markdown))
            return refuse(texts_("app.convert.map"));
        if (from == FileKind::by_ending || to == FileKind::by_ending)
            return refuse(texts_("app.convert.which",
                                 {{"file", from == FileKind::by_ending ? input() : options_.output}}));
        if (from == FileKind::yaml && to == FileKind::yaml)
            return refuse(texts_("app.convert.yaml_to_yaml", {{"from", input()}}));
        if (from == FileKind::csv && options_.table_given)
            return refuse(texts_("app.convert.table_of_table"));
        if (options_.notation_given && options_.addresses_given &&
            options_.reading.addresses == file::Addresses::zero_based)
            return refuse(texts_("app.convert.notation_and_addresses"));
        const auto text = from == FileKind::csv ? from_table(to)
                          : options_.map        ? map_of_project(to)
                                                : from_project();
        return text ? put(*text) : code_;
    }

private:
    [[nodiscard]] const std::string& input() const { return options_.inputs.front(); }

    ExitCode refuse(const std::string& why) {
        print_error(why);
        return code_ = ExitCode::usage;
    }

    // Prints the findings. False: there is an error among them.
    bool accept(const host::LoadedProject& loaded) {
        print_status(report::findings_text(texts_, loaded));
        if (loaded.has_errors()) code_ = loaded.readable ? ExitCode::no : ExitCode::usage;
        return !loaded.has_errors();
    }

    std::optional<Rows> selected(Rows rows, const std::string& source) {
        if (options_.device.empty()) return rows;
        auto chosen = file::rows_of_device(rows, options_.device);
        if (!chosen.empty()) return chosen;
        std::string known;
        for (const auto& name : file::devices_of(rows)) known += (known.empty() ? "" : ", ") + name;
        refuse(texts_("app.convert.no_device",
                      {{"file", source}, {"device", options_.device}, {"known", known}}));
        return std::nullopt;
    }

    // Texts that are no targets are reported with their cells.
    void take_connections(const Rows& rows, file::Surroundings& around) const {
        for (const auto& row : rows)
            if (const auto* const cell = row.find(file::kTargetColumn))
                if (const auto target = line::parse_target(cell->text))
                    around.connections.try_emplace(cell->text, file::connection_keys(target->as_line()));
    }

    std::optional<file::Surroundings> surroundings(const Rows& rows) {
        const auto target = line::parse_target(options_.target);
        if (!target) {
            refuse(texts_.describe(target.error()));
            return std::nullopt;
        }
        file::Surroundings around;
        around.line = file::connection_keys(target->as_line());
        around.line.insert(around.line.begin(), {"name", options_.line});
        const auto stem = std::filesystem::path(input()).stem().string();
        auto address = std::to_string(options_.unit.value_or(1));
        const auto* const cell = rows.empty() ? nullptr : rows.front().find(file::kUnitAddressColumn);
        if (!options_.unit && cell != nullptr) address = cell->text;
        around.device = {{"name", options_.device.empty() ? stem : options_.device}, {"address", address}};
        return around;
    }

    std::optional<std::string> from_table(FileKind to) {
        auto reading = options_.reading;
        reading.devices = true;
        if (options_.notation_given && !options_.addresses_given)
            reading.addresses = file::Addresses::reference;
        if (to == FileKind::yaml) {
            if (!reading.encoding) reading.encoding = options_.encoding;
            if (reading.separator == 0) reading.separator = options_.separator;
        }
        auto tables = file::load_tables(options_.inputs, reading);
        auto& rows = tables.tables.front().rows.items;
        auto around = surroundings(of_device(rows));
        if (!around) return std::nullopt;
        for (const auto& table : tables.tables) take_connections(table.rows.items, *around);
        if (!options_.device.empty() && !file::devices_of(rows).empty()) {
            auto chosen = selected(rows, input());
            if (!chosen) return std::nullopt;
            rows = *std::move(chosen);
        }
        const auto kept = rows;
        const auto kind = tables.tables.front().kind;
        std::size_t owned = 0;  // variables in the rows of devices
        for (const auto& table : tables.tables)
            for (const auto& row : table.rows.items) {
                const auto* const variables = row.find("variables");
                if (variables != nullptr) owned += variables->items.size();
                if (table.kind != file::TableKind::devices) ++count_;
            }
        count_ += owned;
        auto project = project_of(std::move(tables), *around);
        project.document.files[0] = options_.output.empty() ? input() : options_.output;
        const auto document = project.document;
        if (!accept(host::interpreted(std::move(project)))) return std::nullopt;
        if (to == FileKind::csv && owned > 0) {
            refuse(texts_("app.convert.devices_in_table", {{"file", input()}}));
            return std::nullopt;
        }
        return to == FileKind::csv ? table_text(kept, kind, document) : project_text(document);
    }

    // One table of variables is the device that the options name.
    file::Loaded project_of(file::LoadedTables tables, const file::Surroundings& around) const {
        if (tables.tables.size() == 1 && (tables.tables.front().kind == file::TableKind::variables ||
                                          tables.tables.front().kind == file::TableKind::list)) {
            auto table = std::move(tables.loaded);
            table.document.root = std::move(tables.tables.front().rows);
            return file::project_of_table(std::move(table), around);
        }
        std::vector<std::string> titles;
        for (const auto& path : options_.inputs)
            titles.push_back(std::filesystem::path(path).stem().string());
        return file::project_of_tables(std::move(tables), around, titles);
    }

    // The rows from which the unit address of the one device may be taken.
    [[nodiscard]] Rows of_device(const Rows& rows) const {
        Rows found;
        for (const auto& row : rows) {
            const auto* const cell = row.find(file::kDeviceColumn);
            if (options_.device.empty() || (cell != nullptr && cell->text == options_.device)) {
                found.push_back(row);
                break;
            }
        }
        return found;
    }

    std::optional<std::string> from_project() {
        auto read = file::load_project(input());
        const auto document = read.document;
        if (!accept(host::interpreted(std::move(read)))) return std::nullopt;
        const auto rows = rows_of(document);
        if (!rows) return std::nullopt;
        count_ = rows->size();
        auto text = table_text(*rows, options_.table, document);
        if (text) print_status(texts_("app.convert.stays", {{"from", input()}}) + '\n');
        return text;
    }

    std::optional<std::string> map_of_project(FileKind to) {
        const auto loaded = host::load_project(input());
        if (!accept(loaded)) return std::nullopt;
        count_ = report::count_served(loaded.project);
        if (to == FileKind::markdown) return report::register_map_markdown(texts_, loaded.project);
        return report::register_map_csv(loaded.project, options_.separator == 0 ? ',' : options_.separator);
    }

    std::optional<Rows> rows_of(const model::Document& document) {
        if (options_.table == file::TableKind::locals) return file::rows_of_locals(document);
        if (options_.table == file::TableKind::served) return file::rows_of_servers(document);
        return selected(file::rows_of_project(document), input());
    }

    std::optional<std::string> table_text(const Rows& rows, file::TableKind kind,
                                          const model::Document& document) {
        auto format = options_.writing;
        format.kind = kind;
        format.encoding = options_.encoding.value_or(format.encoding);
        format.byte_order_mark = options_.byte_order_mark;
        if (options_.separator != 0) format.separator = options_.separator;
        auto written = file::write_table(rows, format);
        host::LoadedProject table;
        table.readable = true;
        table.files = document.files;
        table.findings = std::move(written.findings);
        if (!accept(table)) return std::nullopt;
        return std::move(written.bytes);
    }

    std::optional<std::string> project_text(const model::Document& document) {
        auto text = file::write_project(document.root);
        auto again = file::load_text(document.files[0], text);
        if (again.readable && again.findings.empty()) return text;
        accept(host::interpreted(std::move(again)));
        return std::nullopt;
    }

    ExitCode put(const std::string& text) {
        if (options_.output.empty()) {
            print_raw(text);
            return ExitCode::ok;
        }
        const auto written = file::write_file(options_.output, text, options_.force);
        if (!written) {
            print_error(report::unwritten_text(texts_, options_.output, written.error()));
            return written.error().code == Code::cannot_open && written.error().numbers[0] == EEXIST
                       ? ExitCode::usage
                       : exit_code(written.error());
        }
        print_status(texts_("app.converted",
                            {{"from", input()}, {"to", options_.output}, {"count", std::to_string(count_)}}) +
                     '\n');
        return ExitCode::ok;
    }

    Texts texts_;
    const ConvertOptions& options_;
    std::size_t count_ = 0;
    ExitCode code_ = ExitCode::ok;
};

}  // namespace

ExitCode convert(const CommonOptions& common, const ConvertOptions& options) {
    return Conversion(common, options).run();
}

}  // namespace takt::app
