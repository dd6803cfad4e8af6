#include "live/live_values.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "takt/base/numbers.hpp"
#include "takt/model/service.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/drawing/value_json.hpp"
#include "takt/report/states/command_report.hpp"
#include "takt/value/codec.hpp"
#include "takt/value/text.hpp"

namespace takt::web {
namespace {

const value::VariableIndex* variable_index(const value::ProjectSlots::Owner& owner) {
    return std::get_if<value::VariableIndex>(&owner);
}

/// A side without a bound has no key.
file::Json range_json(const model::WriteRange& range) {
    auto object = file::Json::object();
    if (std::isfinite(range.least)) object.set("least", range.least);
    if (std::isfinite(range.greatest)) object.set("greatest", range.greatest);
    return object;
}

void set_variable(file::Json& object, const host::Configuration& configuration,
                  const value::VariableIndex& index) {
    const auto& line = configuration.project().lines[index.line];
    const auto& device = line.devices[index.device];
    const auto& variable = device.variables[index.variable];
    object.set("line", line.name);
    object.set("device", device.name);
    object.set("area", report::area_word(variable.area));
    object.set("register", variable.register_number);
    if (variable.bit) object.set("bit", *variable.bit);
    object.set("count", variable.items());
    if (variable.verify) object.set("verify", true);
    if (!variable.read) object.set("write_only", true);
    if (line.is_broadcast(device)) object.set("broadcast", true);
    if (!variable.enumeration.empty()) object.set("enumeration", true);
    if (variable.write_range) object.set("write_range", range_json(*variable.write_range));
    object.set("deadline_ms", milliseconds_or_null(variable.deadline));
    object.set("proved_age_ms", milliseconds_or_null(proved_age(configuration, index)));
}

std::string_view unit_of(const value::SlotInfo& info, const model::Variable* variable) {
    if (variable) return variable->unit;
    const auto* const service = info.service ? model::find_service_field(info.name) : nullptr;
    return service ? service->unit : std::string_view();
}

}  // namespace

file::Json milliseconds_or_null(const std::optional<Duration>& time) {
    return time ? file::Json(report::milliseconds(*time)) : file::Json();
}

std::optional<Duration> proved_age(const host::Configuration& configuration,
                                   const value::VariableIndex& index) {
    const auto& ages = configuration.plan().lines.at(index.line).ages;
    if (index.device >= ages.size() || index.variable >= ages[index.device].size()) return std::nullopt;
    return ages[index.device][index.variable];
}

LiveValues::LiveValues(const host::Snapshot& snapshot)
    : configuration_(snapshot.configuration),
      states_(snapshot.values.size()),
      is_changed_(snapshot.values.size()) {
    refresh(snapshot);
    changed_.clear();
    is_changed_.assign(is_changed_.size(), false);
    read_.clear();
}

void LiveValues::mark(std::uint32_t slot) {
    if (is_changed_[slot]) return;
    is_changed_[slot] = true;
    changed_.push_back(slot);
}

void LiveValues::apply(const host::ValueChanged& changed) {
    if (changed.slot.value >= states_.size()) return;
    auto& state = states_[changed.slot.value];
    state.value = changed.value;
    state.quality = changed.quality;
    state.reason = changed.reason;
    state.sampled_at = changed.sampled_at;
    mark(changed.slot.value);
}

void LiveValues::refresh(const host::Snapshot& snapshot) {
    for (std::uint32_t slot = 0; slot < states_.size() && slot < snapshot.values.size(); ++slot) {
        const auto& now = snapshot.values[slot];
        auto& state = states_[slot];
        const auto owner = configuration_->slots().owner({slot});
        if (const auto* const index = variable_index(owner); index && index->line < snapshot.lines.size()) {
            const auto& devices = snapshot.lines[index->line].devices;
            if (index->device < devices.size()) state.cause = devices[index->device].failure;
        }
        if (state.quality == now.quality && state.reason == now.reason &&
            value::same(state.value, now.value)) {
            if (state.sampled_at == now.sampled_at) continue;
            state.sampled_at = now.sampled_at;
            read_.push_back(slot);
            continue;
        }
        state.value = now.value;
        state.quality = now.quality;
        state.reason = now.reason;
        state.sampled_at = now.sampled_at;
        mark(slot);
    }
}

// Which slots are locals that start a read or a write.
std::vector<bool> LiveValues::triggers() const {
    std::vector<bool> result(states_.size());
    const auto add = [&](const std::optional<model::LocalIndex>& local) {
        if (local) result[configuration_->slots().local(*local).value] = true;
    };
    for (const auto& line : configuration_->project().lines)
        for (const auto& device : line.devices)
            for (const auto& variable : device.variables) {
                add(variable.read_trigger);
                add(variable.write_trigger);
            }
    return result;
}

file::Json LiveValues::entry(std::uint32_t slot, const WallTime& clock, bool trigger) const {
    const auto& state = states_[slot];
    const auto& info = configuration_->info({slot});
    const auto* const variable = configuration_->variable_of({slot});
    auto object = file::Json::object();
    object.set("name", info.name);
    const auto owner = configuration_->slots().owner({slot});
    if (const auto* const index = variable_index(owner)) set_variable(object, *configuration_, *index);
    object.set("type", name(info.type));
    object.set("unit", unit_of(info, variable));
    object.set("value", report::to_json(info.type, info.scaled, state.value));
    object.set("text", value::format(info.type, info.scaled, state.value));
    if (auto words = configuration_->value_words({slot}, state.value); !words.empty())
        object.set("words", std::move(words));
    object.set("quality", value::name(state.quality));
    object.set("reason", report::reason_word(state.reason));
    if (state.cause != value::Reason::ok && state.reason == value::Reason::not_answering)
        object.set("cause", report::reason_word(state.cause));
    object.set("sampled_at", state.sampled_at ? file::Json(clock.ms(*state.sampled_at)) : file::Json());
    object.set("writable", variable ? variable->write.has_value() : !info.service);
    object.set("trigger", trigger);
    object.set("local", info.local);
    return object;
}

std::string LiveValues::list_text(Instant t) const {
    const WallTime clock;
    const auto is_trigger = triggers();
    file::Json::Array values;
    values.reserve(states_.size());
    for (std::uint32_t slot = 0; slot < states_.size(); ++slot)
        values.push_back(entry(slot, clock, is_trigger[slot]));
    auto object = file::Json::object();
    object.set("generation", configuration_->generation());
    object.set("time", clock.ms(t));
    object.set("values", file::Json(std::move(values)));
    return object.dump();
}

std::string LiveValues::take_rows_text(Instant t) {
    const WallTime clock;
    file::Json::Array rows;
    rows.reserve(changed_.size());
    for (const auto slot : changed_) {
        is_changed_[slot] = false;
        const auto& state = states_[slot];
        const auto& info = configuration_->info({slot});
        file::Json::Array row;
        row.reserve(7);
        row.emplace_back(slot);
        row.push_back(report::to_json(info.type, info.scaled, state.value));
        row.emplace_back(value::format(info.type, info.scaled, state.value));
        row.emplace_back(value::name(state.quality));
        row.emplace_back(report::reason_word(state.reason));
        row.push_back(state.sampled_at ? file::Json(clock.ms(*state.sampled_at)) : file::Json());
        if (auto words = configuration_->value_words({slot}, state.value); !words.empty())
            row.emplace_back(std::move(words));
        rows.emplace_back(std::move(row));
    }
    changed_.clear();
    auto object = file::Json::object();
    object.set("time", clock.ms(t));
    object.set("values", file::Json(std::move(rows)));
    return object.dump();
}

std::string LiveValues::take_reads_text(Instant t) {
    const WallTime clock;
    file::Json::Array runs;
    const auto instant_of = [&](std::uint32_t slot) { return states_[slot].sampled_at; };
    for (std::size_t first = 0, next = 0; first < read_.size(); first = next) {
        const auto sampled_at = instant_of(read_[first]);
        next = first + 1;
        while (next < read_.size() && read_[next] == read_[next - 1] + 1 &&
               instant_of(read_[next]) == sampled_at)
            ++next;
        file::Json::Array run;
        run.push_back(sampled_at ? file::Json(clock.ms(*sampled_at)) : file::Json());
        run.emplace_back(read_[first]);
        run.emplace_back(read_[next - 1]);
        runs.emplace_back(std::move(run));
    }
    read_.clear();
    auto object = file::Json::object();
    object.set("time", clock.ms(t));
    object.set("reads", file::Json(std::move(runs)));
    return object.dump();
}

file::Json raw_json(const model::Variable& variable, const value::Value& value) {
    if (wire::is_bit_area(variable.area) || value::is_empty(value)) return {};
    const auto encoded = value::encode(value::layout_of(variable), value);
    if (!encoded) return {};
    auto list = file::Json::array();
    for (const auto word : encoded->registers) list.push_back(word);
    return list;
}

}  // namespace takt::web
