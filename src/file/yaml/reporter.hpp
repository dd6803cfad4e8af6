// Collects the findings about the files of a project.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/model/findings.hpp"

namespace takt::file {

/// The optional parts of a finding.
struct Details {
    std::string value;
    std::string allowed;
    std::string path;
    std::vector<std::pair<std::string, std::string>> arguments;
};

class Reporter {
public:
    /// Adds an error. Beyond kMaxFindings only the fact that there are more is recorded. Long values are cut,
    /// control characters are replaced.
    void error(std::string_view code, const model::SourceLocation& location, Details details = {});
    /// The same as a warning.
    void warning(std::string_view code, const model::SourceLocation& location, Details details = {});

    /// All findings, ordered by location.
    [[nodiscard]] std::vector<model::Finding> take();

private:
    void add(model::Severity severity, std::string_view code, const model::SourceLocation& location,
             Details details);

    std::vector<model::Finding> findings_;
};

}  // namespace takt::file
