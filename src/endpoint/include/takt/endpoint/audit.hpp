// Which requests go into the audit log, and when.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <unordered_map>

#include "takt/endpoint/audit_log.hpp"
#include "takt/endpoint/request_path.hpp"
#include "takt/serve/access.hpp"
#include "takt/serve/server.hpp"

namespace takt::endpoint {

/// A request as the handler saw it. Valid during the call.
struct AuditedRequest {
    const serve::Context& context;
    const wire::RequestView& request;
    const RequestPath& path;
};

/// Records every write and every request that was refused.
///
/// A write to items of an own unit is recorded by the unit's hooks, with old and new values. All other writes
/// (relayed ones, files, diagnostics) are recorded from the request. A write whose answer is pending is
/// recorded when it is answered, because only then its outcome is known. If the client of an own unit
/// disconnects before that, the write is recorded as done, because it may have been executed.
///
/// A relayed write has an outcome (AuditRecord::Outcome). A broadcast of a serial master is recorded for each
/// own unit, as a write or with the exception of the unit, and for the line behind the server. A request that
/// a unit in listen-only mode ignores is not recorded. The loop's thread only.
class Audit {
public:
    Audit() = default;
    Audit(const Audit&) = delete;
    Audit& operator=(const Audit&) = delete;

    /// The hooks that record what is written to an own unit. @param unit  outlives this
    [[nodiscard]] serve::UnitHooks& watch(serve::Unit& unit);

    /// Replaces the sink; unanswered requests are recorded in the old one. nullptr: nothing is recorded.
    void set_sink(std::shared_ptr<AuditSink> sink);
    [[nodiscard]] bool active() const { return sink_ != nullptr; }

    /// A request was handled, or refused by a rule.
    void on_request(const AuditedRequest& request, serve::AccessControl::Decision decision,
                    const serve::Answer& answer);
    /// A pending answer of an own unit is given.
    void on_answer(Instant t, serve::Token token, Bytes pdu);
    /// A pending answer of an own unit will not be given: its client is gone.
    void on_forget(Instant t, serve::Token token);
    /// Rules that came into force refuse a relayed request that waits; on_relayed() follows.
    void on_refused_waiting(const AuditedRequest& request, serve::AccessControl::Decision decision);
    /// A relayed request has its reply.
    /// @param decision  not allowed: rules that came into force while it waited refused it
    void on_relayed(Instant t, const serve::Gateway::Reply& reply, serve::AccessControl::Decision decision);
    /// A relayed request gets no reply: its client is gone.
    void on_relay_forgotten(Instant t, serve::Token token, serve::Fate fate);

private:
    class UnitAudit final : public serve::UnitHooks {
    public:
        UnitAudit(Audit& audit, serve::Unit& unit) : audit_(audit), unit_(unit) {}
        std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                                  const serve::Access& access) override;
        void written(const serve::Context& context, const serve::Access& access) override;
        void handled(const serve::Context& context, const wire::RequestView& request,
                     const serve::Answer& answer) override {
            audit_.on_unit_answer(unit_.id, context, request, answer);
        }

    private:
        Audit& audit_;
        serve::Unit& unit_;
        wire::Pdu old_;
    };
    struct Unanswered {
        AuditRecord record;
        bool recorded = false;  // by the hooks of its unit
    };

    void on_unit_answer(UnitId unit, const serve::Context& context, const wire::RequestView& request,
                        const serve::Answer& answer);
    void on_own_request(const AuditedRequest& request, const serve::Answer& answer);
    void on_relay_request(const AuditedRequest& request);

    std::deque<UnitAudit> watched_;
    std::shared_ptr<AuditSink> sink_;
    std::optional<UnitId> handled_by_;                          // of the request in progress: the own unit
    std::unordered_map<serve::Token, Unanswered> unanswered_;   // of own units
    std::unordered_map<serve::Token, AuditRecord> on_the_way_;  // relayed writes
};

}  // namespace takt::endpoint
