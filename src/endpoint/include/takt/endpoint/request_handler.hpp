// Every request of an endpoint's clients, from the connection's engine to the answer.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "takt/base/inplace_string.hpp"
#include "takt/endpoint/access_rules.hpp"
#include "takt/endpoint/audit.hpp"
#include "takt/endpoint/pending_answers.hpp"
#include "takt/endpoint/request_path.hpp"
#include "takt/serve/answer.hpp"
#include "takt/serve/route_table.hpp"
#include "takt/sim/answer_faults.hpp"

namespace takt::endpoint {

/// The one responder of an endpoint. A request passes these steps:
///   1. injected faults: an exception ends here; a delay or a silence strikes the answer on its way back;
///   2. the path of the request: the own unit that is addressed; else the route of the unit; else none. A
///      broadcast of a serial line goes to all own units, and along the route of unit 0;
///   3. access rules, for every unit at the end of the path: behind a route the unit on the line, and all
///      units of the line for a broadcast. A request that is not allowed ends here;
///   4. the own units, with the hooks of their UnitHookChain, or the line; without a path exception 0x0A;
///   5. the audit log, with what became of the request.
/// An answer that step 4 put off is given by pending(), and then passes step 5.
///
/// Over TCP the units 0 and 255 mean the first own unit where they have no route. The loop's thread only.
class RequestHandler final : public serve::Responder {
public:
    /// @param own     the responder of the own units; nullptr: there are none. Outlives this
    /// @param units   the own units, in their order, and the relayed ones behind them
    /// @param faults  may be nullptr
    /// @param line    the line whose devices the own units are, for faults of single devices; else empty
    RequestHandler(serve::Responder* own, std::vector<UnitId> units,
                   std::shared_ptr<sim::AnswerFaults> faults, std::string line = {});
    RequestHandler(const RequestHandler&) = delete;
    RequestHandler& operator=(const RequestHandler&) = delete;

    [[nodiscard]] const std::vector<UnitId>& units() const { return units_; }
    void set_routes(serve::RouteTable routes) { routes_ = std::move(routes); }
    /// Puts rules in force. Relayed requests that were not sent yet are decided again.
    void set_access(const std::vector<model::AccessRule>& rules);
    [[nodiscard]] Audit& audit() { return audit_; }
    [[nodiscard]] PendingAnswers& pending() { return pending_; }

    // serve::Responder
    [[nodiscard]] bool serves(UnitId unit) const override {
        return (own_ && own_->serves(unit)) || routes_.has(unit);
    }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override;
    void on_line_event(serve::LineEvent event) override {
        if (own_) own_->on_line_event(event);
    }
    void forget(serve::Token token) override;

    /// A line has answered a relayed request, or the gateway did.
    void on_relayed(const serve::Gateway::Reply& reply);
    /// The endpoint closes: relayed requests are no longer awaited.
    void forget_relayed();

private:
    /// A relayed request without an answer yet, for rules that change meanwhile.
    struct Waiting {
        InplaceString<64> peer;
        InplaceString<64> role;
        UnitId unit;
        bool broadcast = false;
        wire::Pdu bytes;
        wire::RequestView request;  // of `bytes`
        serve::AccessControl::Decision decision = serve::AccessControl::Decision::allowed;
    };

    [[nodiscard]] RequestPath path_of(const serve::Context& context) const;
    [[nodiscard]] std::span<const serve::UnitRange> executors(const serve::Context& context,
                                                              const RequestPath& path);
    serve::Answer admit(const serve::Context& context, const wire::RequestView& request);
    serve::Answer dispatch(const serve::Context& context, const wire::RequestView& request,
                           RequestPath& path);
    serve::Answer route(const serve::Context& context, const wire::RequestView& request, RequestPath& path);
    serve::Answer relay(const serve::Context& context, const wire::RequestView& request, RequestPath& path);

    serve::Responder* own_;
    std::vector<UnitId> units_;
    std::shared_ptr<sim::AnswerFaults> faults_;
    sim::FaultSite site_;
    serve::RouteTable routes_;
    AccessRules access_;
    Audit audit_;
    PendingAnswers pending_;
    std::vector<serve::UnitRange> executors_;  // of the request at hand
    std::unordered_map<serve::Token, Waiting> relayed_;
};

}  // namespace takt::endpoint
