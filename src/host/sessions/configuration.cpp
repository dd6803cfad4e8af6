#include "takt/host/configuration.hpp"

#include <algorithm>
#include <utility>
#include <variant>

#include "takt/model/service.hpp"
#include "takt/model/value_words.hpp"
#include "takt/value/text.hpp"

namespace takt::host {

Configuration::Configuration(std::uint32_t generation, model::Project project, plan::Plan plan)
    : generation_(generation),
      project_(std::move(project)),
      plan_(std::move(plan)),
      slots_(project_),
      infos_(value::slot_infos(project_)) {
    by_name_.reserve(infos_.size());
    for (std::uint32_t i = 0; i < infos_.size(); ++i) by_name_.push_back({i});
    std::ranges::sort(by_name_, {},
                      [this](value::SlotId id) -> std::string_view { return infos_[id.value].name; });
}

std::optional<value::SlotId> Configuration::find(std::string_view name) const {
    const auto name_of = [this](value::SlotId id) -> std::string_view { return infos_[id.value].name; };
    const auto found = std::ranges::lower_bound(by_name_, name, {}, name_of);
    if (found == by_name_.end() || name_of(*found) != name) return std::nullopt;
    return *found;
}

const value::VariableIndex* Configuration::index_of(value::SlotId slot,
                                                    value::ProjectSlots::Owner& owner) const {
    owner = slots_.owner(slot);
    return std::get_if<value::VariableIndex>(&owner);
}

const model::Line* Configuration::line_of(value::SlotId slot) const {
    value::ProjectSlots::Owner owner;
    const auto* index = index_of(slot, owner);
    return index ? &project_.lines[index->line] : nullptr;
}

const model::Device* Configuration::device_of(value::SlotId slot) const {
    value::ProjectSlots::Owner owner;
    const auto* index = index_of(slot, owner);
    return index ? &project_.lines[index->line].devices[index->device] : nullptr;
}

const model::Variable* Configuration::variable_of(value::SlotId slot) const {
    value::ProjectSlots::Owner owner;
    const auto* index = index_of(slot, owner);
    return index ? &device_of(slot)->variables[index->variable] : nullptr;
}

std::string Configuration::value_text(value::SlotId slot, const value::Value& value) const {
    const auto& info = this->info(slot);
    std::string text = value::is_empty(value) ? "–" : value::format(info.type, info.scaled, value);
    const auto* const variable = variable_of(slot);
    const auto* const service = info.service ? model::find_service_field(info.name) : nullptr;
    const std::string_view unit = variable ? std::string_view(variable->unit) : service ? service->unit : "";
    if (!unit.empty()) text.append(" ").append(unit);
    if (const auto words = value_words(slot, value); !words.empty())
        text.append(" (").append(words).append(")");
    return text;
}

std::string Configuration::value_words(value::SlotId slot, const value::Value& value) const {
    const auto* const variable = variable_of(slot);
    return variable == nullptr ? std::string() : words_of(*variable, value);
}

std::string words_of(const model::Variable& variable, const value::Value& value) {
    if (const auto* const flag = std::get_if<bool>(&value)) return model::words_of(variable, *flag ? 1 : 0);
    if (const auto* const number = std::get_if<std::int64_t>(&value))
        return model::words_of(variable, *number);
    if (const auto* const number = std::get_if<std::uint64_t>(&value))
        return model::words_of(variable, static_cast<std::int64_t>(*number));
    return {};
}

}  // namespace takt::host
