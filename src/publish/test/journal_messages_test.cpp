#include "takt/publish/journal_messages.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <random>
#include <string>

#include "simulated_disk.hpp"
#include "takt/publish/sample_codec.hpp"

namespace takt::publish {
namespace journal_messages_test {

using namespace std::chrono_literals;

constexpr std::array<std::string_view, 1> kNames{"cloud"};
constexpr store::DestinationId kCloud{0};
const Series kSeries{"Power", "Meter", "rs485-1", "kW", DataType::int16, false};

/// A message for each sample with its number, and one for each gap. A sample whose value is above the limit
/// of a packet is too large.
class PlainComposer final : public MessageComposer {
public:
    bool joins = false;  // samples of several records become one message, but the last one

    [[nodiscard]] bool joins_records() const override { return joins; }
    void compose(std::span<const RecordSamples> portion, const StreamPlace& place,
                 std::vector<ComposedMessage>& out) override {
        if (joins) return join(portion, place, out);
        const auto& batch = portion.front().batch;
        for (std::size_t i = 0; i < batch.samples.size(); ++i) {
            if (batch.samples[i].cause == SampleCause::heartbeat) continue;  // not for this output
            if (std::get<std::int64_t>(batch.samples[i].value) >
                static_cast<std::int64_t>(std::min(place.packet_limit, kNoPacketLimit / 2)))
                out.push_back({.message = {.topic = "gap", .payload = "large"}, .too_large = 1});
            else
                out.push_back({{.topic = "t", .payload = std::to_string(place.first + i)}, 1});
            if (i < place.repeated) out.back().message.payload += '*';
        }
    }
    void compose(const store::Gap& gap, const StreamPlace&, std::vector<ComposedMessage>& out) override {
        out.push_back({{.topic = "gap", .payload = std::to_string(gap.samples)}, gap.samples});
    }

private:
    /// "1-7" and "8".
    static void join(std::span<const RecordSamples> portion, const StreamPlace& place,
                     std::vector<ComposedMessage>& out) {
        const auto first = portion.front().first;
        const auto last = portion.back().first + portion.back().batch.samples.size() - 1;
        std::uint64_t too_large = 0;
        for (const auto& [batch, number] : portion)
            for (const auto& sample : batch.samples)
                if (std::get<std::int64_t>(sample.value) > 1'000) ++too_large;
        if (last > first)
            out.push_back({{.topic = "t", .payload = std::to_string(first) + "-" + std::to_string(last - 1)},
                           last - first - too_large});
        if (too_large > 0)
            out.push_back({.message = {.topic = "gap", .payload = "large"}, .too_large = too_large});
        out.push_back({{.topic = "t", .payload = std::to_string(last)}, 1});
        for (std::size_t i = 0; i < out.size() && i < place.repeated; ++i) out[i].message.payload += '*';
    }
};

class JournalMessagesTest : public ::testing::Test {
protected:
    void SetUp() override {
        auto opened = store::Journal::open(disk_, {}, kNames, now_, 0);
        ASSERT_TRUE(opened);
        journal_.emplace(*std::move(opened));
        messages_.emplace(*journal_, kCloud, composer_);
    }

    void append(std::size_t samples, SampleCause cause = SampleCause::change) {
        append_values(std::vector<std::int64_t>(samples, 1), cause);
    }
    void append_values(const std::vector<std::int64_t>& values, SampleCause cause = SampleCause::change) {
        SamplePayload payload(4096);
        for (const auto value : values)
            ASSERT_TRUE(payload.add(kSeries, {.series = 0, .value = value, .cause = cause}));
        const auto bytes = payload.take();
        ASSERT_TRUE(journal_->append(now_, {values.size(), 0, 0, bytes}));
        sync();
    }
    void sync() {
        now_ += 200ms;
        journal_->on_tick(now_, 0);
    }
    std::optional<SourceMessage> next() { return messages_->next(now_, {.packet = packet_}); }
    /// The payloads of all messages that wait.
    std::vector<std::string> all() {
        std::vector<std::string> texts;
        while (auto message = next()) {
            texts.push_back(message->message.payload);
            tokens_.push_back(message->token);
        }
        return texts;
    }
    [[nodiscard]] store::DestinationCounters counters() const { return journal_->counters(kCloud); }

    using Texts = std::vector<std::string>;
    store::test::SimulatedDisk disk_;
    Instant now_{};
    std::optional<store::Journal> journal_;
    PlainComposer composer_;
    std::optional<JournalMessages> messages_;
    std::size_t packet_ = kNoPacketLimit;
    std::vector<std::uint64_t> tokens_;  // of all()
};

TEST_F(JournalMessagesTest, TheCursorMovesWithTheLastMessageOfARecord) {
    append(2);
    append(3);
    EXPECT_EQ(all(), (Texts{"0", "1", "2", "3", "4", "5"}));  // first the gap of the start
    EXPECT_EQ(tokens_.size(), 6U);
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    EXPECT_EQ(counters().delivered, 0U);
    messages_->acknowledge(now_, tokens_[2]);
    EXPECT_EQ(counters().delivered, 2U);
    EXPECT_EQ(counters().waiting, 3U);
    for (std::size_t i = 3; i < 6; ++i) messages_->acknowledge(now_, tokens_[i]);
    EXPECT_EQ(counters().delivered, 5U);
}

TEST_F(JournalMessagesTest, ARewindGivesTheRestAgain) {
    append(3);
    EXPECT_EQ(all().size(), 4U);
    const auto first = tokens_;
    messages_->acknowledge(now_, first[0]);
    messages_->acknowledge(now_, first[1]);
    messages_->rewind();
    append(1);
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"2*", "3*", "4"}));
    EXPECT_EQ(tokens_[0], first[2]);
    EXPECT_EQ(tokens_[1], first[3]);
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().waiting, 0U);
    EXPECT_EQ(counters().delivered, 4U);
}

TEST_F(JournalMessagesTest, MessagesThatAnEarlierRunMayHaveSentAreMarked) {
    append(2);
    EXPECT_EQ(all().size(), 3U);
    append(1);
    messages_.reset();
    journal_.reset();
    SetUp();
    append(1);
    EXPECT_EQ(all(), (Texts{"0", "1*", "2*", "3*", "0", "4"}));
    messages_->acknowledge(now_, tokens_[3]);
    messages_->rewind();
    EXPECT_EQ(all(), (Texts{"1*", "2*", "3*", "0", "4*"}));
}

TEST_F(JournalMessagesTest, ARecordWithoutMessagesEndsWithTheOneBefore) {
    append(1);
    append(2, SampleCause::heartbeat);
    append(1);
    append(1, SampleCause::heartbeat);
    EXPECT_EQ(all(), (Texts{"0", "1", "4"}));
    messages_->acknowledge(now_, tokens_[0]);
    EXPECT_EQ(counters().delivered, 0U);
    messages_->acknowledge(now_, tokens_[1]);
    EXPECT_EQ(counters().delivered, 3U);
    messages_->acknowledge(now_, tokens_[2]);
    EXPECT_EQ(counters().delivered, 5U);
    append(1, SampleCause::heartbeat);
    EXPECT_EQ(all(), Texts{});
    EXPECT_EQ(counters().waiting, 0U);
}

TEST_F(JournalMessagesTest, ARejectedMessageIsDropped) {
    append(3);
    EXPECT_EQ(all().size(), 4U);
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    messages_->reject(now_, tokens_[2], MqttReason::packet_too_large);
    EXPECT_EQ(counters().waiting, 2U);
    EXPECT_EQ(counters().dropped, 1U);
    messages_->acknowledge(now_, tokens_[3]);
    EXPECT_EQ(counters().delivered, 2U);
    EXPECT_EQ(counters().dropped, 1U);
    EXPECT_EQ(messages_->rejected(), 1U);
}

TEST_F(JournalMessagesTest, SamplesThatAreTooLargeAreDroppedWithAGap) {
    packet_ = 10;
    append_values({1, 20, 1});
    EXPECT_EQ(all(), (Texts{"0", "1", "large", "3"}));
    EXPECT_EQ(counters().dropped, 1U);
    EXPECT_EQ(counters().gaps, 1U);
    EXPECT_EQ(counters().waiting, 2U);
    messages_->acknowledge(now_, tokens_[0]);
    messages_->rewind();
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"1*", "large*", "3*"}));
    EXPECT_EQ(messages_->too_large(), 0U);
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().dropped, 1U);
    EXPECT_EQ(counters().gaps, 1U);
    EXPECT_EQ(counters().delivered, 2U);
    EXPECT_EQ(counters().waiting, 0U);
    EXPECT_EQ(messages_->too_large(), 1U);
}

// The next broker takes the sample: the messages of the record are other ones.
TEST_F(JournalMessagesTest, WithOtherLimitsARecordIsSentWholeAgain) {
    packet_ = 10;
    append_values({1, 20, 1});
    append(1);
    EXPECT_EQ(all().size(), 5U);
    for (std::size_t i = 0; i < 3; ++i) messages_->acknowledge(now_, tokens_[i]);
    packet_ = 100;
    tokens_.clear();
    append(1);
    EXPECT_EQ(all(), (Texts{"1*", "2*", "3*", "4*", "5"}));
    messages_->acknowledge(now_, tokens_[0]);
    messages_->rewind();
    EXPECT_EQ(all(), (Texts{"2*", "3*", "4*", "5*"})) << "with the same limits the rest";
    for (std::size_t i = 1; i < 5; ++i) messages_->acknowledge(now_, tokens_[i]);
    EXPECT_EQ(counters().dropped, 0U);
    EXPECT_EQ(counters().delivered, 5U);
}

// The record is damaged on the disk after its first message was acknowledged.
TEST_F(JournalMessagesTest, AGapIsBehindTheAcknowledgedMessagesOfTheRecordThatItReplaces) {
    append(3);
    append(1);
    EXPECT_EQ(all().size(), 5U);
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    messages_->rewind();
    const auto [segment, bytes] = *disk_.contents().begin();
    disk_.flip(segment, store::kGapRecordBytes + store::kRecordHeaderBytes);
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"3", "4*"})) << "the gap of three samples";
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().dropped, 3U);
    EXPECT_EQ(counters().delivered, 1U);
    EXPECT_EQ(counters().waiting, 0U);
}

TEST_F(JournalMessagesTest, ARecordOfALaterVersionIsDropped) {
    const std::vector<std::uint8_t> unknown{9, 9, 9};
    ASSERT_TRUE(journal_->append(now_, {4, 0, 0, unknown}));
    append(1);
    EXPECT_EQ(all(), (Texts{"0", "5"}));
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().dropped, 4U);
    EXPECT_EQ(counters().delivered, 1U);
}

TEST_F(JournalMessagesTest, JoinedRecordsMoveTheCursorTogether) {
    composer_.joins = true;
    append(2);
    append(3);
    append(1);
    EXPECT_EQ(all(), (Texts{"0", "1-5", "6"}));
    append(2);
    EXPECT_EQ(all(), (Texts{"7-7", "8"}));
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    EXPECT_EQ(counters().delivered, 0U);
    messages_->acknowledge(now_, tokens_[2]);
    EXPECT_EQ(counters().delivered, 6U);
    messages_->acknowledge(now_, tokens_[3]);
    messages_->rewind();
    append(1);
    const auto last = tokens_[4];
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"8*", "9"}))
        << "the portion ends where it ended, and its first message is acknowledged";
    EXPECT_EQ(tokens_[0], last);
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().delivered, 9U);
    EXPECT_EQ(counters().waiting, 0U);
}

TEST_F(JournalMessagesTest, AKillWithinAnArrayRepeatsItAndLosesNothing) {
    composer_.joins = true;
    append(2);
    append(2);
    EXPECT_EQ(all(), (Texts{"0", "1-3", "4"}));
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    sync();
    messages_.reset();
    journal_.reset();
    SetUp();
    append(2);
    append(1);
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"0", "1-3*", "4*", "0", "5-6", "7"})) << "none is in a message with new samples";
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().delivered, 7U);
    EXPECT_EQ(counters().dropped, 0U);
}

TEST_F(JournalMessagesTest, DroppedSamplesOfJoinedRecordsAreCountedOnce) {
    composer_.joins = true;
    append_values({1, 2'000});
    append_values({2'000, 2'000});
    append_values({1, 1});
    EXPECT_EQ(all(), (Texts{"0", "1-5", "large", "6"}));
    EXPECT_EQ(counters().dropped, 3U);
    EXPECT_EQ(counters().gaps, 1U);
    messages_->acknowledge(now_, tokens_[0]);
    messages_->reject(now_, tokens_[1], MqttReason::payload_format_invalid);
    EXPECT_EQ(counters().dropped, 5U);
    messages_->rewind();
    EXPECT_EQ(counters().dropped, 0U) << "it is not acknowledged";
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"large*", "6*"}));
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(messages_->too_large(), 3U);
    EXPECT_EQ(counters().waiting, 0U);
    EXPECT_EQ(counters().appended, 6U);
}

// The record in the middle is damaged on the disk after an array was acknowledged.
TEST_F(JournalMessagesTest, APortionThatHasLostARecordIsSentWholeAgain) {
    composer_.joins = true;
    append(1);
    const auto intact = disk_.contents().begin()->second.size();
    append(2);
    append(2);
    EXPECT_EQ(all(), (Texts{"0", "1-4", "5"}));
    messages_->acknowledge(now_, tokens_[0]);
    messages_->acknowledge(now_, tokens_[1]);
    messages_->rewind();
    disk_.flip(disk_.contents().begin()->first, intact + store::kRecordHeaderBytes);
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(next());
    messages_->rewind();
    tokens_.clear();
    EXPECT_EQ(all(), (Texts{"1*", "2", "4-4*", "5*"})) << "the gap of two samples in its place";
    for (const auto token : tokens_) messages_->acknowledge(now_, token);
    EXPECT_EQ(counters().dropped, 2U);
    EXPECT_EQ(counters().delivered, 3U);
    EXPECT_EQ(counters().waiting, 0U);
}

TEST_F(JournalMessagesTest, APortionHasALimit) {
    composer_.joins = true;
    std::uint64_t samples = 0;
    for (; samples < JournalMessages::kMostSamples; samples += 500) append(500);
    const auto texts = all();
    ASSERT_EQ(texts.size(), 5U);
    EXPECT_EQ(texts[1], "1-15999");
    EXPECT_EQ(texts[4], std::to_string(samples));
}

// Any order of appends, deliveries and lost connections with joined records: every sample arrives, marked
// where it was sent before, and an acknowledged message is not sent again.
TEST_F(JournalMessagesTest, NothingIsLostInAnyOrderOfArrays) {
    composer_.joins = true;
    std::mt19937 random(11);
    std::uint64_t appended = 0;
    std::uint64_t acknowledged = 0;  // number of the last sample
    std::uint64_t sent = 0;          // likewise
    std::deque<SourceMessage> in_flight;
    const auto last_of = [](const std::string& text) { return std::stoull(text.substr(text.find('-') + 1)); };
    for (int step = 0; step < 4000; ++step) {
        switch (random() % 8) {
            case 0: {
                const auto samples = 1 + random() % 4;
                append(samples);
                appended += samples;
                break;
            }
            case 1:
                if (random() % 4 != 0) break;
                messages_->rewind();
                in_flight.clear();
                break;
            case 2:
            case 3:
            case 4: {
                auto message = next();
                if (!message) break;
                if (message->message.topic != "gap") {
                    const auto last = last_of(message->message.payload);
                    ASSERT_EQ(message->repeated, last <= sent) << message->message.payload;
                    ASSERT_EQ(message->repeated, message->message.payload.ends_with('*'));
                    sent = std::max<std::uint64_t>(sent, last);
                }
                in_flight.push_back(*std::move(message));
                break;
            }
            default: {
                if (in_flight.empty()) break;
                const auto message = in_flight.front();
                in_flight.pop_front();
                messages_->acknowledge(now_, message.token);
                if (message.message.topic == "gap") break;
                ASSERT_EQ(std::stoull(message.message.payload), acknowledged + 1);
                acknowledged = last_of(message.message.payload);
            }
        }
        ASSERT_EQ(counters().appended, appended);
        ASSERT_LE(counters().delivered, acknowledged);
    }
    messages_->rewind();
    while (const auto message = next()) messages_->acknowledge(now_, message->token);
    EXPECT_EQ(counters().delivered, appended);
}

// Any order of appends, deliveries and lost connections: every sample arrives, in order but for repeats.
TEST_F(JournalMessagesTest, NothingIsLostInAnyOrder) {
    std::mt19937 random(7);
    std::uint64_t appended = 0;
    std::uint64_t acknowledged = 0;  // number of the last sample
    std::deque<SourceMessage> in_flight;
    for (int step = 0; step < 4000; ++step) {
        switch (random() % 8) {
            case 0: {
                const auto samples = 1 + random() % 4;
                append(samples);
                appended += samples;
                break;
            }
            case 1:
                if (random() % 4 == 0) {
                    messages_->rewind();
                    in_flight.clear();
                }
                break;
            case 2:
            case 3:
            case 4:
                if (auto message = next()) in_flight.push_back(*std::move(message));
                break;
            default:
                if (in_flight.empty()) break;
                const auto message = in_flight.front();
                in_flight.pop_front();
                messages_->acknowledge(now_, message.token);
                if (message.message.topic == "gap") break;
                ASSERT_EQ(std::stoull(message.message.payload), ++acknowledged);
                ASSERT_EQ(message.repeated, message.message.payload.ends_with('*'));
        }
        ASSERT_EQ(counters().appended, appended);
    }
    in_flight.clear();
    messages_->rewind();
    while (const auto message = next()) {
        messages_->acknowledge(now_, message->token);
        ASSERT_EQ(std::stoull(message->message.payload), ++acknowledged);
    }
    EXPECT_EQ(acknowledged, appended);
    EXPECT_EQ(counters().delivered, appended);
}

}  // namespace journal_messages_test
}  // namespace takt::publish
