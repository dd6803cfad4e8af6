// The records of a journal as the messages of an MQTT session.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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

/// What a composer must know of the samples' place in the stream.
struct StreamPlace {
    std::uint64_t epoch = 0;
    std::uint64_t first = 0;   ///< number of the first sample or missing sample in the stream, from 1 on
    std::size_t repeated = 0;  ///< so many messages of this record were sent before, the first ones
    std::size_t packet_limit = kNoPacketLimit;  ///< MessageLimits::packet
    MqttVersion version = MqttVersion::v5;
};

/// Makes messages of samples and gaps. With the same limits the same record gives the same messages in the
/// same order. StreamPlace::repeated changes only the marks of the messages.
class MessageComposer {
public:
    virtual ~MessageComposer() = default;

    static constexpr std::size_t kMostMessages = 65'535;  ///< of one record

    virtual void compose(const SampleBatch& batch, const StreamPlace& place,
                         std::vector<ComposedMessage>& out) = 0;
    /// At most one message.
    virtual void compose(const store::Gap& gap, const StreamPlace& place,
                         std::vector<ComposedMessage>& out) = 0;
};

/// Reads a destination of the journal, and moves its cursor when all messages of a record are acknowledged. A
/// record that cannot be decoded is counted as rejected. A record that was acknowledged in part is sent whole
/// again where the limits of the connection have changed, since its messages may be other ones. One thread.
class JournalMessages final : public MessageSource {
public:
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
    /// Wall time of the oldest record that was sent and is not acknowledged; none: nothing is in flight.
    [[nodiscard]] std::optional<std::int64_t> oldest_in_flight_ns() const;

private:
    /// A record with messages that are not all acknowledged.
    struct Record {
        std::uint64_t sequence = 0;
        std::uint64_t first_token = 0;
        std::int64_t wall_ns = 0;
        std::vector<std::uint64_t> samples;  // of each message
        std::uint64_t too_large = 0;
    };

    [[nodiscard]] bool read_record(Instant now);
    void change_limits(const MessageLimits& limits);
    [[nodiscard]] StreamPlace place_of(const store::RecordHeader& header, std::uint64_t first_token) const;
    [[nodiscard]] bool compose(const store::JournalEntry& entry, const StreamPlace& place);
    void finish_records(Instant now, std::uint64_t token);

    store::Journal& journal_;
    store::DestinationId destination_;
    MessageComposer& composer_;
    std::deque<Record> records_;             // read and not acknowledged
    std::vector<ComposedMessage> composed_;  // of the last of them
    std::size_t next_ = 0;                   // index of the next message in composed_
    std::uint64_t highest_token_ = 0;        // returned in this run
    std::uint64_t finished_token_ = 0;       // acknowledged or rejected
    std::uint64_t highest_record_ = 0;       // sequence number, read in this run
    std::uint64_t last_of_earlier_run_ = 0;  // sequence number: up to it an earlier run may have sent all
    MessageLimits limits_;                   // of the messages in composed_
    std::uint64_t other_limits_token_ = 0;   // up to it, messages were made with other limits before
    std::uint64_t rejected_ = 0;
    std::uint64_t too_large_ = 0;
    std::optional<Error> failure_;
};

}  // namespace takt::publish
