// Which requests go into the audit log, and when.
#pragma once

#include <bitset>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

#include "takt/endpoint/audit_log.hpp"
#include "takt/serve/access.hpp"
#include "takt/serve/server.hpp"

namespace takt::endpoint {

/// Records every write and every request that was refused.
///
/// A write to items of an own unit is recorded by the unit's hooks, with old and new values. All other writes
/// (relayed ones, files, diagnostics) are recorded from the request. A write whose answer is pending is
/// recorded when it is answered, because only then its outcome is known; if its client goes first, it is
/// recorded as a write, for it may have been done. The loop's thread only.
class Audit {
public:
    /// @param units  all units of the endpoint, own and relayed
    explicit Audit(std::vector<UnitId> units) : units_(std::move(units)) {}
    Audit(const Audit&) = delete;
    Audit& operator=(const Audit&) = delete;

    /// The hooks that record what is written to an own unit. @param unit  outlives this
    [[nodiscard]] serve::UnitHooks& watch(serve::Unit& unit);

    /// Replaces the sink; what is unanswered is recorded in the old one. nullptr: nothing is recorded.
    void set_sink(std::shared_ptr<AuditSink> sink);
    [[nodiscard]] bool active() const { return sink_ != nullptr; }

    /// A request was handled, or refused by a rule.
    void on_request(const serve::Context& context, Bytes request, const serve::RequestScope& scope,
                    serve::AccessControl::Decision decision, const serve::Answer& answer);
    /// A pending answer is given.
    void on_answer(Instant t, serve::Token token, Bytes pdu);
    /// A pending answer will not be given: its client is gone.
    void on_forget(Instant t, serve::Token token);

private:
    class UnitAudit final : public serve::UnitHooks {
    public:
        UnitAudit(Audit& audit, serve::Unit& unit) : audit_(audit), unit_(unit) {}
        std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                                  const serve::Access& access) override;
        void written(const serve::Context& context, const serve::Access& access) override;

    private:
        Audit& audit_;
        serve::Unit& unit_;
        wire::Pdu old_;
    };
    struct Unanswered {
        AuditRecord record;
        bool recorded = false;  // by the hooks of its unit
    };

    [[nodiscard]] bool is_recorded_by_unit(UnitId unit) const;

    std::vector<UnitId> units_;
    std::deque<UnitAudit> watched_;
    std::bitset<256> is_watched_;  // by unit
    std::shared_ptr<AuditSink> sink_;
    std::unordered_map<serve::Token, Unanswered> unanswered_;
};

}  // namespace takt::endpoint
