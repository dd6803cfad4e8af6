// The files that commands read. Their findings go to stderr.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "takt/host/project_file.hpp"
#include "takt/table/build.hpp"
#include "takt/table/view.hpp"
#include "texts.hpp"

namespace takt::app {

/// Loads a project that is to be run; nothing when there is an error in it.
/// @param learnt        nullptr, or becomes host::recall_learnt() of it
/// @param page_address  of the run, for the advice of an empty project; empty: that of the advice itself
[[nodiscard]] std::optional<host::LoadedProject> load_to_run(const Texts& texts, const std::string& path,
                                                             std::string* learnt = nullptr,
                                                             const std::string& page_address = {});

/// Logs warnings and errors: what the project does not do as written, such as variables beyond a limit.
void log_findings(const std::vector<model::Finding>& findings);

/// The rules of a file that is a list of them; nothing when they cannot be used.
[[nodiscard]] std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts,
                                                                        const std::string& path);

/// Reads the access rules of a project's servers again. If they cannot be used, the old ones stay in force.
/// @param put_in_force  returns false when the project lacks a server that runs
void reload_access(const Texts& texts, const std::string& project_file,
                   const std::function<bool(const model::Project&)>& put_in_force);

/// The bytes of a request table, and which of the two formats they claim to be.
struct TableFile {
    table::Image image;
    bool owen = false;
};
/// @returns nothing when it cannot be read
[[nodiscard]] std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path);

}  // namespace takt::app
