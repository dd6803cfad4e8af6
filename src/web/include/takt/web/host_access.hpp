// How the web module reaches the running project: as every other face, through sessions of its host.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/host/session.hpp"
#include "takt/publish/output_status.hpp"

namespace takt::web {

/// Every function may be called from any thread until WebFace has stopped.
struct HostAccess {
    std::function<Result<std::unique_ptr<host::Session>>(const host::SessionOptions&)> open_session;
    std::function<host::ConfigurationPtr()> configuration;
    /// As publish::Outputs::status(); empty: there are none.
    std::function<std::vector<publish::OutputStatus>()> outputs;
    Instant started;
};

}  // namespace takt::web
