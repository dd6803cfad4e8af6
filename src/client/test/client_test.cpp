// Repetition, time-outs and errors of one-off requests, over a scripted connection.
#include "takt/client/client.hpp"

#include <gtest/gtest.h>

#include "scripted_connection.hpp"
#include "takt/client/probe_connection.hpp"
#include "takt/client/raw_request.hpp"

namespace takt::client {
namespace client_test {

using namespace test;

const wire::ReadRequest kRead{wire::Function::read_holding_registers, DataAddress{7}, 1};
const ByteVector kAnswer{0x03, 2, 0x12, 0x34};
const ByteVector kRefusal{0x83, 2};

wire::PreparedRequest prepared() {
    return *wire::prepare(kRead);
}

Options attempts(std::uint16_t count) {
    Options options;
    options.attempts = count;
    options.timeout = 1s;
    return options;
}

TEST(Client, GivesTheResponseAndCountsTransmissions) {
    Rig rig({{1ms, kAnswer}, {1ms, kAnswer}});
    const auto response = rig.client->ask(kRead);
    ASSERT_TRUE(response);
    ASSERT_EQ(response->registers().size(), 1U);
    EXPECT_EQ(response->registers()[0], 0x1234);
    EXPECT_TRUE(rig.client->ask(kRead));
    EXPECT_EQ(rig.client->transmissions(), 2U);
    EXPECT_EQ(rig.connection->requests.front(), (ByteVector{0x03, 0, 7, 0, 1}));
}

TEST(Client, RepeatsALostRequestUpToItsAttempts) {
    Rig rig({{}, {}, {1ms, kAnswer}}, attempts(3));
    EXPECT_TRUE(rig.client->ask(kRead));
    EXPECT_EQ(rig.connection->requests.size(), 3U);

    Rig silent({}, attempts(2));
    const auto response = silent.client->ask(kRead);
    ASSERT_FALSE(response);
    EXPECT_EQ(response.error().code, Code::timed_out);
    EXPECT_EQ(response.error().subject.view(), "tcp://plc");
    EXPECT_EQ(response.error().numbers[0], 1000);
    EXPECT_EQ(silent.connection->requests.size(), 2U);
}

TEST(Client, NamesALateResponseAndATimeoutThatIsLongEnough) {
    Options options = attempts(1);
    options.timeout = 100ms;
    Rig impatient({{148ms, kAnswer}}, options);
    EXPECT_EQ(impatient.client->ask(kRead).error().numbers[1], 0);
    options.late_wait = 1s;
    Rig rig({{148ms, kAnswer}}, options);
    const Instant begin = rig.client->now();
    const auto response = rig.client->ask(kRead);
    ASSERT_FALSE(response);
    EXPECT_EQ(response.error(), (Error{Code::timed_out, "tcp://plc", {100, 148, 200}}));
    EXPECT_EQ(rig.client->now() - begin, 148ms) << "no longer than it needs";
    Rig silent({}, options);
    EXPECT_EQ(silent.client->ask(kRead).error(), (Error{Code::timed_out, "tcp://plc", {100}}));
    options.timeout = 200ms;
    Rig advised({{148ms, kAnswer}}, options);
    EXPECT_TRUE(advised.client->ask(kRead));
}

TEST(Client, TransmitsOnceWhatMustNotBeRepeated) {
    Rig rig({}, attempts(5));
    EXPECT_FALSE(rig.client->transact(prepared(), false));
    EXPECT_EQ(rig.connection->requests.size(), 1U);
}

TEST(Client, AnExceptionIsAResponseAndNotRepeated) {
    Rig rig({{1ms, kRefusal}, {1ms, kRefusal}}, attempts(3));
    const auto response = rig.client->transact(prepared());
    ASSERT_TRUE(response);
    EXPECT_EQ(response->exception(), 2);
    const auto asked = rig.client->ask(kRead);
    ASSERT_FALSE(asked);
    EXPECT_EQ(asked.error().code, Code::modbus_exception);
    EXPECT_EQ(asked.error().numbers[0], 2);
    EXPECT_EQ(rig.connection->requests.size(), 2U);
}

TEST(Client, ALostConnectionEndsTheRequestAtOnce) {
    Rig rig({{.delay = 5ms, .lost_link = true}, {1ms, kAnswer}}, attempts(3));
    const auto response = rig.client->ask(kRead);
    ASSERT_FALSE(response);
    EXPECT_EQ(response.error().code, Code::connection_lost);
    EXPECT_EQ(rig.connection->requests.size(), 1U);
    EXPECT_FALSE(rig.client->connected());
    const auto next = rig.client->ask(kRead);
    ASSERT_FALSE(next);
    EXPECT_EQ(next.error().code, Code::connection_lost);
}

TEST(Client, AStreamOutOfStepIsNotModbus) {
    Rig rig({{.raw = {0, 1, 0xFF, 0xFF, 0, 3, 1, 3, 0}}}, attempts(3));
    const auto response = rig.client->ask(kRead);
    ASSERT_FALSE(response);
    EXPECT_EQ(response.error().code, Code::not_modbus);
}

TEST(Client, AResponseThatDoesNotFitIsRepeated) {
    Rig rig({{1ms, {0x03, 4, 0, 1, 0, 2}}, {1ms, kAnswer}}, attempts(2));
    EXPECT_TRUE(rig.client->ask(kRead));
    Rig once({{1ms, {0x03, 4, 0, 1, 0, 2}}}, attempts(1));
    EXPECT_EQ(once.client->ask(kRead).error().code, Code::unexpected_reply);
}

TEST(Client, AStopEndsTheWaitAndTheRepetition) {
    Rig rig({}, attempts(9));
    rig.connection->stop_after(2);
    EXPECT_FALSE(rig.client->ask(kRead));
    EXPECT_TRUE(rig.client->interrupted());
    EXPECT_EQ(rig.connection->requests.size(), 2U);
}

// Eight responses of 10 ms: the first attempt then waits 4 * 10 ms + 50 ms, the last one the whole time-out.
TEST(Client, AnAdaptiveTimeOutFollowsTheSlowestResponse) {
    auto options = attempts(2);
    options.adaptive = true;
    std::vector<Reply> replies(8, {10ms, kAnswer});
    Rig rig(replies, options);
    for (int i = 0; i < 8; ++i) ASSERT_TRUE(rig.client->ask(kRead));
    const Instant begin = rig.client->now();
    EXPECT_FALSE(rig.client->ask(kRead));
    const auto& sent = rig.connection->sent_at;
    const Duration first = sent[9] - sent[8];
    EXPECT_GE(first, 90ms);
    EXPECT_LT(first, 110ms);
    EXPECT_GE(rig.client->now() - begin, 1090ms);
}

TEST(Client, TimeOutsStayWholeUntilEnoughResponsesAreKnown) {
    auto options = attempts(2);
    options.adaptive = true;
    Rig rig(std::vector<Reply>(7, {10ms, kAnswer}), options);
    for (int i = 0; i < 7; ++i) ASSERT_TRUE(rig.client->ask(kRead));
    EXPECT_FALSE(rig.client->ask(kRead));
    const auto& sent = rig.connection->sent_at;
    EXPECT_GE(sent[8] - sent[7], 1s);
}

TEST(Client, PausesForTheGivenTime) {
    Rig rig({});
    const Instant begin = rig.client->now();
    rig.client->pause(250ms);
    EXPECT_EQ(rig.client->now() - begin, 250ms);
}

TEST(ProbeConnection, GivesCodesOfExceptionsAndNeverTakesZeroForSuccess) {
    Rig rig({{1ms, kAnswer}, {1ms, kRefusal}, {1ms, {0x83, 0}}});
    ProbeConnection connection(*rig.client);
    EXPECT_EQ(connection.transact(prepared()).value(), 0);
    EXPECT_EQ(connection.transact(prepared()).value(), 2);
    EXPECT_EQ(connection.transact(prepared()).value(), 255);
    EXPECT_EQ(connection.transact(prepared()).error().code, Code::timed_out);
    EXPECT_FALSE(connection.interrupted());
}

TEST(RawRequest, ReadsDigitsInAnyGrouping) {
    for (const auto& words : std::vector<std::vector<std::string>>{
             {"03", "00", "07", "00", "01"}, {"0x03", "0X0007", "0001"}, {"03:00:07,00 01"}}) {
        const auto pdu = parse_pdu(words);
        ASSERT_TRUE(pdu);
        EXPECT_EQ(ByteVector(pdu->begin(), pdu->end()), (ByteVector{3, 0, 7, 0, 1}));
    }
}

TEST(RawRequest, RejectsOddForeignAndTooManyDigits) {
    EXPECT_EQ(parse_pdu({}).error().code, Code::syntax);
    EXPECT_EQ(parse_pdu({"030"}).error().subject.view(), "030");
    EXPECT_EQ(parse_pdu({"03", "g0"}).error().subject.view(), "g0");
    EXPECT_TRUE(parse_pdu({std::string(2 * wire::kMaxPdu, '0')}));
    const auto longer = parse_pdu({std::string(2 * wire::kMaxPdu + 2, '0')});
    ASSERT_FALSE(longer);
    EXPECT_EQ(longer.error().code, Code::too_long);
    EXPECT_EQ(longer.error().numbers[0], static_cast<std::int64_t>(wire::kMaxPdu) + 1);
}

}  // namespace client_test
}  // namespace takt::client
