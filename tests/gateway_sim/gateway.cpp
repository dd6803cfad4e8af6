#include "gateway.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "project_text.hpp"
#include "sessions/snapshot_request.hpp"
#include "takt/base/assert.hpp"
#include "takt/publish/message_format.hpp"
#include "takt/publish/mqtt_composer.hpp"
#include "takt/publish/mqtt_work.hpp"
#include "takt/publish/output_slot.hpp"

namespace takt::gatewaysim {
namespace {

using namespace std::chrono_literals;

publish::MqttMessage state_topic(const publish::MqttComposer& composer, bool online) {
    publish::MqttMessage message{.topic = composer.control_topic("state"),
                                 .payload = publish::state_message(online)};
    message.retain = true;
    message.properties.content_type = "application/json";
    return message;
}

publish::SamplePolicy policy_of(const model::SamplingPolicy& policy) {
    return {.on_change = policy.on_change,
            .period = policy.period,
            .heartbeat = policy.heartbeat,
            .dead_band = policy.dead_band,
            .skip_bad = policy.skip_bad};
}

}  // namespace

Gateway::Gateway(const Scenario& scenario, const Clock& clock, Bus& bus, Disk& disk, Network& network,
                 GatewayObserver& observer, std::uint64_t random)
    : scenario_(scenario),
      clock_(clock),
      bus_(bus),
      disk_(disk),
      network_(network),
      observer_(observer),
      random_(random),
      run_(random_.next()),
      link_(std::make_shared<host::HostLink>(scenario.ring_words)),
      sampled_(std::numeric_limits<std::size_t>::max()),
      host_due_(clock.now),
      sampler_due_(clock.now),
      output_due_(clock.now) {
    make_engine();
    judge_session_ = open_session({.from_beginning = true});
    events_ = open_session({.from_beginning = true});
    SamplerOwner& owner = *this;
    sampler_.emplace(*events_, owner, [this](Instant t) { return clock_.wall_ns(t); }, clock_.now);
    make_output();
    bus_.start(clock_.now, *this);
    after_lines();
}

Gateway::~Gateway() {
    bus_.stop(clock_.now);
}

void Gateway::make_engine() {
    link_->add_configuration(scenario_.configuration);
    link_->generation = scenario_.configuration->generation();
    link_->on_posted = [this](const host::HostRequest& request) { on_posted(request); };
    host::ProjectEngine::Options options;
    options.started = options.restored_at = clock_.now;
    engine_ = std::make_unique<host::ProjectEngine>(*link_, scenario_.configuration, options);
    engine_->set_poke([this](std::size_t line) { bus_.poke(line, clock_.now); });
}

std::unique_ptr<host::Session> Gateway::open_session(const host::SessionOptions& options) {
    const auto id = link_->open_session();
    TAKT_ASSERT(id != 0);
    return std::make_unique<host::Session>(link_, id, options);
}

// A session waits for its snapshot; a command is served when the I/O thread gets to it.
void Gateway::on_posted(const host::HostRequest& request) {
    if (dynamic_cast<const host::SnapshotFill*>(&request) == nullptr) {
        requests_due_ = std::min(requests_due_, clock_.now + random_.between(0ms, 2ms));
        return;
    }
    while (engine_->serve(clock_.now)) {}
    publish();
}

void Gateway::make_output() {
    const auto& output = scenario_.configuration->project().outputs.at(0);
    publish::OutputEngine::Options options;
    options.name = output.name;
    options.journal = scenario_.journal;
    options.queue_bytes = scenario_.queue_bytes;
    options.open_storage = [this]() -> Result<std::unique_ptr<store::JournalStorage>> {
        return disk_.connect();
    };
    options.wall_ns = [this](Instant t) { return clock_.wall_ns(t); };
    output_ = std::make_unique<publish::OutputEngine>(std::move(options), make_work());
}

std::unique_ptr<publish::OutputWork> Gateway::make_work() {
    const auto& output = scenario_.configuration->project().outputs.at(0);
    auto composer = std::make_unique<publish::MqttComposer>(output, *scenario_.configuration);
    publish::MqttWork::Options work;
    work.session = scenario_.session;
    for (const auto& broker : output.mqtt.brokers)
        work.session.brokers.push_back({.host = broker.host, .port = broker.port, .tls = {}});
    work.session.client_id = output.mqtt.client_id;
    work.session.birth = state_topic(*composer, true);
    work.session.will = state_topic(*composer, false);
    work.session.seed ^= run_;
    work.status_topic = composer->control_topic("status");
    work.composer = std::move(composer);
    work.pipe = network_.connect();
    work.host = open_session({.events = false});
    output_session_ = work.host->id();
    work.wall_ns = [this](Instant t) { return clock_.wall_ns(t); };
    if (!output.commandable.empty()) {
        const std::string topic = output.mqtt.control_topic;
        work.session.subscriptions = {{.filter = topic + "/command"}, {.filter = topic + "/set/#"}};
        publish::CommandDeskOptions desk{.output = output.name,
                                         .control_topic = topic,
                                         .expiry = output.command_expiry,
                                         .id_prefix = "run" + std::to_string(run_) + "-",
                                         .audit = [this](std::string_view line) {
                                             observer_.on_audit(line);
                                             return true;
                                         }};
        work.commands.emplace(publish::MqttWork::Commands{
            .desk = publish::CommandDesk(std::move(desk)),
            .rights = [](const host::ConfigurationPtr& configuration) {
                return publish::rights_of(configuration, configuration->project().outputs.at(0));
            }});
    }
    return std::make_unique<publish::MqttWork>(std::move(work));
}

std::vector<publish::SampleFeed*> Gateway::on_configuration(Instant now,
                                                            const host::ConfigurationPtr& configuration) {
    const auto& output = configuration->project().outputs.at(0);
    std::vector<publish::SelectedSlot> selected;
    for (const auto& value : output.values)
        selected.push_back({publish::slot_of(configuration->slots(), value.subject),
                            policy_of(output.selections.at(value.selection).policy)});
    feed_ =
        std::make_unique<publish::SampleFeed>(publish::series_of(*configuration), selected, sampled_, now);
    return {feed_.get()};
}

void Gateway::on_enqueued(std::size_t) {}

void Gateway::on_state_changed() {
    state_changed_ = true;
    wake_output();
}

// As the driver's listener does.
void Gateway::on_link(Instant t, std::size_t line, bool up) {
    engine_->master().line(line).on_link(t, up);
    const auto why = up ? std::nullopt : std::optional(fail(Code::connection_lost, "line").error());
    engine_->on_link(t, line, up, why);
}

void Gateway::after_lines() {
    publish();
}

void Gateway::publish() {
    engine_->publish(clock_.now);
    while (const auto event = judge_session_->next_event()) observer_.on_host_event(*event);
    const auto events = link_->events.end().next;
    if (std::exchange(events_seen_, events) != events) wake_sampler();
    if (!link_->slot(output_session_).outcomes.empty()) wake_output();
}

Duration Gateway::latency() {
    return random_.below(100) == 0 ? random_.between(0ms, 100ms) : random_.between(0ms, 1ms);
}

void Gateway::wake_sampler() {
    if (sampler_due_ > clock_.now) sampler_due_ = std::min(sampler_due_, clock_.now + latency());
}

void Gateway::wake_output() {
    if (output_due_ > clock_.now) output_due_ = std::min(output_due_, clock_.now + latency());
}

Instant Gateway::next_step() const {
    const Instant sampler = std::max(sampler_due_, sampler_stalled_);
    const Instant output = std::max(std::min(output_due_, network_.next_for_gateway()), output_stalled_);
    if (stopping_) return output;
    return std::min({host_due_, requests_due_, sampler, output});
}

bool Gateway::step() {
    const Instant now = clock_.now;
    if (!stopping_ && std::min(host_due_, requests_due_) <= now) step_host();
    if (!stopping_ && std::max(sampler_due_, sampler_stalled_) <= now) step_sampler();
    if (std::max(std::min(output_due_, network_.next_for_gateway()), output_stalled_) > now) return false;
    step_output();
    return true;
}

void Gateway::step_host() {
    if (host_due_ <= clock_.now) {
        engine_->on_tick(clock_.now);
        host_due_ = engine_->next_tick(clock_.now);
    }
    if (requests_due_ <= clock_.now) {
        requests_due_ = kNever;
        while (engine_->serve(clock_.now)) {}
    }
    publish();
}

void Gateway::step_sampler() {
    sampler_due_ = kNever;
    observer_.before_sampling();
    sampler_->step(clock_.now);
    move_queue();
    observer_.after_sampling();
    sampler_due_ = std::min(sampler_due_, std::max(sampler_->next_wakeup(), clock_.now + 100us));
}

// The feed's own queue has no limit, so that the judge sees each sample before it may be lost.
void Gateway::move_queue() {
    while (auto samples = sampled_.take()) {
        const bool lost = samples->payload.empty();
        const bool fits = lost || output_->queue().bytes() + samples->payload.size() <= scenario_.queue_bytes;
        observer_.on_queued(*samples, fits);
        const bool wake =
            lost ? output_->queue().push_loss(samples->samples, samples->first_wall_ns, samples->last_wall_ns)
                 : output_->queue().push(*std::move(samples));
        if (wake) wake_output();
    }
}

void Gateway::step_output() {
    output_due_ = kNever;
    if (std::exchange(state_changed_, false)) output_->on_state_changed(clock_.now);
    output_->step(clock_.now);
    const auto busy = disk_.take_busy_time();
    if (busy > Duration{}) output_stalled_ = std::max(output_stalled_, clock_.now + busy);
    if (output_->finished(clock_.now)) {
        output_->close(clock_.now);
        stopped_ = true;
        return;
    }
    output_due_ = std::min(output_due_, std::max(output_->next_wakeup(), clock_.now + 100us));
}

// The host ends first, then the sampling, then the output.
void Gateway::begin_stop() {
    if (std::exchange(stopping_, true)) return;
    bus_.stop(clock_.now);
    link_->stopped = true;
    while (engine_->serve(clock_.now)) {}
    engine_->finish(clock_.now);
    publish();
    sampler_->finish(clock_.now);
    move_queue();
    output_->stop();
    output_due_ = clock_.now;
}

}  // namespace takt::gatewaysim
