// The findings of a project as text and as JSON.
#pragma once

#include <span>
#include <string>

#include "takt/file/json.hpp"
#include "takt/host/project_file.hpp"
#include "takt/model/findings.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

/// One line for each finding in the form of a compiler, "FILE:LINE:COLUMN: SEVERITY: FIELD: MESSAGE", and its
/// advice, indented, on a second one.
/// @param files  the names of the files that the findings refer to by index
/// @param least  findings below it are left out
[[nodiscard]] std::string findings_text(const Texts& texts, std::span<const std::string> files,
                                        std::span<const model::Finding> findings,
                                        model::Severity least = model::Severity::note);

/// A list of objects: severity, code, file, line, column, path, value, allowed, message, advice.
[[nodiscard]] file::Json findings_json(const Texts& texts, std::span<const std::string> files,
                                       std::span<const model::Finding> findings);

/// The same for the findings of a file and its contents.
[[nodiscard]] std::string findings_text(const Texts& texts, const host::LoadedFile& loaded,
                                        model::Severity least = model::Severity::note);
[[nodiscard]] file::Json findings_json(const Texts& texts, const host::LoadedFile& loaded);

/// The object that `takt check --json` prints (docs/commands/check.md).
[[nodiscard]] file::Json check_json(const Texts& texts, const host::LoadedFile& loaded);
/// The same, of a project without errors also with the byte orders of its devices.
[[nodiscard]] file::Json check_json(const Texts& texts, const host::LoadedProject& loaded);

/// The line that ends `takt check`: how many errors and warnings the project has.
/// @param project_file  its name
[[nodiscard]] std::string findings_summary(const Texts& texts, const std::string& project_file,
                                           std::span<const model::Finding> findings);

}  // namespace takt::report
