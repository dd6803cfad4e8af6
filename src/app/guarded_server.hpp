// A responder behind access rules and an audit log.
#pragma once

#include <array>
#include <bitset>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "audit_log.hpp"
#include "takt/app/texts.hpp"
#include "takt/model/project.hpp"
#include "takt/serve/access.hpp"
#include "takt/serve/server.hpp"

namespace takt::app {

/// Sees what is written to one unit, before and after.
class AuditedUnit final : public serve::UnitHooks {
public:
    /// @param unit  outlives it; what hooks it has stay in force
    explicit AuditedUnit(serve::Unit& unit);
    AuditedUnit(const AuditedUnit&) = delete;
    AuditedUnit& operator=(const AuditedUnit&) = delete;

    void set_log(AuditLog* log) { log_ = log; }

    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    serve::Unit& unit_;
    serve::UnitHooks* next_;
    AuditLog* log_ = nullptr;
    wire::Pdu old_;
};

/// Refuses what its rules do not allow, and tells its log. The loop's thread only.
class GuardedServer final : public serve::Responder, serve::AccessObserver {
public:
    /// @param responder  answers; it is kept alive
    /// @param units      its units, 0 and 255 mean the first
    GuardedServer(std::shared_ptr<serve::Responder> responder, std::vector<UnitId> units);

    /// What is written to the items of that unit, one of its own, is told with their values.
    void watch(serve::Unit& unit);
    void set_rules(const std::vector<model::AccessRule>& rules);
    void set_log(std::shared_ptr<AuditLog> log);

    [[nodiscard]] bool serves(UnitId unit) const override { return guard_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override {
        return guard_.handle(context, pdu);
    }
    void heard(serve::LineEvent event) override { guard_.heard(event); }
    void forget(serve::Token token) override;

    /// An answer that was pending is given now: only then it is known what became of a write.
    void answered(serve::Token token, Bytes pdu);

private:
    /// What a rule refers to.
    struct Storage {
        std::vector<serve::UnitRange> units;
        std::vector<serve::AddressRange> items;
        std::vector<Network> networks;
    };
    /// A write that is not answered yet.
    struct Unanswered {
        AuditRecord record;
        bool told = false;  // by its unit
    };
    static constexpr std::size_t kPeers = 256;         // with rate limits at a time
    static constexpr std::size_t kUnanswered = 65536;  // beyond, a write is told as done

    [[nodiscard]] bool is_told_by_unit(const serve::Context& context) const;
    void tell_unanswered(serve::Token token);
    void asked(const serve::Context& context, Bytes request, const serve::RequestScope& scope,
               serve::AccessControl::Decision decision, const serve::Answer& answer) override;

    std::shared_ptr<serve::Responder> responder_;
    std::vector<UnitId> units_;
    std::vector<Storage> storage_;
    std::vector<serve::AccessRule> rules_;
    std::vector<serve::RateBucket> buckets_{kPeers};
    serve::AccessControl control_{buckets_};
    serve::AccessGuard guard_;
    std::shared_ptr<AuditLog> log_;
    std::vector<std::unique_ptr<AuditedUnit>> audited_;
    std::bitset<256> watched_;  // units
    std::unordered_map<serve::Token, Unanswered> unanswered_;
};

/// The rules of a file that is a list of them; what is wrong with it goes to stderr.
/// @returns nothing: they cannot be used
[[nodiscard]] std::optional<std::vector<model::AccessRule>> load_access(const Texts& texts,
                                                                        const std::string& path);

}  // namespace takt::app
