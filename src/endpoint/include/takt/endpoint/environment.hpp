// The services that endpoints need of the program around them.
#pragma once

#include <functional>
#include <memory>

#include "takt/base/log.hpp"
#include "takt/endpoint/audit_record.hpp"
#include "takt/endpoint/bindings.hpp"
#include "takt/endpoint/line_gateway.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/line/loop.hpp"
#include "takt/line/traffic_factory.hpp"
#include "takt/model/project.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::endpoint {

/// The project that runs. It outlives the endpoints, or another one replaces it (EndpointSet::enter()).
struct ServedProject {
    const model::Project* project = nullptr;          ///< with instruments and lines; needed with ServerUnits
    endpoint::ProjectValues* values = nullptr;        ///< likewise
    std::function<SharedLine&(std::size_t)> lines{};  ///< by index; needed with relays
};

/// All that is referred to outlives the endpoints.
struct Environment {
    line::Loop& loop;
    NoticeSink notify;
    Log serve_log{};
    Log source_log{};
    line::TrafficFactory traffic{};               ///< may be empty
    AuditObserver audit{};                        ///< of endpoints with an audit log; may be empty
    std::shared_ptr<sim::AnswerFaults> faults{};  ///< how answers are spoilt; may be nullptr
    ServedProject served{};
};

}  // namespace takt::endpoint
