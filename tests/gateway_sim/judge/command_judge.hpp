// What becomes of commands: one outcome, at most one execution, and none that is forbidden.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "../clock.hpp"
#include "../complaints.hpp"
#include "../scenario.hpp"
#include "../senders.hpp"
#include "takt/file/json.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::gatewaysim {

class CommandJudge {
public:
    CommandJudge(const Clock& clock, const Scenario& scenario, Complaints& complaints)
        : clock_(clock), scenario_(scenario), complaints_(complaints) {}

    void on_run_begin();
    void on_sent(const SentCommand& command);
    /// The gateway took a message from its pipe. @param subscribed  the broker had accepted the subscriptions
    void on_delivered(const publish::MqttMessage& message, bool subscribed);
    /// The program ends in order: commands that were not sent to their device end as expired.
    void on_stopping() { stopping_ = true; }
    /// The gateway leaves the broker.
    void on_left();
    /// A device executed a write, or a local was set. @param ordered_at  when the request left the gateway
    void on_executed(std::uint32_t value, Instant ordered_at);
    /// The gateway publishes an answer.
    void on_answer(const publish::MqttMessage& message);
    void on_audit(std::string_view line);
    [[nodiscard]] bool is_answer(const publish::MqttMessage& message) const;

    /// The end of a simulation. @param from  commands that were delivered from then on must have an answer
    void finish(Instant from, Instant until);

private:
    struct Delivery {
        Instant at;
        bool permitted = false;       ///< it may be executed
        Instant expires = kNever;     ///< not later
        bool may_be_ignored = false;  ///< the session had perhaps decided to leave the broker
        bool conflicts = false;       ///< its id means another content
    };
    /// The content that an id means in the current run.
    struct Known {
        std::string content;
        std::uint64_t delivery = 0;  ///< number of the first one
        Instant at;                  ///< of it
    };
    /// A command in the current run. Those with the same content are one.
    struct Fate {
        std::vector<Delivery> deliveries;
        std::uint32_t executions = 0;
        std::optional<std::string> outcome;  ///< of an answer, but for refusals before its id counts
        std::optional<std::string> audited;  ///< likewise, of the audit log
        bool answered = false;
    };

    [[nodiscard]] Delivery judge(const SentCommand& command, const publish::MqttMessage& message,
                                 bool subscribed) const;
    void check_refusal(const SentCommand& command, const Delivery& delivery);
    void check_outcome(const SentCommand& command, Fate& fate, const std::string& outcome,
                       const std::string& reason);
    /// Whether `done` means that the value was written or set.
    [[nodiscard]] bool is_executed_when_done(const SentCommand& command) const;
    [[nodiscard]] const SentCommand* find(const file::Json& answer) const;
    [[nodiscard]] bool is_ambiguous(const SentCommand& command) const {
        return ambiguous_.contains(command.id);
    }
    /// The outcomes of its id may be those of another command.
    [[nodiscard]] bool is_unsure(const SentCommand& command) const {
        return is_ambiguous(command) || unsure_.contains(command.id);
    }
    void fail(std::string_view rule, std::string expected, std::string seen) {
        complaints_.add(rule, clock_.now, std::move(expected), std::move(seen));
    }

    const Clock& clock_;
    const Scenario& scenario_;
    Complaints& complaints_;
    std::map<std::string, SentCommand> sent_;        // by topic and payload
    std::map<std::string, std::string> by_id_;       // the first content with an id
    std::map<std::uint32_t, std::string> by_value_;  // the content that has this value
    std::map<std::string, Fate> fates_;              // by content, of the current run
    std::map<std::string, Known> known_;             // by id
    std::map<std::string, Instant> duplicates_;      // the last refusal `duplicate_id` of an id
    std::set<std::string> ambiguous_;                // ids that the gateway may have forgotten
    std::set<std::string> unsure_;                   // ids that it may not know, or by another content
    std::uint64_t deliveries_ = 0;                   // in this run
    bool stopping_ = false;
};

}  // namespace takt::gatewaysim
