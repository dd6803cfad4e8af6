#include "requests/one_line.hpp"

#include <utility>

namespace takt::plan {

model::Project with_one_line(const model::Project& project, model::Line line) {
    model::Project made{.version = project.version,
                        .profile = project.profile,
                        .derive_timeouts = project.derive_timeouts,
                        .timeout_margin = project.timeout_margin,
                        .host = project.host,
                        .faults = project.faults,
                        .faults_set = project.faults_set,
                        .backoff = project.backoff,
                        .locals = project.locals,
                        .files = {}};
    made.lines.push_back(std::move(line));
    return made;
}

}  // namespace takt::plan
