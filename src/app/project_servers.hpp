// The servers of a running project, beside its polling.
#pragma once

#include <string>
#include <vector>

#include "place_access.hpp"
#include "relaying.hpp"
#include "serve_places.hpp"
#include "served_sources.hpp"
#include "serving.hpp"

namespace takt::app {

/// Opens `servers:` of a project that runs. The loop's thread only.
class ProjectServers {
public:
    /// @param loop, project, running, log  outlive it; the log may be nullptr
    /// @param file  of the project: what servers keep lies beside it
    ProjectServers(line::Loop& loop, const model::Project& project, const std::string& file, Running& running,
                   TrafficLog* log, const Texts& texts);

    /// Says where it answers. @returns what opening an address, a serial port, an audit log, the file of
    /// retained registers or a source returns
    [[nodiscard]] Result<void> open();

    /// Reads the access rules of the project again; where they cannot be used, they stay what they are.
    void reload_access() { access_.reload(); }

    /// Closes everything and writes what is left to be written. After open() only.
    void finish();

    /// What was served, and relayed to each line, after finish(): in words, or as JSON objects, a line each.
    [[nodiscard]] std::string summary_text() const;
    [[nodiscard]] std::string summary_json() const;

private:
    void relay(std::size_t server, Place& place);

    line::Loop& loop_;
    const model::Project& project_;
    TrafficLog* log_;
    Texts texts_;
    ServeOptions options_;
    RunningValues values_;
    ServedSources sources_;
    Relaying relaying_;
    std::vector<Place> places_;
    PlaceAccess access_;
    std::vector<Serving> serving_;
    report::ServeSummary summary_;
};

}  // namespace takt::app
