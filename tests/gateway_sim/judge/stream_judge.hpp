// The messages of samples and gaps: their content, their order, and that nothing is missing.
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
#include "account.hpp"
#include "journal_judge.hpp"
#include "message.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::gatewaysim {

class StreamJudge final : public Deliveries {
public:
    StreamJudge(Account& account, const JournalJudge& journal, const Clock& clock, const Scenario& scenario,
                Complaints& complaints);

    /// The gateway publishes a message of the stream.
    void on_published(const publish::MqttPublish& publish);
    void on_acknowledged(const publish::MqttAcknowledged& acknowledged);
    /// The broker has a message.
    void on_received(publish::MqttToken token);
    /// A connection is open, or is not any more.
    void on_connection(const publish::MqttConnected& limits);

    [[nodiscard]] std::optional<std::string> unfinished(std::uint64_t sequence,
                                                        std::uint64_t samples) const override;
    void on_cut(std::uint64_t samples) override;
    void on_cursor_lost(std::uint64_t samples) override;

    /// The end of a simulation: everything up to this sample must have arrived.
    void finish(std::uint64_t samples);
    /// Samples up to the last one of the stream that the broker has, without holes.
    [[nodiscard]] std::uint64_t delivered_through() const;

private:
    /// What is known of a sample of the stream, in bits.
    enum Fate : std::uint8_t {
        kSent = 1,       ///< in a message, by any run
        kReceived = 2,   ///< by a broker
        kCovered = 4,    ///< by a gap that a broker received
        kFinished = 8,   ///< acknowledged, or covered by an acknowledged gap
        kRejected = 16,  ///< a broker can never take it
        kUnproved = 32,  ///< sent with QoS 0: nothing shows whether it arrived
    };
    struct Sample {
        std::uint8_t fate = 0;
        std::uint32_t last_run = 0;   ///< that sent it
        std::uint32_t last_pass = 0;  ///< in which it was sent
    };
    struct Sent {
        SeenMessage message;
        bool proved = false;                  ///< QoS > 0
        std::vector<std::uint32_t> restarts;  ///< runs whose first record is in the gap
    };
    struct SentGap {
        std::uint64_t epoch = 0;
        SeenGap gap;
    };

    void check_sample(const SeenMessage& message, const SeenSample& sample);
    void check_topic(const publish::MqttMessage& message, const SeenMessage& seen);
    void check_gap(const SeenMessage& message);
    void check_restart(const SeenMessage& message);
    void check_written_gap(const SeenMessage& message);
    void check_found_gap(const SeenMessage& message);
    void check_too_large(const SeenMessage& message);
    [[nodiscard]] bool begins_behind(const SeenGap& gap, std::uint64_t sequence) const;
    void check_durable(std::uint64_t number);
    void check_order(const SeenMessage& message);
    void begin_pass();
    void check_repeated(const SeenMessage& message);
    void mark_sent(const SeenMessage& message);
    void finish_message(const Sent& sent, std::uint8_t fate);
    static void finish_restart(Run& run, std::uint8_t fate);
    [[nodiscard]] const publish::Sample* sample_of(std::uint64_t epoch, std::uint64_t number) const;
    [[nodiscard]] Sample& at(std::uint64_t number);
    [[nodiscard]] bool is_finished(std::uint64_t number) const;
    void advance_finished() const;
    /// A sample that a subscriber has or knows to be missing.
    [[nodiscard]] bool has_arrived(std::uint64_t number) const;
    void fail(std::string_view rule, std::string expected, std::string seen) {
        complaints_.add(rule, clock_.now, std::move(expected), std::move(seen));
    }

    Account& account_;
    const JournalJudge& journal_;
    const Clock& clock_;
    const Scenario& scenario_;
    Complaints& complaints_;
    /// Messages may be made anew: a broker takes packets up to a size only, or an array has lost a part.
    bool limited_ = false;
    std::optional<std::uint32_t> packet_limit_;  ///< of the connection
    struct Route {
        std::string topic;
        bool retain = false;
    };
    std::map<std::string, Route> routes_;  ///< by variable

    std::vector<Sample> samples_;              // by number, from 1 on
    std::map<publish::MqttToken, Sent> sent_;  // on the current connection
    std::vector<std::uint32_t> restarts_;      // of the gap that is judged: see Sent
    std::vector<SentGap> gaps_;                // that this run has sent
    std::uint32_t gaps_run_ = 0;

    // A pass goes through the stream in its order: a connection, or what follows a refused message.
    std::uint32_t pass_ = 0;
    std::uint64_t last_start_ = 0;        // number of the last message; 0: none yet
    bool last_was_empty_ = false;         // it was a gap without samples
    std::uint64_t due_ = 0;               // all samples before it were sent in this pass, or are finished
    bool refused_ = false;                // the broker refused a message in this pass
    mutable std::uint64_t finished_ = 0;  // all samples up to it are finished
    bool broker_retains_ = true;
};

}  // namespace takt::gatewaysim
