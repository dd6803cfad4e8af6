// Findings about a project: codes with arguments and locations. Their texts are in module `text`.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/model/document.hpp"
#include "takt/model/project.hpp"

namespace takt::model {

/// A note reports what is not known or not limited; the project is as its author wants it. A warning reports
/// what will not work as written. With an error the project is not planned and not run.
enum class Severity : std::uint8_t { note, warning, error };

/// One finding. `code` is stable ("field.out_of_range"), the key of its message and, with ".advice", of its
/// advice.
struct Finding {
    Severity severity = Severity::error;
    std::string code;
    SourceLocation location;
    std::string path;     ///< "lines[0].devices[2].variables[1].register"
    std::string value;    ///< as in the file; empty if missing
    std::string allowed;  ///< "0..65535"; a list "rtu, ascii, tcp"; empty when not a range
    std::vector<std::pair<std::string, std::string>>
        arguments;  ///< further placeholders of the message: name, text
};

/// A project as far as it could be interpreted, with all findings. It may be planned and run if has_errors()
/// is false.
struct Checked {
    Project project;
    std::vector<Finding> findings;  ///< in order of file, line, column

    [[nodiscard]] bool has_errors() const;
};

/// Interprets a document and checks every rule of docs/specification.md, section 2: types and ranges of all
/// fields, unknown and missing keys, unique names and addresses, references to locals, matching areas and
/// functions, and the limits of the profile. Variables and devices beyond those limits are removed with a
/// warning, counted in the order of address, then of the file. Reports all findings at once and never throws.
/// At most 1000 findings; the last one then reports that there are more.
[[nodiscard]] Checked interpret(const Document& document);

/// Access rules in a file of their own.
struct CheckedAccess {
    std::vector<AccessRule> rules;
    std::vector<Finding> findings;
};

/// The rules of a document that is a list of them, like the key `access` of a server. Valid if no finding is
/// an error.
[[nodiscard]] CheckedAccess interpret_access(const Document& document);

/// All finding codes. Each has a message and, with ".advice", an advice in module `text`.
/// Placeholders of both: the finding's arguments, {value}, {allowed} and {path}.
[[nodiscard]] std::span<const std::string_view> finding_codes();

}  // namespace takt::model
