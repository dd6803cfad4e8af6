// Variables that can be written, in a store, without a line.
#pragma once

#include <vector>

#include "writes/written_values.hpp"
#include "writing.hpp"

namespace takt::poll::test {

/// The variables of a test are numbered from 0, and their slots too.
struct WriteFixture {
    explicit WriteFixture(const std::vector<Item>& items)
        : models(items.begin(), items.end()), store(slots_of(items)), values(store) {
        for (std::size_t v = 0; v < models.size(); ++v)
            if (models[v].write) values.add(v, models[v], slot(v));
    }

    static value::SlotId slot(std::size_t variable) { return {static_cast<std::uint32_t>(variable)}; }
    /// The value as it is written to the variable.
    [[nodiscard]] Written written(std::size_t variable, const value::Value& value) const {
        return as_written(models[variable], value).value();
    }
    [[nodiscard]] value::Value wanted(std::size_t variable) const { return store[slot(variable)].wanted; }

    std::vector<model::Variable> models;
    value::Store store;
    WrittenValues values;

private:
    static std::vector<value::SlotInfo> slots_of(const std::vector<Item>& items) {
        std::vector<value::SlotInfo> slots;
        for (const auto& item : items) {
            value::SlotInfo info{.name = item.name, .type = item.type};
            if (item.default_value) info.initial = item.default_value->integer;
            slots.push_back(info);
        }
        return slots;
    }
};

}  // namespace takt::poll::test
