#include "takt/publish/mqtt_composer.hpp"

#include <algorithm>

#include "takt/publish/output_slot.hpp"

namespace takt::publish {

MqttComposer::MqttComposer(const model::Output& output, const host::Configuration& configuration)
    : name_(output.name), control_topic_(output.mqtt.control_topic), fallback_(output.selections.at(0)) {
    for (const auto& value : output.values) {
        const auto slot = slot_of(configuration.slots(), value.subject);
        const auto* const device = configuration.device_of(slot);
        const auto& selection = output.selections.at(value.selection);
        routes_[{device != nullptr ? device->name : "", configuration.info(slot).name}] = {
            value.topic, selection.message, selection.retain};
    }
}

const MqttComposer::Route& MqttComposer::route_of(const Series& series) {
    const auto [route, is_new] = routes_.try_emplace({series.device, series.variable});
    if (is_new) {
        const bool local = series.device.empty();
        route->second = {fallback_.topic.expand({.output = name_,
                                                 .line = local ? model::kLocalsInTopics : series.line,
                                                 .device = local ? model::kLocalsInTopics : series.device,
                                                 .variable = series.variable}),
                         fallback_.message, fallback_.retain};
    }
    return route->second;
}

void MqttComposer::add_to_group(const Route& route, const PlacedSample& sample) {
    const auto open = open_.find(route.topic);
    if (open != open_.end() && route.scope != model::MessageScope::variable) {
        auto& samples = groups_[open->second].samples;
        const bool has_variable =
            std::ranges::any_of(samples, [&](const auto& other) { return other.series == sample.series; });
        const bool same_read = samples.front().sample->wall_ns == sample.sample->wall_ns;
        if (!has_variable && (same_read || route.scope == model::MessageScope::device)) {
            samples.push_back(sample);
            return;
        }
    }
    open_[route.topic] = groups_.size();
    groups_.push_back({&route, {sample}});
}

void MqttComposer::compose(const SampleBatch& batch, const StreamPlace& place,
                           std::vector<ComposedMessage>& out) {
    groups_.clear();
    open_.clear();
    for (std::size_t i = 0; i < batch.samples.size(); ++i) {
        const auto& sample = batch.samples[i];
        const auto& series = batch.series[sample.series];
        add_to_group(route_of(series), {&series, &sample, place.first + i});
    }
    for (const auto& [route, samples] : groups_) {
        const bool repeated = out.size() < place.repeated;
        ComposedMessage composed;
        composed.samples = samples.size();
        composed.message.topic = route->topic;
        composed.message.retain = route->retain;
        composed.message.properties.content_type = "application/json";
        composed.message.payload = route->scope == model::MessageScope::variable
                                       ? variable_message(samples.front(), place.epoch, repeated)
                                       : group_message(samples, place.epoch, repeated);
        out.push_back(std::move(composed));
    }
}

void MqttComposer::compose(const store::Gap& gap, const StreamPlace& place,
                           std::vector<ComposedMessage>& out) {
    ComposedMessage composed;
    composed.message.topic = control_topic("gap");
    composed.message.properties.content_type = "application/json";
    composed.message.payload = gap_message(gap, place.first, place.epoch, place.repeated > 0);
    out.push_back(std::move(composed));
}

std::string MqttComposer::control_topic(std::string_view last_level) const {
    return control_topic_ + "/" + std::string(last_level);
}

}  // namespace takt::publish
