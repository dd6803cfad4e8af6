// The gateways of a running project: requests of servers' clients on their way to the lines, beside polling.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "takt/app/running.hpp"
#include "takt/line/answer_routes.hpp"
#include "takt/line/loop.hpp"
#include "takt/model/project.hpp"
#include "takt/relay/gateway.hpp"
#include "takt/relay/relay_responder.hpp"

namespace takt::app {

/// A gateway for each line that servers relay to. Everything happens on the loop's thread: what the line does
/// is looked at inside its driver's calls, so that the next request is sent with the end of the one before;
/// answers go out in calls of the loop's own.
class Relaying {
public:
    /// @param loop, project, running  outlive it
    Relaying(line::Loop& loop, const model::Project& project, Running& running);
    ~Relaying();
    Relaying(const Relaying&) = delete;
    Relaying& operator=(const Relaying&) = delete;

    /// What answers for a server: `own`, or where the server relays, this with its routes around it. Must not
    /// outlive this.
    /// @param own      the server's own units, or nullptr
    /// @param answers  the way of pending answers; outlives this
    [[nodiscard]] std::shared_ptr<serve::Responder> responder(std::size_t server,
                                                              std::shared_ptr<serve::Responder> own,
                                                              line::AnswerRoutes& answers);

    /// The units that a server relays, ascending.
    [[nodiscard]] std::vector<UnitId> units(std::size_t server) const;

    /// What was relayed to a line; nullptr: nobody relays to it.
    [[nodiscard]] const relay::GatewayCounters* counters(std::size_t line) const;

private:
    struct Line;

    void exchange(Instant t, std::size_t line);
    void work(Instant t, std::size_t line);
    void deliver(Line& line);
    void arm(Instant t, std::size_t line);

    line::Loop& loop_;
    const model::Project& project_;
    Running& running_;
    std::vector<std::unique_ptr<Line>> lines_;  // by line; nullptr: nobody relays to it
    std::vector<line::AnswerRoutes*> answers_;  // by server
};

}  // namespace takt::app
