// Endpoints seen from the command line: their notices as text, their rules from files.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "takt/app/texts.hpp"
#include "takt/endpoint/endpoint_set.hpp"
#include "takt/report/serve_report.hpp"

namespace takt::app {

/// Prints a notice on stderr, a warning behind "takt: ".
void print_notice(const Texts& texts, const endpoint::Notice& notice);
[[nodiscard]] endpoint::NoticeSink print_notices(const Texts& texts);

/// The rules of a file that is a list of them; its findings go to stderr.
/// @returns nothing: they cannot be used
[[nodiscard]] std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts,
                                                                        const std::string& path);

/// Reads the access rules of all endpoints again. If the file cannot be used, the old rules stay in force,
/// and stderr says why.
/// @param access_file   a list of rules for all endpoints; empty: those of the project's servers count
void reload_access(const Texts& texts, endpoint::EndpointSet& endpoints, const std::string& access_file,
                   const std::string& project_file);

/// What the endpoints counted, for the report at the end.
[[nodiscard]] report::ServeSummary summary_of(const endpoint::Statistics& statistics);

/// What was relayed to each line of a project: in words, or as JSON objects, a line each.
[[nodiscard]] std::string relayed_text(const Texts& texts, const model::Project& project,
                                       const endpoint::Statistics& statistics);
[[nodiscard]] std::string relayed_json(const model::Project& project, const endpoint::Statistics& statistics);

}  // namespace takt::app
