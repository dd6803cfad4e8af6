// The project file for editors: read, evaluated, compared, saved, applied.
// docs/project-file.md, "Editing in the browser".
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/host/project_file.hpp"
#include "takt/web/api.hpp"

namespace takt::web {

struct ProjectApiOptions {
    std::string file;  ///< of the project; empty: the program runs without one, and the routes answer 404
    /// Runs the project in place of the one that runs. Called on a thread of the server, one call at a time;
    /// it may take long. Empty: saved projects are not applied.
    std::function<Result<void>(host::LoadedProject)> apply;
};

/// GET /project, POST /project/evaluate, POST /project/diff, POST /project/take_over, PUT /project, GET
/// /fields, GET /schema, POST /import.
///
/// Threads: handlers run at the same time. An evaluation whose request is to stop ends early with 409
/// `superseded`.
class ProjectApi {
public:
    explicit ProjectApi(ProjectApiOptions options);
    ~ProjectApi();
    ProjectApi(const ProjectApi&) = delete;
    ProjectApi& operator=(const ProjectApi&) = delete;

    /// The routes refer to this object.
    [[nodiscard]] std::vector<ApiRoute> routes();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::web
