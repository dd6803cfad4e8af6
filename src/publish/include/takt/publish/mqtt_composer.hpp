// The messages of an MQTT output: which samples go together, and to which topic.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/host/configuration.hpp"
#include "takt/model/output.hpp"
#include "takt/publish/journal_messages.hpp"
#include "takt/publish/message_format.hpp"

namespace takt::publish {

/// Composes by the settings of an output. A sample of a variable that the output does not have any more goes
/// to the topic of the first selection's template.
///
/// Messages are in the order of their first samples. One message has each variable once, so the messages of a
/// variable are in the order of its samples. A message that the broker does not take for its size is split; a
/// gap with the cause `too_large` replaces samples that are too large alone.
///
/// With model::Backlog::array the messages of a portion with one topic that is not retained are joined to
/// JSON arrays, up to the limit of a packet; the last one stays alone.
class MqttComposer final : public MessageComposer {
public:
    MqttComposer(const model::Output& output, const host::Configuration& configuration);

    /// Bytes of a packet with an array, where the broker announces no limit.
    static constexpr std::size_t kLongestArray = std::size_t{64} << 10U;

    [[nodiscard]] bool joins_records() const override { return joins_; }
    void compose(std::span<const RecordSamples> portion, const StreamPlace& place,
                 std::vector<ComposedMessage>& out) override;
    void compose(const store::Gap& gap, const StreamPlace& place, std::vector<ComposedMessage>& out) override;

    /// A topic of the output itself: one of model::control_levels() below its control topic.
    [[nodiscard]] std::string control_topic(std::string_view last_level) const;

private:
    struct Route {
        std::string topic;
        model::MessageScope scope = model::MessageScope::variable;
        bool retain = true;
        friend bool operator==(const Route&, const Route&) = default;
    };
    /// Samples of one message.
    struct Group {
        const Route* route = nullptr;
        std::vector<PlacedSample> samples;
        bool too_large = false;  // one sample, which no packet can carry
    };

    /// Groups of one topic that travel together: their indices.
    using Parcel = std::vector<std::size_t>;

    [[nodiscard]] const Route& route_of(const Series& series);
    void add_to_group(const Route& route, const PlacedSample& sample);
    void split_groups(const StreamPlace& place);
    void make_parcels(const StreamPlace& place);
    void join_groups(const Parcel& groups, const StreamPlace& place);
    [[nodiscard]] ComposedMessage message_of(const Parcel& parcel, const StreamPlace& place,
                                             bool repeated) const;
    void add_missing(const PlacedSample& sample, const StreamPlace& place, std::vector<ComposedMessage>& out);
    void add_gap(const StreamPlace& place, std::vector<ComposedMessage>& out);
    [[nodiscard]] static MqttMessage message_of(const Route& route, std::span<const PlacedSample> samples,
                                                const StreamPlace& place, bool repeated);
    [[nodiscard]] MqttMessage gap_of(const MissingSamples& missing, const StreamPlace& place,
                                     bool repeated) const;

    std::string name_;
    std::string control_topic_;
    bool joins_ = false;
    model::OutputSelection fallback_;
    std::map<std::pair<std::string, std::string>, Route> routes_;  // by device and variable
    std::vector<Group> groups_;                                    // scratch, the messages of one portion
    std::vector<Parcel> parcels_;                                  // scratch
    std::map<std::string_view, std::size_t> open_;                 // scratch, by topic: the group that grows
    std::optional<MissingSamples> too_large_;                      // scratch, not among the messages yet
};

}  // namespace takt::publish
