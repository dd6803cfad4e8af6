// What is wrong with a project: codes and arguments with their location; the texts live in room `text`.
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

enum class Severity : std::uint8_t { warning, error };

/// One finding. `code` is stable ("field.out_of_range"), the key of its message and, with ".advice", of its
/// advice.
struct Finding {
    Severity severity = Severity::error;
    std::string code;
    SourceLocation location;
    std::string path;     ///< "lines[0].devices[2].variables[1].register"
    std::string value;    ///< as it stands in the file; empty when missing
    std::string allowed;  ///< "0..65535"; a list "rtu, ascii, tcp"; empty when not a range
    std::vector<std::pair<std::string, std::string>>
        arguments;  ///< further placeholders of the message: name, text
};

/// A project as far as it could be understood, and everything found wrong with it.
/// The project may be planned and run when has_errors() is false.
struct Checked {
    Project project;
    std::vector<Finding> findings;  ///< in order of file, line, column

    [[nodiscard]] bool has_errors() const;
};

/// Interprets a document and checks every rule of the specification, section 2: the types and ranges of all
/// fields, unknown and missing keys, unique names and addresses, references to locals, fitting areas and
/// functions, the limits of the profile (what is beyond them is left out of the project with a warning,
/// counted in the order of address, then of the file). Reports all findings at once; never throws, never
/// stops at the first. At most 1000 findings, the last of which then says that there are more.
[[nodiscard]] Checked interpret(const Document& document);

/// Access rules in a file of their own.
struct CheckedAccess {
    std::vector<AccessRule> rules;
    std::vector<Finding> findings;
};

/// The rules of a document that is a list of them, as `access:` of a server is. They may be used when there
/// is no error among the findings.
[[nodiscard]] CheckedAccess interpret_access(const Document& document);

/// Every code a finding can have: each has a message and, with ".advice", an advice in room `text`.
/// Placeholders of both: the finding's arguments, {value}, {allowed} and {path}.
[[nodiscard]] std::span<const std::string_view> finding_codes();

}  // namespace takt::model
