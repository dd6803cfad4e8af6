// Collects what is wrong with the files of a project.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/model/findings.hpp"

namespace takt::file {

/// What a finding may say besides its code and location.
struct Details {
    std::string value;
    std::string allowed;
    std::string path;
    std::vector<std::pair<std::string, std::string>> arguments;
};

class Reporter {
public:
    /// Adds an error; beyond kMaxFindings only the fact that there are more. Values are cut where they are
    /// long, control characters in them replaced.
    void error(std::string_view code, const model::SourceLocation& location, Details details = {});
    /// The same as a warning.
    void warning(std::string_view code, const model::SourceLocation& location, Details details = {});

    /// All of them, in the order of their places.
    [[nodiscard]] std::vector<model::Finding> take();

private:
    void add(model::Severity severity, std::string_view code, const model::SourceLocation& location,
             Details details);

    std::vector<model::Finding> findings_;
};

}  // namespace takt::file
