#include "judge.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "../project_text.hpp"
#include "../trace.hpp"
#include "takt/publish/sample_codec.hpp"

namespace takt::gatewaysim {

using namespace publish;  // NOLINT(*-using-namespace): the types of the port

Judge::Judge(const Scenario& scenario, const Clock& clock, Complaints& complaints)
    : clock_(clock),
      complaints_(complaints),
      journal_(account_, clock, scenario, complaints),
      stream_(account_, journal_, clock, scenario, complaints),
      sampling_(clock, scenario, complaints),
      commands_(clock, scenario, complaints),
      mode_(scenario.configuration->find(kMode)) {
    journal_.set_deliveries(stream_);
}

void Judge::on_run_begin(Disk& disk, bool damaged) {
    account_.begin_run(clock_.now);
    journal_.on_run_begin(disk, damaged);
    sampling_.on_run_begin();
    commands_.on_run_begin();
    connection_ = {};
    last_connection_ = last_token_ = 0;
    complaints_.count("run");
}

void Judge::on_queued(const QueuedSamples& samples, bool fits) {
    Unit unit{.queued = samples, .pushed = clock_.now, .did_not_fit = !fits};
    if (!samples.payload.empty()) {
        auto batch = decode_samples(samples.payload);
        if (!batch || batch->samples.size() != samples.samples)
            return fail("content_true", "samples that can be decoded", "others");
        unit.batch = *std::move(batch);
    }
    // The times are those of the samples.
    std::int64_t first = samples.first_wall_ns;
    std::int64_t last = samples.last_wall_ns;
    for (std::size_t i = 0; i < unit.batch.samples.size(); ++i) {
        const auto wall = unit.batch.samples[i].wall_ns;
        first = i == 0 ? wall : std::min(first, wall);
        last = i == 0 ? wall : std::max(last, wall);
    }
    if (first != samples.first_wall_ns || last != samples.last_wall_ns)
        fail("gap_true", "the times of the oldest and the newest sample", "others");
    complaints_.trace(clock_.now, [&] {
        return "sampled " + std::to_string(samples.samples) + (samples.payload.empty() ? ", lost" : "") +
               (fits ? "" : ", queue full");
    });
    complaints_.count(samples.payload.empty() ? "source_lost" : "sampled", samples.samples);
    if (!fits) complaints_.count("queue_full");
    Unit& added = account_.add(std::move(unit));
    sampling_.on_unit(added);
    if (!fits) {
        added.batch = {};
        added.queued.payload.clear();
    }
    journal_.on_pushed(added);
}

const JournalJudge::Entry* Judge::partly_delivered() const {
    const auto delivered = stream_.delivered_through();
    const auto* record = journal_.record_of_sample(delivered + 1);
    if (record == nullptr || !record->present || record->doubtful || record->facts.gap) return nullptr;
    const bool durable = record->state == JournalJudge::State::durable;
    return durable && record->facts.samples_before < delivered && record->facts.end() > delivered ? record
                                                                                                  : nullptr;
}

void Judge::on_host_event(const host::Event& event) {
    sampling_.on_event(event);
    const auto* changed = std::get_if<host::ValueChanged>(&event.body);
    if (changed == nullptr || !mode_ || changed->slot != *mode_) return;
    const auto* number = std::get_if<std::uint64_t>(&changed->value);
    if (number != nullptr) commands_.on_executed(static_cast<std::uint32_t>(*number), event.t);
}

// sampled = delivered + waiting + dropped, and sampled is what the judge has counted.
void Judge::on_status(const OutputStatus& status) {
    const auto& samples = status.samples;
    const auto text = [&] {
        return std::to_string(samples.delivered) + " + " + std::to_string(samples.waiting) + " + " +
               std::to_string(samples.dropped) + " of " + std::to_string(samples.sampled);
    };
    if (samples.sampled != samples.delivered + samples.waiting + samples.dropped)
        fail("conserved", "sampled = delivered + waiting + dropped", text());
    const Run& run = account_.current();
    if (run.epoch == 0 || journal_.was_damaged()) return;
    if (samples.sampled != run.base + run.total)
        fail("conserved", "sampled = " + std::to_string(run.base + run.total), text());
}

bool Judge::is_of_stream(const std::string& topic) {
    const std::string control = std::string(kControlTopic) + "/";
    if (topic == control + "gap") return true;
    for (const char* level : {"state", "status", "answer"})
        if (topic == control + level) return false;
    return true;
}

void Judge::on_written(std::uint32_t value, Instant ordered_at) {
    hash_.add(clock_.now);
    hash_.add(std::uint64_t{value});
    complaints_.trace(clock_.now, [&] { return "device: written " + std::to_string(value); });
    commands_.on_executed(value, ordered_at);
}

void Judge::on_action(const MqttAction& action) {
    complaints_.trace(clock_.now, [&] { return text_of(action); });
    std::visit([this](const auto& its) { on(its); }, action);
}

void Judge::on(const MqttConnect& connect) {
    if (connection_.exists)
        fail("connections_apart", "no connection before the last one is closed",
             "connection " + std::to_string(connect.connection));
    if (connect.connection <= last_connection_)
        fail("connections_apart", "a number above " + std::to_string(last_connection_),
             std::to_string(connect.connection));
    last_connection_ = connect.connection;
    connection_ = {.id = connect.connection, .exists = true};
}

void Judge::on(const MqttSubscribe& subscribe) {
    connection_.subscribe_token = subscribe.token;
    last_token_ = std::max(last_token_, subscribe.token);
}

void Judge::on(const MqttDisconnect& /*disconnect*/) {
    connection_.left = true;
    commands_.on_left();
}

void Judge::on(const MqttPublish& publish) {
    check_packet(publish);
    const auto& message = publish.message;
    hash_.add(clock_.now);
    hash_.add({reinterpret_cast<const std::uint8_t*>(message.payload.data()), message.payload.size()});
    if (message.qos > 0) connection_.in_flight.insert(publish.token);
    const bool birth = message.topic == std::string(kControlTopic) + "/state";
    if (!connection_.born && !birth)
        fail("birth_first", "the state `online` as the first message of a connection", message.topic);
    connection_.born = true;
    if (commands_.is_answer(message)) return commands_.on_answer(message);
    if (is_of_stream(message.topic)) stream_.on_published(publish);
}

void Judge::check_packet(const MqttPublish& publish) {
    const auto& message = publish.message;
    if (publish.connection != connection_.id || !connection_.open)
        fail("connections_apart", "messages on an open connection only", message.topic);
    if (publish.token <= last_token_)
        fail("connections_apart", "a token above " + std::to_string(last_token_),
             std::to_string(publish.token));
    last_token_ = std::max(last_token_, publish.token);
    if (message.qos > connection_.limits.maximum_qos)
        fail("limits_kept", "QoS " + std::to_string(connection_.limits.maximum_qos),
             std::to_string(message.qos));
    if (message.retain && !connection_.limits.retain_available)
        fail("limits_kept", "no retained message", message.topic);
    const auto packet = connection_.limits.maximum_packet;
    if (packet && message.topic.size() + message.payload.size() > *packet)
        fail("limits_kept", "packets of at most " + std::to_string(*packet) + " bytes", message.topic);
    if (message.qos > 0 && connection_.in_flight.size() >= connection_.limits.receive_maximum)
        fail("limits_kept",
             std::to_string(connection_.limits.receive_maximum) + " messages in flight at most", "one more");
}

void Judge::on_event(const MqttEvent& event) {
    complaints_.trace(clock_.now, [&] { return text_of(event); });
    std::visit([this](const auto& its) { on(its); }, event);
}

void Judge::on(const MqttConnected& connected) {
    connection_.open = true;
    connection_.limits = connected;
    stream_.on_connection(connected);
}

void Judge::on(const MqttClosed& /*closed*/) {
    connection_.exists = connection_.open = connection_.subscribed = false;
    stream_.on_connection({});
}

void Judge::on(const MqttAcknowledged& acknowledged) {
    connection_.in_flight.erase(acknowledged.token);
    stream_.on_acknowledged(acknowledged);
}

void Judge::on(const MqttSubscribed& subscribed) {
    if (subscribed.token != connection_.subscribe_token) return;
    connection_.subscribed = std::ranges::none_of(subscribed.reasons, is_failure);
}

void Judge::on(const MqttReceived& received) {
    // The session ignores commands whose outcome it could not publish.
    if (!connection_.left) commands_.on_delivered(received.message, connection_.subscribed);
}

void Judge::on_received(MqttConnectionId /*connection*/, MqttToken token, const MqttMessage& message) {
    if (is_of_stream(message.topic)) stream_.on_received(token);
}

// After an orderly end with a disk that works, all that was sampled is on the disk.
void Judge::on_run_end(bool orderly) {
    const Run& run = account_.current();
    if (!orderly || run.epoch == 0) return;
    if (journal_.durable_samples() != run.base + run.total)
        fail("stop_keeps_all", "all " + std::to_string(run.base + run.total) + " samples are durable",
             std::to_string(journal_.durable_samples()));
}

void Judge::check_progress(Instant sampled_before) {
    const Run& run = account_.current();
    std::uint64_t due = run.base;
    for (const Unit& unit : run.units)
        if (unit.pushed < sampled_before) due = run.base + unit.offset + unit.count();
    const auto delivered = stream_.delivered_through();
    if (run.epoch == 0 || delivered < due)
        fail("progress", "all samples up to " + std::to_string(due) + " are delivered by now",
             std::to_string(delivered));
}

void Judge::finish(Instant commands_from, Instant commands_until) {
    stream_.finish(stream_.delivered_through());
    commands_.finish(commands_from, commands_until);
}

}  // namespace takt::gatewaysim
