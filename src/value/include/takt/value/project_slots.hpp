// The numbers of the slots of a project's variables and locals.
#pragma once

#include <cstddef>
#include <variant>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/store.hpp"

namespace takt::value {

/// A variable by its indices in the project.
struct VariableIndex {
    std::size_t line = 0;
    std::size_t device = 0;
    std::size_t variable = 0;
    friend constexpr auto operator<=>(const VariableIndex&, const VariableIndex&) = default;
};

/// The numbering of a project's slots: all locals, then all variables, in the order of the project. Unused
/// variables have slots too; they are never read. Immutable; does not keep the project.
class ProjectSlots {
public:
    explicit ProjectSlots(const model::Project& project);

    [[nodiscard]] SlotId local(model::LocalIndex index) const;
    [[nodiscard]] SlotId variable(const VariableIndex& index) const;

    using Owner = std::variant<model::LocalIndex, VariableIndex>;
    [[nodiscard]] Owner owner(SlotId slot) const;

    [[nodiscard]] std::size_t size() const { return locals_ + variables_.size(); }

private:
    std::size_t locals_ = 0;
    std::vector<std::vector<std::size_t>> first_of_device_;  // [line][device]: index into variables_
    std::vector<VariableIndex> variables_;
};

/// The slots of a project for Store, in the numbering of ProjectSlots.
std::vector<SlotInfo> slot_infos(const model::Project& project);

/// The layout of a variable in registers.
Layout layout_of(const model::Variable& variable);

/// A constant of the project file as a value of that type; unscaled floats as the nearest float.
Value to_value(DataType type, bool scaled, const model::Constant& constant);

}  // namespace takt::value
