// The records of a journal as the messages of an MQTT session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "takt/publish/message_source.hpp"
#include "takt/publish/sample.hpp"
#include "takt/store/journal.hpp"

namespace takt::publish {

/// A message and the number of samples that it carries.
struct ComposedMessage {
    MqttMessage message;
    std::uint64_t samples = 0;
    std::uint64_t too_large = 0;  ///< the message is a gap of so many samples that no packet could carry
};

/// The samples of a record.
struct RecordSamples {
    SampleBatch batch;
    std::uint64_t first = 0;  ///< number of the first sample in the stream, from 1 on
};

/// What a composer must know of the place in the stream.
struct StreamPlace {
    std::uint64_t epoch = 0;
    std::uint64_t first = 0;   ///< number of the first sample or missing sample in the stream, from 1 on
    std::size_t repeated = 0;  ///< so many messages of this portion were sent before, the first ones
    std::size_t packet_limit = kNoPacketLimit;  ///< MessageLimits::packet
    MqttVersion version = MqttVersion::v5;
};

/// Makes messages of samples and gaps. With the same limits the same portion gives the same messages in the
/// same order. StreamPlace::repeated changes only the marks of the messages.
class MessageComposer {
public:
    virtual ~MessageComposer() = default;

    static constexpr std::size_t kMostMessages = 65'535;  ///< of one portion

    /// Whether a portion is all records that wait, up to JournalMessages::kMostSamples; else it is one.
    [[nodiscard]] virtual bool joins_records() const { return false; }
    /// @param portion  of one epoch, at least one record
    virtual void compose(std::span<const RecordSamples> portion, const StreamPlace& place,
                         std::vector<ComposedMessage>& out) = 0;
    /// At most one message.
    virtual void compose(const store::Gap& gap, const StreamPlace& place,
                         std::vector<ComposedMessage>& out) = 0;
};

/// Reads a destination of the journal in portions, and moves its cursor when all messages of a portion are
/// acknowledged. A record that cannot be decoded is counted as rejected. A portion that was acknowledged in
/// part has the same messages after a rewind. It is sent whole again where the limits of the connection have
/// changed, or the journal has lost a part of it, since its messages may be other ones. One thread.
class JournalMessages final : public MessageSource {
public:
    /// Of a portion of several records.
    static constexpr std::size_t kMostSamples = 16'384;

    /// @param journal, composer  outlive it
    JournalMessages(store::Journal& journal, store::DestinationId destination, MessageComposer& composer)
        : journal_(journal), destination_(destination), composer_(composer) {}

    [[nodiscard]] std::optional<SourceMessage> next(Instant now, const MessageLimits& limits) override;
    void acknowledge(Instant now, std::uint64_t token) override;
    void reject(Instant now, std::uint64_t token, MqttReason reason) override;
    void rewind() override;

    /// Samples of this run that no message could carry, or that the broker can never take.
    [[nodiscard]] std::uint64_t rejected() const { return rejected_; }
    /// Samples of this run that were larger than a packet of the broker: their gaps are acknowledged.
    [[nodiscard]] std::uint64_t too_large() const { return too_large_; }
    /// Of the journal's disk, when the last next() could not read.
    [[nodiscard]] const std::optional<Error>& failure() const { return failure_; }

private:
    struct Record {
        std::uint64_t sequence = 0;
        std::uint64_t samples = 0;  // that are not dropped
    };
    /// Records whose messages are not all acknowledged: several where they are joined.
    struct Portion {
        std::vector<Record> records;
        std::uint64_t first_token = 0;
        std::vector<std::uint64_t> samples;  // of each message
        std::uint64_t too_large = 0;
    };
    /// What was read of the journal.
    struct Entry {
        store::RecordHeader header;
        std::optional<store::Gap> gap;
        std::optional<SampleBatch> batch;  // none: a gap, or it cannot be decoded
    };

    [[nodiscard]] std::optional<Entry> take_entry();
    [[nodiscard]] bool read_portion(Instant now);
    [[nodiscard]] std::vector<RecordSamples> join_records(Entry&& first, Portion& portion);
    [[nodiscard]] bool may_join(const Portion& portion, const store::RecordHeader& first, const Entry& next,
                                std::size_t samples) const;
    void note_end(const Portion& portion);
    void change_limits(const MessageLimits& limits);
    [[nodiscard]] StreamPlace place_of(const store::RecordHeader& header, const Portion& portion) const;
    void drop(Portion& portion, std::uint64_t samples, std::uint64_t gaps);
    void finish_portions(Instant now, std::uint64_t token);

    store::Journal& journal_;
    store::DestinationId destination_;
    MessageComposer& composer_;
    std::deque<Portion> portions_;            // read and not acknowledged
    std::vector<ComposedMessage> composed_;   // of the last of them
    std::size_t next_ = 0;                    // index of the next message in composed_
    std::size_t repeated_ = 0;                // so many of composed_ were returned before
    std::optional<Entry> pending_;            // read, and not in a portion
    std::deque<std::uint64_t> ends_;          // sequence numbers: of portions that were read in this run
    std::uint64_t highest_token_ = 0;         // returned in this run
    std::uint64_t highest_returned_ = 0;      // sequence number: a message of its portion was returned
    std::uint64_t finished_token_ = 0;        // acknowledged or rejected
    std::uint64_t highest_record_ = 0;        // sequence number, read in this run
    std::uint64_t last_of_earlier_run_ = 0;   // sequence number: up to it an earlier run may have sent all
    MessageLimits limits_;                    // of the messages in composed_
    std::uint64_t other_messages_token_ = 0;  // up to it, other messages were made before
    std::uint64_t rejected_ = 0;
    std::uint64_t too_large_ = 0;
    std::optional<Error> failure_;
};

}  // namespace takt::publish
