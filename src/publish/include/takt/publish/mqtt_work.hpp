// An MQTT output at work: its session between the journal and a pipe, with its state topics.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "takt/host/session.hpp"
#include "takt/publish/command_desk.hpp"
#include "takt/publish/journal_messages.hpp"
#include "takt/publish/mqtt_pipe.hpp"
#include "takt/publish/mqtt_session.hpp"
#include "takt/publish/output_work.hpp"
#include "takt/publish/wall_clock.hpp"

namespace takt::publish {

/// Publishes the records of a journal, and the states of lines and devices at most once a second. The broker
/// has the state "online" from the birth on, and "offline" from its will or the end on. Executes commands if
/// it has a desk for them.
class MqttWork final : public OutputWork, private MqttListener {
public:
    /// Commands of the broker's other clients.
    struct Commands {
        CommandDesk desk;
        /// What they may concern in a configuration. Called by the thread of the output.
        std::function<CommandRights(const host::ConfigurationPtr&)> rights;
    };
    struct Options {
        MqttSessionOptions session;  ///< with the subscriptions of the commands
        std::unique_ptr<MessageComposer> composer;
        std::string status_topic;  ///< of lines and devices; retained
        std::unique_ptr<MqttPipe> pipe;
        std::unique_ptr<host::Session> host;  ///< without events
        std::optional<Commands> commands;     ///< nothing: read-only
        std::string remedies = {};            ///< model::output_remedies()
        WallClock wall_ns = system_wall_ns;
    };

    explicit MqttWork(Options options);
    ~MqttWork() override;

    void begin(Instant now, store::Journal& journal, store::DestinationId destination) override;
    void work(Instant now) override;
    [[nodiscard]] Instant next_wakeup() const override;
    /// After each connection but the first: another broker, or one that was restarted, does not have the
    /// retained values. Before the first connection all samples of the run are in the journal.
    [[nodiscard]] bool take_retained_request() override { return std::exchange(retained_wanted_, false); }
    [[nodiscard]] std::span<const int> descriptors() const override { return descriptors_; }
    void on_state_changed(Instant now) override;
    [[nodiscard]] bool takes_records() const override;
    void stop(Instant now) override;
    [[nodiscard]] bool stopped() const override;
    void report(Instant now, OutputStatus& status) const override;

private:
    static constexpr Duration kStatusEvery = std::chrono::seconds(60);
    static constexpr Duration kStatusGap = std::chrono::seconds(1);

    void on_connected(Instant now, MqttConnectionId connection) override;
    void on_disconnected(Instant now, MqttConnectionId connection) override;
    void on_message(Instant now, MqttInbound&& inbound) override;

    void publish_status(Instant now);
    /// Moves commands to the host and outcomes to their answers.
    void execute_commands(Instant now);
    void publish_answers(Instant now);
    [[nodiscard]] CommandTime in_both_clocks(Instant now) const;

    Options options_;
    std::vector<int> descriptors_;
    std::optional<JournalMessages> messages_;
    std::optional<MqttSession> session_;
    host::ConfigurationPtr rights_of_;  // the configuration whose rights the desk has
    bool connected_before_ = false;
    bool retained_wanted_ = false;
    Instant status_at_ = kNever;  // when the status is published next; kNever: not connected
    Instant status_sent_at_{};
};

}  // namespace takt::publish
