// The findings of a project as one short text.
#pragma once

#include <string>
#include <string_view>

#include "flow.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {

/// "code leaf=value [allowed]" of each finding, a warning's code behind '?': leaf is the last key of the
/// path.
inline std::string findings_text(const Checked& checked) {
    std::string all;
    for (const auto& finding : checked.findings) {
        if (!all.empty()) all += "; ";
        if (finding.severity == Severity::warning) all += '?';
        all += finding.code + " " + finding.path.substr(finding.path.rfind('.') + 1) + "=" + finding.value;
        if (!finding.allowed.empty()) all += " [" + finding.allowed + "]";
    }
    return all;
}

inline std::string findings_text(const Changes& changes) {
    return findings_text(interpret(document(changes)));
}

struct Case {
    std::string_view keys;
    std::string_view expected;
};

}  // namespace takt::model::test
