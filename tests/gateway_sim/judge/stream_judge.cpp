#include "stream_judge.hpp"

#include <algorithm>
#include <utility>

#include "takt/publish/output_slot.hpp"

namespace takt::gatewaysim {
namespace {

using publish::MqttReason;

std::string message_text(const SeenMessage& message) {
    if (message.gap)
        return "gap " + message.gap->cause + " of " + std::to_string(message.gap->samples) + " from " +
               std::to_string(message.gap->number) + " on, epoch " + std::to_string(message.epoch);
    return "sample " + std::to_string(message.samples.front().number) + " of epoch " +
           std::to_string(message.epoch) + ", " + message.samples.front().variable;
}

std::uint64_t start_of(const SeenMessage& message) {
    return message.gap ? message.gap->number : message.samples.front().number;
}

}  // namespace

StreamJudge::StreamJudge(Account& account, const JournalJudge& journal, const Clock& clock,
                         const Scenario& scenario, Complaints& complaints)
    : account_(account), journal_(journal), clock_(clock), scenario_(scenario), complaints_(complaints) {
    const auto& configuration = *scenario.configuration;
    const auto& output = configuration.project().outputs.at(0);
    for (const auto& value : output.values) {
        const auto& selection = output.selections.at(value.selection);
        const auto slot = publish::slot_of(configuration.slots(), value.subject);
        routes_[configuration.info(slot).name] = {value.topic, selection.retain};
    }
    limited_ = output.mqtt.backlog == model::Backlog::array;
    for (const auto& broker : scenario.brokers) limited_ = limited_ || broker.limits.maximum_packet;
}

void StreamJudge::on_connection(const publish::MqttConnected& limits) {
    begin_pass();
    broker_retains_ = limits.retain_available;
    packet_limit_ = limits.maximum_packet;
    sent_.clear();
}

void StreamJudge::begin_pass() {
    ++pass_;
    last_start_ = 0;
    refused_ = false;
    advance_finished();
    due_ = finished_ + 1;
}

void StreamJudge::on_published(const publish::MqttPublish& publish) {
    const auto message = read_message(publish.message.payload);
    if (!message) return fail("content_true", "a message of samples or of a gap", publish.message.payload);
    check_topic(publish.message, *message);
    for (const auto& sample : message->samples) {
        check_sample(*message, sample);
        check_durable(sample.number);
    }
    if (message->gap) check_gap(*message);
    check_order(*message);
    check_repeated(*message);
    mark_sent(*message);
    sent_[publish.token] = {*message, publish.message.qos > 0, std::exchange(restarts_, {})};
    complaints_.count(message->gap ? "gaps_published" : "samples_published",
                      message->gap ? 1 : message->samples.size());
    if (message->gap) complaints_.count("published_gap_" + message->gap->cause);
    if (message->repeated) complaints_.count("repeated");
}

void StreamJudge::check_topic(const publish::MqttMessage& message, const SeenMessage& seen) {
    for (const auto& sample : seen.samples)
        if (const auto& route = routes_[sample.variable]; message.topic != route.topic)
            fail("content_true", "a message at " + route.topic, "one at " + message.topic);
    const bool retain = !seen.gap && routes_[seen.samples.front().variable].retain && broker_retains_;
    if (message.retain != retain)
        fail("content_true", std::string(retain ? "a" : "no") + " retained message", message.topic);
}

void StreamJudge::check_sample(const SeenMessage& message, const SeenSample& sample) {
    const Run* run = account_.run_of(message.epoch);
    const Unit* unit = run ? run->unit_of(sample.number) : nullptr;
    if (unit == nullptr || unit->lost() || (run->end && sample.number > *run->end))
        return fail("content_true", "a sample that was taken", message_text(message));
    const auto& facts = unit->batch.samples[sample.number - run->base - 1 - unit->offset];
    const auto& series = unit->batch.series[facts.series];
    auto wrong = difference(sample.fields, series, facts);
    if (series.variable != sample.variable || series.device != message.device)
        wrong = "the variable: " + series.variable + " of " + series.device + " became " + sample.variable +
                " of " + message.device;
    if (!wrong.empty()) fail("content_true", "the sampled values", message_text(message) + ": " + wrong);
}

void StreamJudge::check_durable(std::uint64_t number) {
    if (number > journal_.durable_samples())
        fail("durable_first",
             "only what is durable is published: samples up to " + std::to_string(journal_.durable_samples()),
             "sample " + std::to_string(number));
}

// A pass takes the samples in their order and leaves out none that is not finished.
void StreamJudge::check_order(const SeenMessage& message) {
    const auto start = start_of(message);
    const bool again = start < last_start_ || (start == last_start_ && !last_was_empty_);
    if (last_start_ != 0 && again) {
        if (!refused_)
            return fail("order_kept", "a message behind the one from " + std::to_string(last_start_),
                        message_text(message));
        begin_pass();
    }
    for (; due_ < start; ++due_) {
        const bool in_pass = due_ <= samples_.size() && samples_[due_ - 1].last_pass == pass_;
        if (in_pass || is_finished(due_)) continue;
        fail("order_kept", "sample " + std::to_string(due_) + " or a gap in its place",
             message_text(message));
        break;
    }
    last_start_ = start;
    last_was_empty_ = message.gap && message.gap->samples == 0;
}

// What was sent before has the mark. A sample that was not has none, unless an earlier run may have sent it.
void StreamJudge::check_repeated(const SeenMessage& message) {
    const auto run = account_.current().number;
    if (gaps_run_ != run) gaps_.clear();
    gaps_run_ = run;
    bool sent_by_run = false;
    for (const auto& sample : message.samples) sent_by_run = sent_by_run || at(sample.number).last_run == run;
    if (message.gap)
        sent_by_run = std::ranges::any_of(gaps_, [&](const SentGap& sent) {
            return sent.epoch == message.epoch && sent.gap == *message.gap;
        });
    if (sent_by_run && !message.repeated)
        fail("repeat_marked", "the mark `repeated`: this run has sent it before", message_text(message));
    const bool may_be = limited_ || message.gap || message.epoch != account_.current().epoch;
    if (!sent_by_run && message.repeated && !may_be)
        fail("repeat_marked", "no mark `repeated`: it was not sent before", message_text(message));
}

void StreamJudge::mark_sent(const SeenMessage& message) {
    const auto run = account_.current().number;
    for (const auto& sample : message.samples) {
        at(sample.number).fate |= kSent;
        at(sample.number).last_run = run;
        at(sample.number).last_pass = pass_;
    }
    if (!message.gap) return;
    gaps_.push_back({message.epoch, *message.gap});
    for (std::uint64_t i = 0; i < message.gap->samples; ++i) at(message.gap->number + i).last_pass = pass_;
}

void StreamJudge::on_acknowledged(const publish::MqttAcknowledged& acknowledged) {
    const auto found = sent_.find(acknowledged.token);
    if (found == sent_.end()) return;
    const auto reason = acknowledged.reason;
    if (!publish::is_failure(reason)) {
        finish_message(found->second, found->second.proved ? kFinished : kFinished | kUnproved);
    } else if (reason == MqttReason::packet_too_large || reason == MqttReason::topic_name_invalid ||
               reason == MqttReason::payload_format_invalid) {
        finish_message(found->second, kFinished | kRejected);
    } else {
        refused_ = true;
        return;  // its answer does not change any more
    }
    sent_.erase(found);
}

void StreamJudge::on_received(publish::MqttToken token) {
    const auto found = sent_.find(token);
    if (found == sent_.end()) return;
    finish_message(found->second, found->second.message.gap ? kCovered : kReceived);
}

void StreamJudge::finish_message(const Sent& sent, std::uint8_t fate) {
    const auto& message = sent.message;
    for (const auto& sample : message.samples) at(sample.number).fate |= fate;
    if (!message.gap) return;
    for (std::uint64_t i = 0; i < message.gap->samples; ++i) at(message.gap->number + i).fate |= fate;
    for (const auto number : sent.restarts) finish_restart(account_.runs()[number - 1], fate);
    Run* run = message.gap->cause == "restart" ? account_.run_of(message.epoch) : nullptr;
    if (run != nullptr) finish_restart(*run, fate);
}

void StreamJudge::finish_restart(Run& run, std::uint8_t fate) {
    run.restart_finished = run.restart_finished || (fate & kFinished) != 0;
    run.restart_received = run.restart_received || (fate & (kCovered | kUnproved | kRejected)) != 0;
}

// Only numbers that a sample can have are asked for.
StreamJudge::Sample& StreamJudge::at(std::uint64_t number) {
    if (number > samples_.size()) samples_.resize(number);
    return samples_[number - 1];
}

bool StreamJudge::is_finished(std::uint64_t number) const {
    return number <= samples_.size() && (samples_[number - 1].fate & kFinished) != 0;
}

const publish::Sample* StreamJudge::sample_of(std::uint64_t epoch, std::uint64_t number) const {
    const Run* run = account_.run_of(epoch);
    const Unit* unit = run ? run->unit_of(number) : nullptr;
    if (unit == nullptr || unit->lost() || (run->end && number > *run->end)) return nullptr;
    return &unit->batch.samples[number - run->base - 1 - unit->offset];
}

void StreamJudge::advance_finished() const {
    while (finished_ < journal_.durable_samples() && is_finished(finished_ + 1)) ++finished_;
}

std::optional<std::string> StreamJudge::unfinished(std::uint64_t sequence, std::uint64_t samples) const {
    advance_finished();
    if (finished_ < samples) return "sample " + std::to_string(finished_ + 1) + " is not acknowledged";
    for (const Run& run : account_.runs()) {
        if (run.epoch == 0 || run.first_sequence > sequence || run.restart_finished) continue;
        if (run.end && *run.end == run.base && &run != &account_.runs().back()) continue;
        const auto* record = journal_.record(run.first_sequence);
        if (record != nullptr && record->present && record->facts.epoch == run.epoch)
            return "the restart of epoch " + std::to_string(run.epoch) + " is not acknowledged";
    }
    return std::nullopt;
}

void StreamJudge::on_cut(std::uint64_t samples) {
    if (samples_.size() > samples) samples_.resize(samples);
    finished_ = std::min(finished_, samples);
}

void StreamJudge::on_cursor_lost(std::uint64_t samples) {
    for (std::uint64_t number = 1; number <= samples; ++number) at(number).fate |= kCovered | kFinished;
}

bool StreamJudge::has_arrived(std::uint64_t number) const {
    constexpr std::uint8_t kArrived = kReceived | kCovered | kRejected | kUnproved;
    return number <= samples_.size() && (samples_[number - 1].fate & kArrived) != 0;
}

std::uint64_t StreamJudge::delivered_through() const {
    advance_finished();
    return finished_;
}

void StreamJudge::finish(std::uint64_t samples) {
    for (std::uint64_t number = 1; number <= samples; ++number) {
        if (has_arrived(number)) continue;
        return fail("nothing_lost",
                    "every sample up to " + std::to_string(samples) + " arrived, or a gap in its place",
                    "no trace of sample " + std::to_string(number));
    }
    for (const Run& run : account_.runs()) {
        const auto* record = run.epoch == 0 ? nullptr : journal_.record(run.first_sequence);
        const bool is_there = record != nullptr && record->present && record->facts.epoch == run.epoch;
        if (is_there && !run.restart_received)
            fail("nothing_lost", "a gap `restart` for each start",
                 "none of epoch " + std::to_string(run.epoch));
    }
}

}  // namespace takt::gatewaysim
