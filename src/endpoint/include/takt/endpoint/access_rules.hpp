// The access rules of an endpoint, with the storage they refer to.
#pragma once

#include <span>
#include <vector>

#include "takt/model/server.hpp"
#include "takt/serve/access.hpp"

namespace takt::endpoint {

/// Decides by the rules of a project. They may be replaced at any time, as a whole. The loop's thread only.
class AccessRules {
public:
    AccessRules() = default;
    AccessRules(const AccessRules&) = delete;
    AccessRules& operator=(const AccessRules&) = delete;

    /// No rules: everything is allowed.
    void set(const std::vector<model::AccessRule>& rules);
    [[nodiscard]] bool empty() const { return rules_.empty(); }

    /// As serve::AccessControl::decide().
    [[nodiscard]] serve::AccessControl::Decision decide(const serve::Context& context,
                                                        std::span<const serve::UnitRange> units,
                                                        const wire::RequestView& request) {
        return control_.decide(context, units, request);
    }
    /// As serve::AccessControl::decide_again().
    [[nodiscard]] serve::AccessControl::Decision decide_again(const serve::Context& context,
                                                              std::span<const serve::UnitRange> units,
                                                              const wire::RequestView& request) const {
        return control_.decide_again(context, units, request);
    }

private:
    /// The ranges that one rule refers to.
    struct Storage {
        std::vector<serve::UnitRange> units;
        std::vector<serve::AddressRange> items;
        std::vector<Network> networks;
        std::vector<std::string> roles;
        std::vector<std::string_view> role_views;  // of `roles`
    };
    static constexpr std::size_t kPeers = 256;  // with rate limits at a time

    std::vector<Storage> storage_;
    std::vector<serve::AccessRule> rules_;
    std::vector<serve::RateBucket> buckets_{kPeers};
    serve::AccessControl control_{buckets_};
};

}  // namespace takt::endpoint
