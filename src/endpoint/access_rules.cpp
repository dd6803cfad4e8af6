#include "takt/endpoint/access_rules.hpp"

namespace takt::endpoint {
namespace {

serve::AccessRule::Permission permission_of(model::AccessPermission permission) {
    switch (permission) {
        case model::AccessPermission::allow: return serve::AccessRule::Permission::allow;
        case model::AccessPermission::read_only: return serve::AccessRule::Permission::read_only;
        case model::AccessPermission::deny: break;
    }
    return serve::AccessRule::Permission::deny;
}

}  // namespace

// The storage is complete before a rule refers to it.
void AccessRules::set(const std::vector<model::AccessRule>& rules) {
    control_.set_rules({});
    storage_.clear();
    rules_.clear();
    for (const auto& rule : rules) {
        Storage& storage = storage_.emplace_back();
        for (const auto [first, last] : rule.units)
            storage.units.push_back({static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(last)});
        for (const auto [first, last] : rule.items) storage.items.push_back({first, last});
        storage.networks = rule.networks;
        storage.roles = rule.roles;
        storage.role_views.assign(storage.roles.begin(), storage.roles.end());
    }
    for (std::size_t i = 0; i < rules.size(); ++i) {
        const model::AccessRule& rule = rules[i];
        serve::AccessRule own;
        own.networks = storage_[i].networks;
        own.serial = rule.serial;
        own.every_peer = rule.every_peer;
        own.roles = storage_[i].role_views;
        own.units = storage_[i].units;
        if (!rule.every_function) own.functions = {};
        for (const std::uint8_t code : rule.functions) own.functions.add(code);
        own.identification = rule.identification;
        own.other_encapsulated = rule.other_encapsulated;
        own.area = rule.area;
        own.items = storage_[i].items;
        own.permission = permission_of(rule.permission);
        if (rule.rate) own.rate = serve::RateLimit{rule.rate->per_second, rule.rate->burst};
        rules_.push_back(own);
    }
    control_.set_rules(rules_);
}

}  // namespace takt::endpoint
