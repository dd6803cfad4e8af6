// A project to run, with its plan and the numbering of its values. Immutable, shared by all threads.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/store.hpp"

namespace takt::host {

/// One generation of a running project. ProjectHost::apply() makes the next one. The indices in events,
/// snapshots and commands (line, device, variable, slot) are those of one generation.
class Configuration {
public:
    /// @param generation  1 for the project that the host starts with
    Configuration(std::uint32_t generation, model::Project project, plan::Plan plan);
    Configuration(const Configuration&) = delete;
    Configuration& operator=(const Configuration&) = delete;

    [[nodiscard]] std::uint32_t generation() const { return generation_; }
    [[nodiscard]] const model::Project& project() const { return project_; }
    /// The plan as it was made for this project. With `gaps: learn` another plan may run:
    /// Snapshot::Line::plan.
    [[nodiscard]] const plan::Plan& plan() const { return plan_; }
    [[nodiscard]] const value::ProjectSlots& slots() const { return slots_; }
    [[nodiscard]] std::size_t slot_count() const { return infos_.size(); }
    [[nodiscard]] const value::SlotInfo& info(value::SlotId slot) const { return infos_.at(slot.value); }
    [[nodiscard]] std::optional<value::SlotId> find(std::string_view name) const;

    /// The owner of a slot; nullptr for locals.
    [[nodiscard]] const model::Line* line_of(value::SlotId slot) const;
    [[nodiscard]] const model::Device* device_of(value::SlotId slot) const;
    [[nodiscard]] const model::Variable* variable_of(value::SlotId slot) const;

    /// A value with its unit; "–" for none.
    [[nodiscard]] std::string value_text(value::SlotId slot, const value::Value& value) const;
    /// The words of a variable for that value, by its `enumeration` or `bits`; empty if there are none.
    [[nodiscard]] std::string value_words(value::SlotId slot, const value::Value& value) const;

private:
    [[nodiscard]] const value::VariableIndex* index_of(value::SlotId slot,
                                                       value::ProjectSlots::Owner& owner) const;

    std::uint32_t generation_;
    model::Project project_;
    plan::Plan plan_;
    value::ProjectSlots slots_;
    std::vector<value::SlotInfo> infos_;
    std::vector<value::SlotId> by_name_;  // in the order of their names
};

using ConfigurationPtr = std::shared_ptr<const Configuration>;

/// The words of a variable for a value of it, by its `enumeration` or `bits`; empty if there are none.
[[nodiscard]] std::string words_of(const model::Variable& variable, const value::Value& value);

}  // namespace takt::host
