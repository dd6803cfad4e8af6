// Every request of an endpoint's clients, from the connection's engine to the answer.
#pragma once

#include <memory>
#include <vector>

#include "takt/endpoint/access_rules.hpp"
#include "takt/endpoint/audit.hpp"
#include "takt/endpoint/pending_answers.hpp"
#include "takt/relay/relay_routes.hpp"
#include "takt/serve/answer.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::endpoint {

/// The one responder of an endpoint. A request passes these steps:
///   1. injected faults: an exception ends here; a delay or a silence strikes the answer on its way back;
///   2. access rules: a request that is not allowed ends here;
///   3. the own unit that is addressed, with the hooks of its UnitHookChain; else the route of the unit; else
///      exception 0x0A. A broadcast of a serial line goes to the own units, and along the route of unit 0;
///   4. the audit log, with what became of the request.
/// An answer that step 3 put off is given by pending(), and then passes step 4.
///
/// Over TCP the units 0 and 255 mean the first own unit where they have no route. The loop's thread only.
class RequestHandler final : public serve::Responder {
public:
    /// @param own     the responder of the own units; nullptr: there are none. Outlives this
    /// @param units   the own units, in their order, and the relayed ones behind them
    /// @param faults  may be nullptr
    RequestHandler(serve::Responder* own, std::vector<UnitId> units,
                   std::shared_ptr<sim::AnswerFaults> faults);
    RequestHandler(const RequestHandler&) = delete;
    RequestHandler& operator=(const RequestHandler&) = delete;

    [[nodiscard]] const std::vector<UnitId>& units() const { return units_; }
    void set_routes(relay::RelayRoutes routes) { routes_ = std::move(routes); }
    [[nodiscard]] AccessRules& access() { return access_; }
    [[nodiscard]] Audit& audit() { return audit_; }
    [[nodiscard]] PendingAnswers& pending() { return pending_; }

    // serve::Responder
    [[nodiscard]] bool serves(UnitId unit) const override {
        return (own_ && own_->serves(unit)) || routes_.has(unit);
    }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;
    void on_line_event(serve::LineEvent event) override {
        if (own_) own_->on_line_event(event);
    }
    void forget(serve::Token token) override;

private:
    serve::Answer admit(const serve::Context& context, Bytes pdu);
    serve::Answer dispatch(const serve::Context& context, Bytes pdu);
    serve::Answer route(const serve::Context& context, Bytes pdu);
    serve::Answer relay(const serve::Context& context, Bytes pdu);

    serve::Responder* own_;
    std::vector<UnitId> units_;
    std::shared_ptr<sim::AnswerFaults> faults_;
    relay::RelayRoutes routes_;
    AccessRules access_;
    Audit audit_;
    PendingAnswers pending_;
};

}  // namespace takt::endpoint
