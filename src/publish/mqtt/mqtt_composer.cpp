#include "takt/publish/mqtt_composer.hpp"

#include <algorithm>
#include <utility>

#include "mqtt/mqtt_packet.hpp"
#include "takt/publish/output_slot.hpp"

namespace takt::publish {

MqttComposer::MqttComposer(const model::Output& output, const host::Configuration& configuration)
    : name_(output.name),
      control_topic_(output.mqtt.control_topic),
      joins_(output.mqtt.backlog == model::Backlog::array),
      fallback_(output.selections.at(0)) {
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

void MqttComposer::compose(std::span<const RecordSamples> portion, const StreamPlace& place,
                           std::vector<ComposedMessage>& out) {
    groups_.clear();
    for (const auto& [batch, first] : portion) {
        open_.clear();
        for (std::size_t i = 0; i < batch.samples.size(); ++i) {
            const auto& sample = batch.samples[i];
            const auto& series = batch.series[sample.series];
            add_to_group(route_of(series), {&series, &sample, first + i});
        }
    }
    if (place.packet_limit != kNoPacketLimit) split_groups(place);
    make_parcels(place);
    too_large_.reset();
    for (const auto& parcel : parcels_) {
        if (const auto& group = groups_[parcel.front()]; group.too_large) {
            add_missing(group.samples.front(), place, out);
            continue;
        }
        add_gap(place, out);
        out.push_back(message_of(parcel, place, out.size() < place.repeated));
    }
    add_gap(place, out);
}

void MqttComposer::make_parcels(const StreamPlace& place) {
    parcels_.clear();
    std::map<std::string_view, Parcel> waiting;  // that may be joined, by topic
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        const auto& group = groups_[i];
        if (joins_ && !group.route->retain && !group.too_large)
            waiting[group.route->topic].push_back(i);
        else
            parcels_.push_back({i});
    }
    if (waiting.empty()) return;
    for (auto& [topic, groups] : waiting) {
        parcels_.push_back({groups.back()});
        groups.pop_back();
        join_groups(groups, place);
    }
    std::ranges::sort(parcels_, {}, [](const Parcel& parcel) { return parcel.front(); });
}

// Sizes are those of repeated messages of MQTT 5, as in split_groups().
void MqttComposer::join_groups(const Parcel& groups, const StreamPlace& place) {
    const std::size_t limit = place.packet_limit == kNoPacketLimit ? kLongestArray : place.packet_limit;
    constexpr std::size_t kLengths = 3 + 3;  // the fields of an empty packet and its payload grow by at most
    std::size_t bytes = limit;               // of the packet; so the first group begins a parcel
    for (const auto index : groups) {
        const auto& group = groups_[index];
        auto message = message_of(*group.route, group.samples, place, true);
        const auto payload = message.payload.size() + 1;  // with a comma
        if (bytes + payload > limit) {
            message.payload.clear();
            bytes = publish_packet_size(message, MqttVersion::v5) + kLengths;
            parcels_.emplace_back();
        }
        bytes += payload;
        parcels_.back().push_back(index);
    }
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

ComposedMessage MqttComposer::message_of(const Parcel& parcel, const StreamPlace& place,
                                         bool repeated) const {
    ComposedMessage composed;
    for (const auto index : parcel) {
        const auto& group = groups_[index];
        auto message = message_of(*group.route, group.samples, place, repeated);
        composed.samples += group.samples.size();
        if (parcel.size() == 1) {
            composed.message = std::move(message);
        } else if (composed.message.topic.empty()) {
            composed.message = std::move(message);
            composed.message.payload.insert(0, 1, '[');
        } else {
            composed.message.payload.append(",").append(message.payload);
        }
    }
    if (parcel.size() > 1) composed.message.payload += ']';
    return composed;
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
