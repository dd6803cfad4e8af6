#include "command_judge.hpp"

#include <algorithm>
#include <charconv>

#include "../project_text.hpp"

namespace takt::gatewaysim {
namespace {

using file::Json;
using publish::MqttMessage;

/// Deliveries after which an id may be forgotten: the gateway remembers 1024 accepted and 1024 refused ones.
constexpr std::uint64_t kRememberedDeliveries = 1000;

std::string content_of(const MqttMessage& message) {
    return message.topic + "\n" + message.payload;
}

std::string string_at(const Json& object, const char* key) {
    const auto* found = object.find(key);
    const auto* text = found ? std::get_if<std::string>(&found->value()) : nullptr;
    return text ? *text : std::string();
}

std::optional<std::uint32_t> value_of(const Json& object) {
    const auto* found = object.find("value");
    if (found == nullptr) return std::nullopt;
    if (const auto* u = std::get_if<std::uint64_t>(&found->value())) return static_cast<std::uint32_t>(*u);
    if (const auto* i = std::get_if<std::int64_t>(&found->value())) return static_cast<std::uint32_t>(*i);
    const auto* text = std::get_if<std::string>(&found->value());
    std::uint32_t number = 0;
    if (text == nullptr) return std::nullopt;
    const auto parsed = std::from_chars(text->data(), text->data() + text->size(), number);
    return parsed.ec == std::errc() ? std::optional(number) : std::nullopt;
}

/// Refusals of a message, not of the command: its id may be used again.
bool is_of_message(const std::string& reason) {
    return reason == "retained" || reason == "not_subscribed" || reason == "duplicate_id" ||
           reason == "malformed";
}

}  // namespace

void CommandJudge::on_run_begin() {
    fates_.clear();
    known_.clear();
    duplicates_.clear();
    ambiguous_.clear();
    unsure_.clear();
    deliveries_ = 0;
    stopping_ = false;
}

void CommandJudge::on_sent(const SentCommand& command) {
    const auto content = content_of(command.message);
    sent_[content] = command;
    if (!command.id.empty()) by_id_.try_emplace(command.id, content);
    if (command.value) by_value_.try_emplace(*command.value, content);
}

/// By docs/mqtt-messages.md, "Expiry".
CommandJudge::Delivery CommandJudge::judge(const SentCommand& command, const MqttMessage& message,
                                           bool subscribed) const {
    const auto at = [&](std::int64_t wall_ns) {
        return after(clock_.now, Duration(wall_ns - clock_.wall_ns()));
    };
    Delivery delivery{.at = clock_.now};
    const auto standard = scenario_.configuration->project().outputs.at(0).command_expiry;
    const auto length = command.expiry.value_or(standard);
    std::vector<Instant> limits{after(clock_.now, std::chrono::hours(24))};
    if (command.expires_ns) limits.push_back(at(*command.expires_ns));
    if (command.sent_ns) limits.push_back(after(at(*command.sent_ns), length));
    const auto& message_expiry = message.properties.expiry_s;
    if (message_expiry) limits.push_back(after(clock_.now, std::chrono::seconds(*message_expiry)));
    const bool has_other = command.expires_ns || command.sent_ns || message_expiry;
    if (command.expiry || !has_other) limits.push_back(after(clock_.now, length));
    delivery.expires = *std::ranges::min_element(limits);
    const bool future = command.sent_ns && at(*command.sent_ns) > after(clock_.now, std::chrono::seconds(60));
    delivery.permitted =
        command.executable && subscribed && !message.retain && !future && delivery.expires > clock_.now;
    return delivery;
}

void CommandJudge::on_delivered(const MqttMessage& message, bool subscribed) {
    const auto found = sent_.find(content_of(message));
    if (found == sent_.end()) return;
    complaints_.count("command_delivered");
    ++deliveries_;
    const auto& command = found->second;
    auto delivery = judge(command, message, subscribed);
    if (!command.id.empty() && command.well_formed && subscribed && !message.retain) {
        const auto [known, is_new] =
            known_.try_emplace(command.id, Known{found->first, deliveries_, clock_.now});
        if (deliveries_ - known->second.delivery > kRememberedDeliveries) ambiguous_.insert(command.id);
        const bool same = known->second.content == found->first || is_unsure(command);
        delivery.permitted = delivery.permitted && same;
        delivery.conflicts = !same;
    }
    fates_[found->first].deliveries.push_back(delivery);
}

// The session ignores messages from the moment on at which it decides to leave, which is in the same step.
void CommandJudge::on_left() {
    for (auto& [content, fate] : fates_) {
        const auto& id = sent_[content].id;
        for (auto& delivery : fate.deliveries) {
            if (delivery.at != clock_.now) continue;
            delivery.may_be_ignored = true;
            const auto known = known_.find(id);
            if (known != known_.end() && known->second.at == clock_.now) unsure_.insert(id);
        }
    }
}

void CommandJudge::on_executed(std::uint32_t value, Instant ordered_at) {
    const auto content = by_value_.find(value);
    if (content == by_value_.end()) return;
    complaints_.count("command_executed");
    const auto& command = sent_[content->second];
    Fate& fate = fates_[content->second];
    const std::string name = "command " + (command.id.empty() ? std::to_string(value) : command.id);
    ++fate.executions;
    std::size_t permitted = 0;
    bool in_time = false;
    for (const auto& delivery : fate.deliveries) {
        permitted += delivery.permitted ? 1 : 0;
        in_time =
            in_time || (delivery.permitted && ordered_at >= delivery.at && ordered_at <= delivery.expires);
    }
    if (permitted == 0)
        fail("forbidden_not_executed",
             "no execution of " + name + ": retained, expired, not listed, malformed, or before SUBACK",
             "one");
    else if (!in_time)
        fail("expired_not_executed", "no execution of " + name + " after its expiry", "one");
    if (is_ambiguous(command)) return;
    // Without an id of its sender, each delivery is a command of its own.
    if (fate.executions > (command.id.empty() ? permitted : 1))
        fail("executed_once", "at most one execution of " + name, std::to_string(fate.executions));
    if (fate.outcome && (*fate.outcome == "refused" || *fate.outcome == "expired") && !command.id.empty())
        fail("outcome_true", "no execution of " + name + " after the outcome " + *fate.outcome, "one");
}

bool CommandJudge::is_answer(const MqttMessage& message) const {
    return message.topic == std::string(kControlTopic) + "/answer" || message.topic.starts_with("reply/");
}

const SentCommand* CommandJudge::find(const Json& answer) const {
    const auto id = string_at(answer, "id");
    if (const auto known = known_.find(id); known != known_.end()) return &sent_.at(known->second.content);
    if (const auto known = by_id_.find(id); known != by_id_.end()) return &sent_.at(known->second);
    const auto value = value_of(answer);
    if (!value) return nullptr;
    const auto known = by_value_.find(*value);
    return known == by_value_.end() ? nullptr : &sent_.at(known->second);
}

void CommandJudge::on_answer(const MqttMessage& message) {
    const auto answer = Json::parse(message.payload);
    if (!answer) return fail("one_outcome", "an answer", message.payload);
    const auto outcome = string_at(*answer, "outcome");
    const auto reason = string_at(*answer, "reason");
    complaints_.count("answer_" + outcome);
    if (reason == "duplicate_id") duplicates_[string_at(*answer, "id")] = clock_.now;
    if (!reason.empty()) complaints_.count("reason_" + reason);
    const auto* command = find(*answer);
    if (command == nullptr) return;
    Fate& fate = fates_[content_of(command->message)];
    fate.answered = true;
    if (is_of_message(reason) || command->id.empty() || is_unsure(*command)) return;
    if (fate.outcome && *fate.outcome != outcome)
        fail("one_outcome", "one outcome of command " + command->id + ": " + *fate.outcome, outcome);
    if (!fate.outcome) check_outcome(*command, fate, outcome, reason);
    fate.outcome = outcome;
}

void CommandJudge::check_outcome(const SentCommand& command, Fate& fate, const std::string& outcome,
                                 const std::string& reason) {
    const bool settled = reason.empty() || reason == "rounded" || reason == "not_retained";
    if (outcome == "done" && is_executed_when_done(command) && settled && fate.executions != 1)
        fail("outcome_true", "an execution of command " + command.id + ", which is done",
             std::to_string(fate.executions));
    const auto is_over = [this](const Delivery& delivery) { return delivery.expires <= clock_.now; };
    if (outcome == "expired" && !stopping_ && std::ranges::none_of(fate.deliveries, is_over))
        fail("outcome_true", "not the outcome expired of command " + command.id + " before its expiry",
             outcome);
    if ((outcome == "refused" || outcome == "expired") && fate.executions != 0)
        fail("outcome_true", "no execution of command " + command.id + ", which is " + outcome,
             std::to_string(fate.executions));
}

bool CommandJudge::is_executed_when_done(const SentCommand& command) const {
    if (!command.value) return false;
    if (command.subject == kMode || command.message.payload.find("\"write\"") != std::string::npos)
        return true;
    const auto& configuration = *scenario_.configuration;
    const auto slot = configuration.find(command.subject);
    const auto* variable = slot ? configuration.variable_of(*slot) : nullptr;
    return variable != nullptr && variable->write_on_change;
}

void CommandJudge::on_audit(std::string_view line) {
    const auto audit = Json::parse(line);
    if (!audit) return fail("one_outcome", "a line of JSON", std::string(line));
    const auto outcome = string_at(*audit, "outcome");
    const auto reason = string_at(*audit, "reason");
    const auto* command = find(*audit);
    if (command == nullptr || command->id.empty() || is_of_message(reason)) return;
    if (is_unsure(*command)) return;
    Fate& fate = fates_[content_of(command->message)];
    if (fate.audited)
        fail("one_outcome", "one outcome of command " + command->id + " in the audit log: " + *fate.audited,
             "another one: " + outcome);
    fate.audited = outcome;
}

/// The answer to the command that its id means is not that of another one.
void CommandJudge::check_refusal(const SentCommand& command, const Delivery& delivery) {
    if (!delivery.conflicts || is_unsure(command)) return;
    const auto refused = duplicates_.find(command.id);
    if (refused == duplicates_.end() || refused->second < delivery.at)
        fail("outcome_true", "the refusal `duplicate_id` of another command " + command.id, "none");
}

void CommandJudge::finish(Instant from, Instant until) {
    for (const auto& [content, fate] : fates_) {
        const auto& command = sent_[content];
        bool due = false;
        for (const auto& delivery : fate.deliveries) {
            if (delivery.at < from || delivery.at > until || delivery.may_be_ignored) continue;
            due = true;
            check_refusal(command, delivery);
        }
        const auto* meant = &content;  // by an answer with this id
        if (const auto known = known_.find(command.id); known != known_.end())
            meant = &known->second.content;
        else if (const auto first = by_id_.find(command.id); first != by_id_.end())
            meant = &first->second;
        const bool other = *meant != content;
        const bool findable = !command.id.empty() || command.value;
        if (due && findable && !other && !fate.answered)
            fail("answered", "an answer to command " + command.id, "none");
    }
}

}  // namespace takt::gatewaysim
