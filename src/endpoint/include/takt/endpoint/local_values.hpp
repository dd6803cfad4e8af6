// The values of a project that is served and not polled.
#pragma once

#include "takt/endpoint/bindings.hpp"
#include "takt/model/project.hpp"
#include "takt/value/store.hpp"

namespace takt::endpoint {

/// Its locals; variables and service variables were never read and cannot be written.
class LocalValues final : public endpoint::ProjectValues {
public:
    explicit LocalValues(const model::Project& project);
    [[nodiscard]] const value::Store& store() const override { return store_; }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override;
    /// @returns timed_out: no line is polled
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     std::function<void(const value::CommandOutcome&)> done) override;

private:
    value::Store store_;
};

}  // namespace takt::endpoint
