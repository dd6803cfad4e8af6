// The places where `takt serve` answers: of a project's servers, of its devices, of the blank device.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "guarded_server.hpp"
#include "retained_server.hpp"
#include "served_server.hpp"
#include "takt/app/commands.hpp"
#include "takt/base/result.hpp"
#include "takt/line/answer_routes.hpp"
#include "takt/line/target.hpp"
#include "takt/model/project.hpp"
#include "takt/serve/answer.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::app {

/// Where the devices of a line are to be found, and what they are.
struct Place {
    model::Line line;  ///< with the transport, port and format in force
    std::optional<line::ListenAddress> listen;
    std::shared_ptr<serve::Responder> responder;  ///< shared by the places of one blank device
    std::vector<UnitId> units;
    bool strict = false;
    Duration turnaround{};
    model::ListenLimits limits;
    /// The way of answers the responder left pending; shared like the responder.
    std::shared_ptr<line::AnswerRoutes> answers = std::make_shared<line::AnswerRoutes>();
    std::shared_ptr<RetainedServer> retained;  ///< what of the responder is kept; may be absent
    /// The way of answers that `retained` left pending, where that is another one.
    std::shared_ptr<serve::AnswerSink> retained_answers;
    std::shared_ptr<GuardedServer> guard;  ///< who may ask it for what; may be absent; shared like it
    std::vector<model::AccessRule> access;
    std::string audit;                          ///< file; empty: none
    std::shared_ptr<ServedServer> served;       ///< of a project's server: what is at its heart
    std::shared_ptr<sim::AnswerFaults> faults;  ///< how it misbehaves; may be absent, shared by all
};

/// One blank device at all places the options name.
[[nodiscard]] Result<std::vector<Place>> blank_places(const ServeOptions& options);

/// The devices of the project's lines, with moving values.
[[nodiscard]] Result<std::vector<Place>> device_places(const model::Project& project,
                                                       const ServeOptions& options);

/// Opens what the place keeps, where it keeps anything. @returns as RetainedServer::open()
[[nodiscard]] Result<void> open_retained(line::Loop& loop, const Texts& texts, const Place& place);

/// Puts something around the responder of a server, inside of its access rules.
using Around = std::function<void(std::size_t server, Place& place)>;

/// The servers of the project, which outlives the places.
[[nodiscard]] std::vector<Place> server_places(const model::Project& project, const ServeOptions& options,
                                               const Around& around = {});

}  // namespace takt::app
