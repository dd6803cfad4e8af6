// The outputs of a project file as they are to run.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "takt/base/log.hpp"
#include "takt/base/result.hpp"
#include "takt/host/session.hpp"
#include "takt/publish/outputs.hpp"

namespace takt::publish {

struct ProjectOutputsOptions {
    std::string project_file;  ///< paths of the outputs are relative to its folder
    /// As ProjectHost::open_session(); called on the sampling thread.
    std::function<Result<std::unique_ptr<host::Session>>(const host::SessionOptions&)> open_session;
    std::function<Log(std::string_view category)> log;  ///< may be empty: silent
};

/// The setups of all outputs of a configuration, for Outputs. Reads the files with passwords; one that cannot
/// be read stops its output, whose samples wait in the journal.
[[nodiscard]] std::vector<OutputSetup> project_outputs(const ProjectOutputsOptions& options,
                                                       const host::ConfigurationPtr& configuration);

/// The folder of the journal of an output.
[[nodiscard]] std::string journal_folder(const std::string& project_file, const model::Output& output);

/// The history beside a project file: `plant.history.db` of `plant.yaml`.
[[nodiscard]] std::string history_database(const std::string& project_file);

}  // namespace takt::publish
