// The judge of the gateway: sees what enters it, what is on its disk, and what leaves it.
#pragma once

#include <cstdint>
#include <set>

#include "../bus.hpp"
#include "../gateway.hpp"
#include "account.hpp"
#include "command_judge.hpp"
#include "journal_judge.hpp"
#include "sampling_judge.hpp"
#include "sim/hash.hpp"
#include "stream_judge.hpp"

namespace takt::gatewaysim {

class Judge final : public NetworkObserver, public GatewayObserver {
public:
    Judge(const Scenario& scenario, const Clock& clock, Complaints& complaints);

    [[nodiscard]] DiskObserver& disk() { return journal_; }
    void on_run_begin(Disk& disk, bool damaged);
    /// The record of which a part is delivered; nullptr: there is none on the disk.
    [[nodiscard]] const JournalJudge::Entry* partly_delivered() const;
    void on_decay(std::uint64_t sequence) { journal_.on_decay(sequence); }
    void on_status(const publish::OutputStatus& status);
    void on_sent(const SentCommand& command) { commands_.on_sent(command); }
    void on_stopping() { commands_.on_stopping(); }
    void on_written(std::uint32_t value, Instant ordered_at);
    /// @param orderly  the program has ended by itself
    void on_run_end(bool orderly);
    /// A fingerprint of what the gateway did.
    [[nodiscard]] std::uint64_t hash() const { return hash_.value(); }
    /// Everything that was sampled before this instant must have arrived.
    void check_progress(Instant sampled_before);
    void finish(Instant commands_from, Instant commands_until);

    void on_action(const publish::MqttAction& action) override;
    void on_event(const publish::MqttEvent& event) override;
    void on_received(publish::MqttConnectionId connection, publish::MqttToken token,
                     const publish::MqttMessage& message) override;

    void on_queued(const publish::QueuedSamples& samples, bool fits) override;
    void before_sampling() override { sampling_.before_sampling(); }
    void after_sampling() override { sampling_.after_sampling(); }
    void on_host_event(const host::Event& event) override;
    void on_audit(std::string_view line) override { commands_.on_audit(line); }

private:
    /// The current connection, as the gateway may know it.
    struct Connection {
        publish::MqttConnectionId id = 0;
        bool exists = false;  // from MqttConnect to MqttClosed
        bool open = false;    // after MqttConnected
        bool subscribed = false;
        bool left = false;  // MqttDisconnect was sent
        bool born = false;  // the birth message was sent
        publish::MqttToken subscribe_token = 0;
        std::set<publish::MqttToken> in_flight;  // of QoS > 0
        publish::MqttConnected limits;
    };

    void on(const publish::MqttConnect& connect);
    void on(const publish::MqttPublish& publish);
    void on(const publish::MqttSubscribe& subscribe);
    void on(const publish::MqttDisconnect& disconnect);
    void on(const publish::MqttConnected& connected);
    void on(const publish::MqttClosed& closed);
    void on(const publish::MqttAcknowledged& acknowledged);
    void on(const publish::MqttSubscribed& subscribed);
    void on(const publish::MqttReceived& received);
    void on(const publish::MqttOversized& /*oversized*/) {}
    void check_packet(const publish::MqttPublish& publish);
    [[nodiscard]] static bool is_of_stream(const std::string& topic);
    void fail(std::string_view rule, std::string expected, std::string seen) {
        complaints_.add(rule, clock_.now, std::move(expected), std::move(seen));
    }

    const Clock& clock_;
    Complaints& complaints_;
    Account account_;
    JournalJudge journal_;
    StreamJudge stream_;
    SamplingJudge sampling_;
    CommandJudge commands_;
    Connection connection_;
    publish::MqttConnectionId last_connection_ = 0;
    publish::MqttToken last_token_ = 0;
    std::optional<value::SlotId> mode_;
    simtest::Hash hash_;
};

}  // namespace takt::gatewaysim
