// The access rules and audit logs of all places of a program.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "serve_places.hpp"
#include "takt/app/texts.hpp"

namespace takt::app {

/// Gives the places their rules and logs, and reads the rules again when it is told to. The loop's thread.
class PlaceAccess {
public:
    /// @param places, options  outlive it
    PlaceAccess(const Texts& texts, const std::vector<Place>& places, const ServeOptions& options)
        : texts_(texts), places_(places), options_(options) {}

    /// @returns as AuditLog::open()
    [[nodiscard]] Result<void> begin(std::vector<model::AccessRule> rules);

    /// Whether there is anything to read again.
    [[nodiscard]] bool reloads() const { return !options_.access.empty() || has_rules_; }
    /// Where the file cannot be used, the rules stay what they are.
    void reload();

    /// Writes what is left of the logs, and tells what could not be written.
    void finish();

private:
    void reload_project();
    void tell(std::size_t rules) const;

    Texts texts_;
    const std::vector<Place>& places_;
    const ServeOptions& options_;
    bool has_rules_ = false;
    std::map<std::string, std::shared_ptr<AuditLog>> logs_;  // by path
};

}  // namespace takt::app
