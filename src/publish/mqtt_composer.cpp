#include "takt/publish/mqtt_composer.hpp"

#include <algorithm>

#include "mqtt_packet.hpp"
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
    if (place.packet_limit != kNoPacketLimit) split_groups(place);
    too_large_.reset();
    for (const auto& group : groups_) {
        if (group.too_large) {
            add_missing(group.samples.front(), place, out);
            continue;
        }
        add_gap(place, out);
        out.push_back({.message = message_of(*group.route, group.samples, place, out.size() < place.repeated),
                       .samples = group.samples.size()});
    }
    add_gap(place, out);
}

// Halves each message that the broker does not take. Sizes are those of a repeated message, which is the
// longer one: a record then has the same messages each time.
void MqttComposer::split_groups(const StreamPlace& place) {
    const auto fits = [&](const Group& group) {
        const auto message = message_of(*group.route, group.samples, place, true);
        return publish_packet_size(message, place.version) <= place.packet_limit;
    };
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        while (!fits(groups_[i])) {
            auto& samples = groups_[i].samples;
            groups_[i].too_large = samples.size() == 1;
            if (groups_[i].too_large) break;
            const auto half = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
            Group rest{.route = &route_of(*half->series), .samples = {half, samples.end()}};
            samples.erase(half, samples.end());
            groups_.push_back(std::move(rest));
        }
    }
    std::ranges::sort(groups_, {}, [](const Group& group) { return group.samples.front().number; });
}

MqttMessage MqttComposer::message_of(const Route& route, std::span<const PlacedSample> samples,
                                     const StreamPlace& place, bool repeated) {
    MqttMessage message{.topic = route.topic};
    message.retain = route.retain;
    message.properties.content_type = "application/json";
    message.payload = route.scope == model::MessageScope::variable
                          ? variable_message(samples.front(), place.epoch, repeated)
                          : group_message(samples, place.epoch, repeated);
    return message;
}

/// Joins samples that follow each other to one gap.
void MqttComposer::add_missing(const PlacedSample& sample, const StreamPlace& place,
                               std::vector<ComposedMessage>& out) {
    const auto wall_ns = sample.sample->wall_ns;
    if (too_large_ && too_large_->first_number + too_large_->samples != sample.number) add_gap(place, out);
    if (!too_large_)
        too_large_ = MissingSamples{.cause = "too_large",
                                    .first_number = sample.number,
                                    .first_wall_ns = wall_ns,
                                    .last_wall_ns = wall_ns};
    ++too_large_->samples;
    too_large_->first_wall_ns = std::min(too_large_->first_wall_ns, wall_ns);
    too_large_->last_wall_ns = std::max(too_large_->last_wall_ns, wall_ns);
}

void MqttComposer::add_gap(const StreamPlace& place, std::vector<ComposedMessage>& out) {
    const auto missing = std::exchange(too_large_, {});
    if (missing)
        out.push_back(
            {.message = gap_of(*missing, place, out.size() < place.repeated), .too_large = missing->samples});
}

MqttMessage MqttComposer::gap_of(const MissingSamples& missing, const StreamPlace& place,
                                 bool repeated) const {
    MqttMessage message{.topic = control_topic("gap")};
    message.properties.content_type = "application/json";
    message.payload = gap_message(missing, place.epoch, repeated);
    return message;
}

void MqttComposer::compose(const store::Gap& gap, const StreamPlace& place,
                           std::vector<ComposedMessage>& out) {
    const MissingSamples missing{.cause = store::name(gap.cause),
                                 .samples = gap.samples,
                                 .first_number = place.first,
                                 .first_wall_ns = gap.first_wall_ns,
                                 .last_wall_ns = gap.last_wall_ns};
    out.push_back({.message = gap_of(missing, place, place.repeated > 0)});
}

std::string MqttComposer::control_topic(std::string_view last_level) const {
    return control_topic_ + "/" + std::string(last_level);
}

}  // namespace takt::publish
