// The servers of a running project, beside its polling.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "takt/app/running.hpp"
#include "takt/app/texts.hpp"
#include "takt/endpoint/endpoint_set.hpp"

namespace takt::app {

/// Opens `servers:` of a project that runs. The loop's thread only.
class ProjectServers {
public:
    /// @param loop, project, running, log  outlive it; the log may be nullptr
    /// @param file  of the project: the files of servers lie beside it
    ProjectServers(line::Loop& loop, const model::Project& project, const std::string& file, Running& running,
                   TrafficLog* log, const Texts& texts);
    ~ProjectServers();

    /// Prints where it answers. @returns as endpoint::EndpointSet::open()
    [[nodiscard]] Result<void> open() { return endpoints_.open(); }

    /// Reads the access rules of the project again; where they cannot be used, they stay what they are.
    void reload_access();

    /// Closes everything and writes what is left to be written. After open() only.
    void finish() { statistics_ = endpoints_.close(); }

    /// What was served, and relayed to each line, after finish(): in words, or as JSON objects, a line each.
    [[nodiscard]] std::string summary_text() const;
    [[nodiscard]] std::string summary_json() const;

private:
    class SharedLine;
    class Values;

    const model::Project& project_;
    const std::string file_;
    Running& running_;
    Texts texts_;
    std::unique_ptr<Values> values_;
    std::vector<std::unique_ptr<SharedLine>> lines_;  // by index
    endpoint::EndpointSet endpoints_;
    endpoint::Statistics statistics_;
};

}  // namespace takt::app
