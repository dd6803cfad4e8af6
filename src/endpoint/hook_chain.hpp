// The hooks of one unit, in order.
#pragma once

#include <vector>

#include "takt/serve/server.hpp"

namespace takt::endpoint {

/// Calls several hooks in the order in which they were added; the first refusal counts.
///
/// An endpoint adds them in this order:
///   1. the unit's own (a simulated device moves its values),
///   2. bindings: bring the items up to date, pass written values on,
///   3. retained registers: enqueue what is in the banks now, after a binding may have put a value back,
///   4. audit: sees the old values after (2) refreshed them, and records the write last.
class UnitHookChain final : public serve::UnitHooks {
public:
    UnitHookChain() = default;
    UnitHookChain(const UnitHookChain&) = delete;
    UnitHookChain& operator=(const UnitHookChain&) = delete;

    /// @param hooks  outlives the chain
    void add(serve::UnitHooks& hooks) { links_.push_back(&hooks); }

    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override {
        for (serve::UnitHooks* const link : links_)
            if (const auto refusal = link->before(context, access)) return refusal;
        return std::nullopt;
    }
    void written(const serve::Context& context, const serve::Access& access) override {
        for (serve::UnitHooks* const link : links_) link->written(context, access);
    }
    void handled(const serve::Context& context, const wire::RequestView& request,
                 const serve::Answer& answer) override {
        for (serve::UnitHooks* const link : links_) link->handled(context, request, answer);
    }

private:
    std::vector<serve::UnitHooks*> links_;
};

}  // namespace takt::endpoint
