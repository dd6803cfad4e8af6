#include "takt/value/project_slots.hpp"

#include "takt/base/assert.hpp"

namespace takt::value {

ProjectSlots::ProjectSlots(const model::Project& project) : locals_(project.locals.size()) {
    for (std::size_t l = 0; l < project.lines.size(); ++l) {
        auto& first = first_of_device_.emplace_back();
        const auto& devices = project.lines[l].devices;
        for (std::size_t d = 0; d < devices.size(); ++d) {
            first.push_back(variables_.size());
            for (std::size_t v = 0; v < devices[d].variables.size(); ++v) variables_.push_back({l, d, v});
        }
    }
}

SlotId ProjectSlots::local(model::LocalIndex index) const {
    TAKT_ASSERT(index < locals_);
    return {static_cast<std::uint32_t>(index)};
}

SlotId ProjectSlots::variable(const VariableIndex& index) const {
    const std::size_t position = first_of_device_.at(index.line).at(index.device) + index.variable;
    TAKT_ASSERT(position < variables_.size() && variables_[position] == index);
    return {static_cast<std::uint32_t>(locals_ + position)};
}

ProjectSlots::Owner ProjectSlots::owner(SlotId slot) const {
    TAKT_ASSERT(slot.value < size());
    if (slot.value < locals_) return model::LocalIndex{slot.value};
    return variables_[slot.value - locals_];
}

Value to_value(DataType type, bool scaled, const model::Constant& constant) {
    if (type == DataType::string) return constant.text;
    if (type == DataType::boolean) return constant.integer != 0;
    if (type == DataType::float64 || scaled) return constant.number;
    if (type == DataType::float32) return double{static_cast<float>(constant.number)};
    if (type == DataType::uint16 || type == DataType::uint32 || type == DataType::uint64)
        return static_cast<std::uint64_t>(constant.integer);
    return constant.integer;
}

std::vector<SlotInfo> slot_infos(const model::Project& project) {
    std::vector<SlotInfo> infos;
    infos.reserve(project.locals.size());
    for (const auto& local : project.locals)
        infos.push_back(
            {.name = local.name,
             .type = local.type,
             .local = true,
             .service = local.service,
             .initial = to_value(local.type, false, local.default_value.value_or(model::Constant{}))});
    for (const auto& line : project.lines)
        for (const auto& device : line.devices)
            for (const auto& variable : device.variables) {
                auto& info = infos.emplace_back(SlotInfo{.name = variable.name,
                                                         .type = variable.type,
                                                         .scaled = variable.scaled(),
                                                         .dead_band = variable.dead_band});
                if (variable.default_value)
                    info.initial = to_value(variable.type, variable.scaled(), *variable.default_value);
            }
    return infos;
}

Layout layout_of(const model::Variable& variable) {
    Layout layout{.type = variable.type,
                  .order = variable.order,
                  .registers = variable.registers,
                  .scale = variable.scale,
                  .offset = variable.offset};
    if (!wire::is_bit_area(variable.area)) layout.bit = variable.bit;
    return layout;
}

}  // namespace takt::value
