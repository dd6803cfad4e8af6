// Every event and frame that is encoded is decoded to an equal one, with each member away from its default.
#include "sessions/record_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace takt::host {
namespace record_codec_test {

Event decoded(const Event& event) {
    std::vector<std::uint64_t> record;
    encode(event, record);
    return decode_event(record);
}

template <class Body>
Body round_trip(Body body) {
    const Event event = decoded({.generation = 7, .t = Instant(Duration(123)), .body = std::move(body)});
    EXPECT_EQ(event.generation, 7U);
    EXPECT_EQ(event.t, Instant(Duration(123)));
    return std::get<Body>(event.body);
}

TEST(RecordCodec, KeepsEveryKindOfValue) {
    const value::Value values[] = {std::monostate{},
                                   true,
                                   std::int64_t{-5},
                                   std::uint64_t{UINT64_MAX},
                                   0.1,
                                   std::nan(""),
                                   std::string(),
                                   std::string("12345678"),
                                   std::string("Ж\0x", 4),
                                   std::string(250, 'a')};
    for (const auto& value : values) {
        const auto changed = round_trip(ValueChanged{.slot = {3},
                                                     .value = value,
                                                     .quality = value::Quality::bad,
                                                     .reason = value::exception_reason(2),
                                                     .good_at = {},
                                                     .sampled_at = Instant(Duration(4)),
                                                     .good_before = Instant(Duration(3)),
                                                     .batch = 9});
        EXPECT_TRUE(value::same(changed.value, value));
        EXPECT_EQ(changed.slot, value::SlotId{3});
        EXPECT_EQ(changed.quality, value::Quality::bad);
        EXPECT_EQ(changed.reason, value::exception_reason(2));
        EXPECT_FALSE(changed.good_at);
        EXPECT_EQ(changed.sampled_at, Instant(Duration(4)));
        EXPECT_EQ(changed.good_before, Instant(Duration(3)));
        EXPECT_EQ(changed.batch, 9U);
    }
}

TEST(RecordCodec, TheShortWayOfAValueChangeIsTheSameRecord) {
    const value::Event changed{.sequence = 1,
                               .batch = 5,
                               .t = Instant(Duration(8)),
                               .slot = {2},
                               .value = std::string("long enough to be on the heap"),
                               .quality = value::Quality::uncertain,
                               .reason = value::Reason::timeout,
                               .good_at = Instant(Duration(6)),
                               .sampled_at = Instant(Duration(4)),
                               .good_before = Instant(Duration(3))};
    std::vector<std::uint64_t> one;
    encode(4, changed, one);
    std::vector<std::uint64_t> other;
    encode(
        Event{.generation = 4,
              .t = changed.t,
              .body = ValueChanged{changed.slot, changed.value, changed.quality, changed.reason,
                                   changed.good_at, changed.sampled_at, changed.good_before, changed.batch}},
        other);
    EXPECT_EQ(one, other);
}

TEST(RecordCodec, KeepsErrorsRequestsOutcomesAndNotices) {
    const auto link = round_trip(LinkChanged{2, false, Error{Code::cannot_open, "/dev/ttyUSB0", {2, -1, 0}}});
    EXPECT_EQ(link.line, 2U);
    ASSERT_TRUE(link.why);
    EXPECT_EQ(*link.why, (Error{Code::cannot_open, "/dev/ttyUSB0", {2, -1, 0}}));

    const RequestKey key{1, 2, wire::Function::read_holding_registers, std::nullopt, 500, 20};
    const auto overrun = round_trip(PeriodOverrun{key, Duration(5), Duration(6), true});
    EXPECT_EQ(overrun.request, key);
    EXPECT_EQ(overrun.real, Duration(6));
    EXPECT_TRUE(overrun.overrun);

    const poll::DelayFinding finding{
        poll::DelayFinding::Setting::turnaround, Duration(60), Duration(20), Duration(150), 40, 2};
    const auto delays = round_trip(DelaysFound{1, 2, finding});
    EXPECT_EQ(delays.line, 1U);
    EXPECT_EQ(delays.device, 2U);
    EXPECT_EQ(delays.finding, finding);

    const auto noise = round_trip(NoiseFound{1, 2, {.least = 1, .most = 3}});
    EXPECT_EQ(noise.line, 1U);
    EXPECT_EQ(noise.device, 2U);
    EXPECT_EQ(noise.finding, (poll::NoiseFinding{.least = 1, .most = 3}));

    Outcome outcome{.id = 11, .kind = Command::Kind::write, .slot = {4}};
    outcome.result = value::CommandResult::refused;
    outcome.reason = value::Reason::differs;
    outcome.value = std::int64_t{1};
    outcome.read_back = std::int64_t{2};
    const auto finished = round_trip(WriteFinished{outcome, 66});
    EXPECT_EQ(finished.session, 66U);
    EXPECT_EQ(finished.outcome.id, 11U);
    EXPECT_EQ(finished.outcome.result, value::CommandResult::refused);
    EXPECT_TRUE(value::same(finished.outcome.read_back, std::int64_t{2}));

    const Notice notice{Notice::Severity::error,
                        "host.retain.damaged",
                        {{"file", "plant.state"}, {"aside", ""}},
                        Error{Code::io_failed, "x", {5}}};
    const auto seen = round_trip(notice);
    EXPECT_EQ(seen.severity, notice.severity);
    EXPECT_EQ(seen.code, notice.code);
    EXPECT_EQ(seen.arguments, notice.arguments);
    EXPECT_EQ(seen.error, notice.error);
}

TEST(RecordCodec, CutsATextThatIsTooLong) {
    Notice notice;
    notice.code = std::string(kLongestText + 10, 'x');
    EXPECT_EQ(round_trip(notice).code, std::string(kLongestText, 'x'));
}

TEST(RecordCodec, KeepsAuditRecordsSoThatTheirLineIsTheSame) {
    endpoint::AuditRecord record;
    record.time = std::chrono::system_clock::time_point(std::chrono::seconds(1'700'000'000));
    record.event = endpoint::AuditRecord::Event::refused;
    record.peer.assign("192.0.2.7:1234");
    record.unit = 17;
    record.function = 16;
    record.items = endpoint::AuditRecord::Items{wire::Area::holding_register, 9, 1};
    record.old_values = wire::Pdu{0, 1};
    record.new_values = wire::Pdu{0, 2};
    record.why = "rate";
    record.exception = 1;
    record.own_unit = 3;
    record.relayed_to = 5;
    record.outcome = endpoint::AuditRecord::Outcome::not_sent;
    EXPECT_EQ(endpoint::audit_line(round_trip(AuditRecorded{record}).record), endpoint::audit_line(record));
}

TEST(RecordCodec, KeepsFramesAndFaults) {
    const std::vector<std::uint8_t> pdu{3, 2, 0, 1};
    const std::vector<std::uint8_t> raw{1, 3, 2, 0, 1, 0xAA, 0xBB};
    std::vector<std::uint64_t> record;
    encode({.generation = 2,
            .source = {TrafficSource::Kind::endpoint, 5},
            .t = Instant(Duration(9)),
            .direction = wire::Direction::received,
            .unit = UnitId{17},
            .peer = "192.0.2.7:50100",
            .pdu = pdu,
            .raw = raw},
           record);
    const auto frame = decode_traffic(record);
    EXPECT_EQ(frame.source, (TrafficSource{TrafficSource::Kind::endpoint, 5}));
    EXPECT_EQ(frame.direction, wire::Direction::received);
    EXPECT_EQ(frame.unit, UnitId{17});
    EXPECT_FALSE(frame.fault);
    EXPECT_EQ(frame.peer, "192.0.2.7:50100");
    EXPECT_EQ(frame.pdu, pdu);
    EXPECT_EQ(frame.raw, raw);
}

}  // namespace record_codec_test
}  // namespace takt::host
