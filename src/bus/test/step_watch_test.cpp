// A unit that answers a request twice, and is one response behind from then on.
#include <gtest/gtest.h>

#include <deque>

#include "rig.hpp"
#include "takt/bus/unit_times.hpp"

namespace takt::bus {
namespace step_watch_test {

using namespace test;

constexpr const char* kOneRegister = "03 00 00 00 01";
constexpr const char* kTwoRegisters = "03 00 00 00 02";
constexpr const char* kOne = "03 02 11 11";
constexpr AnswerShape kShapeOfOne{3, 4};
constexpr AnswerShape kShapeOfTwo{3, 6};

Outcome answered(Instant sent, const std::vector<std::uint8_t>& response, const char* request) {
    const wire::PreparedRequest prepared(hex(request));
    const auto view = wire::decode_response(prepared.shape(), prepared.pdu(), response);
    return {.unit = UnitId{1},
            .sent = true,
            .request = prepared.shape(),
            .response = view.value_or(wire::ResponseView{}),
            .sent_at = sent,
            .request_end = sent + 4ms,
            .ended_at = sent + 10ms,
            .quiet_at = sent + 20ms};
}

SurplusFrame surplus(Instant t, const char* pdu) {
    return {UnitId{1}, frame_shape(hex(pdu)), frame_hash(hex(pdu)), t};
}

TEST(StepWatch, IsInStepAfterAPauseAndAfterAnotherShape) {
    const auto one = hex(kOne);
    const auto two = hex("03 04 11 11 22 22");
    StepWatch step;
    EXPECT_EQ(step.earliest(at(5s), kShapeOfOne), at(5s)) << "nothing was asked so far";
    Instant t = at(10s);
    const auto ask_for = [&](Duration time) {
        for (const Instant end = t + time; t < end; t += 12ms)
            step.on_outcome(answered(t, one, kOneRegister));
    };
    ask_for(900ms);
    EXPECT_EQ(step.earliest(t, kShapeOfOne), t);
    ask_for(200ms);
    EXPECT_GT(step.earliest(t, kShapeOfOne), t) << "without a pause for more than a second";
    EXPECT_EQ(step.earliest(t, kShapeOfTwo), t) << "its response shows whether the unit is behind";
    EXPECT_EQ(step.earliest(t + 10ms, kShapeOfOne), t + 10ms) << "a further response would have come";

    step.on_outcome(answered(t, two, kTwoRegisters));
    t += 12ms;
    EXPECT_EQ(step.earliest(t, kShapeOfOne), t);
    ask_for(1100ms);
    EXPECT_GT(step.earliest(t, kShapeOfOne), t);
    t += 20ms;
    step.on_outcome(answered(t, one, kOneRegister));
    EXPECT_EQ(step.earliest(t + 12ms, kShapeOfOne), t + 12ms) << "after a pause";
}

TEST(StepWatch, ASurplusFrameNamesTheTimeSinceWhenTheUnitMayBeBehind) {
    StepWatch step;
    const auto one = hex(kOne);
    for (Instant t = at(10s); t < at(10500ms); t += 12ms) step.on_outcome(answered(t, one, kOneRegister));
    EXPECT_EQ(step.on_surplus(surplus(at(10501ms), kOne)), std::nullopt) << "it repeats the last response";
    EXPECT_EQ(step.on_surplus(surplus(at(10502ms), "03 02 22 22")), at(10s)) << "a repetition proves nothing";
    EXPECT_EQ(step.on_surplus(surplus(at(10503ms), "03 02 22 22")), at(10502ms)) << "those before were named";

    step.on_outcome(answered(at(10504ms), one, kOneRegister));
    for (Instant t = at(10516ms); t < at(10720ms); t += 12ms) step.on_outcome(answered(t, one, kOneRegister));
    EXPECT_GT(step.earliest(at(10725ms), kShapeOfOne), at(10725ms)) << "checked more often for some minutes";
}

// A copy of the past can have another shape than the response before it, too.
TEST(StepWatch, TheResponseOfAnotherShapeIsNamedToo) {
    const auto one = hex(kOne);
    StepWatch step;
    Instant t = at(10s);
    for (; t < at(10500ms); t += 12ms) step.on_outcome(answered(t, one, kOneRegister));
    step.on_outcome(answered(t, hex("03 04 11 11 22 22"), kTwoRegisters));
    EXPECT_EQ(step.on_surplus(surplus(t + 15ms, "03 04 33 33 44 44")), t) << "since its request";
}

// An exception does not show which request of its function it answers, and it fills the pause.
TEST(StepWatch, AnExceptionIsNoPauseAndNoOtherShape) {
    const auto one = hex(kOne);
    const auto exception = hex("83 02");
    StepWatch step;
    Instant t = at(10s);
    for (; t < at(11100ms); t += 24ms) {
        step.on_outcome(answered(t, one, kOneRegister));
        auto refused = answered(t + 12ms, exception, kOneRegister);
        refused.status = Status::exception;
        step.on_outcome(refused);
    }
    EXPECT_GT(step.earliest(t, kShapeOfOne), t);
}

TEST(StepWatch, AnOutcomeWithoutAResponseIsNoAnswer) {
    const auto one = hex(kOne);
    StepWatch step;
    Instant t = at(10s);
    for (; t < at(11100ms); t += 12ms) step.on_outcome(answered(t, one, kOneRegister));
    for (const auto status : {Status::timeout, Status::bad_checksum, Status::unexpected_reply}) {
        auto missing = answered(t + 20ms, {}, kTwoRegisters);
        missing.status = status;
        step.on_outcome(missing);
    }
    auto broadcast = answered(t + 20ms, {}, kTwoRegisters);
    broadcast.unit = kBroadcast;
    step.on_outcome(broadcast);
    EXPECT_GT(step.earliest(t, kShapeOfOne), t);
}

TEST(StepWatch, AUnitThatOftenAnswersTwiceIsCheckedAfterEachResponse) {
    const auto one = hex(kOne);
    StepWatch step;
    Instant t = at(10s);
    for (int i = 0; i < 8; ++i) {
        step.on_outcome(answered(t, one, kOneRegister));
        (void)step.on_surplus(surplus(t + 12ms, "03 02 22 22"));
        EXPECT_GT(step.earliest(t + 13ms, kShapeOfOne), t + 13ms) << "until none follows";
        t += 40ms;
    }
    step.on_outcome(answered(t, one, kOneRegister));
    EXPECT_GT(step.earliest(t + 12ms, kShapeOfOne), t + 12ms);
    t += 2s;
    step.on_outcome(answered(t, one, kOneRegister));
    EXPECT_EQ(step.earliest(t + 12ms, kShapeOfOne), t + 12ms) << "none for a second";
}

// The response that shows that the unit is in step is itself followed by a further one.
TEST(StepWatch, AUnitThatAnswersEverythingTwiceIsLeftAPauseAfterAnotherShapeToo) {
    const auto one = hex(kOne);
    const auto two = hex("03 04 11 11 22 22");
    StepWatch step;
    Instant t = at(10s);
    for (int i = 0; i < 10; ++i) {
        step.on_outcome(answered(t, one, kOneRegister));
        (void)step.on_surplus(surplus(t + 12ms, "03 02 22 22"));
        t += 40ms;
    }
    step.on_outcome(answered(t, one, kOneRegister));
    step.on_outcome(answered(t + 12ms, two, kTwoRegisters));
    t += 22ms;
    EXPECT_GT(step.earliest(t, kShapeOfTwo), t);
    EXPECT_GT(step.earliest(t, kShapeOfOne), t);
}

TEST(StepWatch, ALateResponseLengthensThePauseAndShowsAnotherShape) {
    const auto one = hex(kOne);
    StepWatch step;
    Instant t = at(10s);
    for (; t < at(11100ms); t += 12ms) step.on_outcome(answered(t, one, kOneRegister));
    const Instant pause = step.earliest(t, kShapeOfOne);
    step.on_late(t + 5ms, kShapeOfOne);
    EXPECT_GT(step.earliest(t + 6ms, kShapeOfOne), pause);
    step.on_late(t + 7ms, kShapeOfTwo);
    EXPECT_EQ(step.earliest(t + 8ms, kShapeOfTwo), t + 8ms) << "one that is behind shows the shape before";
}

/// A gateway that serves one request after the other, 15 ms each. The data of each response is the number of
/// its request.
struct Gateway {
    struct Response {
        Instant at;
        std::vector<std::uint8_t> frame;
    };
    std::deque<Response> responses;
    Instant busy_until = at(0ms);
    std::uint16_t requests = 0;

    void on_request(Instant t, int times) {
        ++requests;
        for (int i = 0; i < times; ++i) {
            busy_until = std::max(t, busy_until) + 15ms;
            const auto high = static_cast<std::uint8_t>(requests >> 8);
            const auto low = static_cast<std::uint8_t>(requests & 0xFF);
            const std::vector<std::uint8_t> pdu{3, 2, high, low};
            const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{1}, 0, pdu);
            responses.push_back({busy_until, {frame.begin(), frame.end()}});
        }
    }
};

TEST(StepWatch, AShiftOfABusyUnitIsFoundWithinASecondAndEnds) {
    LineConfig config = kLine;
    config.format.baud = 0;  // RTU over TCP
    Rig line(config);
    Gateway gateway;
    UnitTimes times;
    int wrong = 0;
    int wrong_at_the_end = 0;
    std::optional<Instant> since;
    std::optional<Instant> found;
    const auto receive_until = [&](Instant t) {
        const Instant next = gateway.responses.empty() ? kNever : gateway.responses.front().at;
        line.run_until(std::min(next, t));
        if (line.now != next) return;
        const auto frame = gateway.responses.front().frame;
        gateway.responses.pop_front();
        line.receive(line.now, frame);
        while (const auto surplus = line.engine.take_surplus()) {
            const auto marked = times.step.on_surplus(*surplus);
            if (!found && marked) since = marked;
            if (!found) found = surplus->at;
        }
    };
    while (line.now < at(6s)) {
        auto asked = transaction(gateway.requests + 1U, 1, kOneRegister);
        times.set(asked, 100ms);
        receive_until(times.step.earliest(line.now, kShapeOfOne));
        line.submit(line.now, asked);
        line.transmit(line.now);
        gateway.on_request(line.now, gateway.requests == 100 ? 2 : 1);
        const auto count = line.outcomes.size();
        while (line.outcomes.size() == count) receive_until(line.engine.next_wakeup());
        const auto& outcome = line.last();
        times.on_response(response_delay(line.engine.config(), outcome), true);
        if (outcome.status != Status::ok) continue;
        times.step.on_outcome(outcome);
        const auto data = outcome.response.pdu();
        const bool right = (data[2] << 8 | data[3]) == gateway.requests;
        wrong += !right;
        if (!right && line.now > at(4s)) ++wrong_at_the_end;
    }
    ASSERT_TRUE(found);
    EXPECT_GT(wrong, 0) << "nothing shows the first ones";
    EXPECT_EQ(wrong_at_the_end, 0);
    const Instant doubled = at(100 * 15ms);
    EXPECT_LT(*found, doubled + StepWatch::kInterval + 100ms);
    ASSERT_TRUE(since);
    EXPECT_LE(*since, doubled + 30ms);
}

}  // namespace step_watch_test
}  // namespace takt::bus
