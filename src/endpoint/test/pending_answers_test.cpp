// The life of a pending answer: issued once, completed once, in any order of its parts.
#include "takt/endpoint/pending_answers.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "support.hpp"

namespace takt::endpoint {
namespace pending_answers_test {

using test::pdu;
using test::to_hex;
using Kind = serve::Answer::Kind;

struct Bench {
    Bench() { pending.add(answers); }

    /// Handles a write whose answer waits for so many parts.
    serve::Token write(int parts) {
        const auto request = pdu("06 00 01 00 02");
        pending.begin(request.span());
        serve::Token token = 0;
        for (int i = 0; i < parts; ++i) token = pending.put_off();
        const auto answer = pending.end(serve::Answer::response(request));
        EXPECT_EQ(answer.kind, parts > 0 ? Kind::pending : Kind::response);
        EXPECT_EQ(answer.token, token);
        return token;
    }

    test::Answers answers;
    PendingAnswers pending;
};

TEST(PendingAnswers, WithoutPartsTheAnswerIsGivenAtOnce) {
    Bench bench;
    bench.write(0);
    EXPECT_EQ(bench.pending.size(), 0u);
}

TEST(PendingAnswers, TheLastPartDelivers) {
    Bench bench;
    const auto token = bench.write(2);
    bench.pending.done(token);
    EXPECT_TRUE(bench.answers.given.empty());
    bench.pending.done(token);
    EXPECT_EQ(bench.answers.of(token), "06 00 01 00 02");
    bench.pending.done(token);
    EXPECT_EQ(bench.answers.given.size(), 1u) << "a part too many";
    EXPECT_EQ(bench.pending.size(), 0u);
}

TEST(PendingAnswers, TheFirstRefusalIsTheAnswer) {
    Bench bench;
    const auto token = bench.write(3);
    bench.pending.done(token);
    bench.pending.done(token, wire::ExceptionCode::server_device_failure);
    bench.pending.done(token, wire::ExceptionCode::server_device_busy);
    EXPECT_EQ(bench.answers.of(token), "86 04");
}

TEST(PendingAnswers, APartDoneDuringTheHandlingDelaysNothing) {
    Bench bench;
    const auto request = pdu("06 00 01 00 02");
    for (const bool refused : {false, true}) {
        bench.pending.begin(request.span());
        const auto done = bench.pending.put_off_until_called();
        done(refused ? PendingAnswers::Refusal(wire::ExceptionCode::illegal_data_value) : std::nullopt);
        const auto answer = bench.pending.end(serve::Answer::response(request));
        EXPECT_EQ(answer.kind, Kind::response);
        EXPECT_EQ(to_hex(answer.pdu.span()), refused ? "86 03" : "06 00 01 00 02");
    }
    EXPECT_TRUE(bench.answers.given.empty());
}

TEST(PendingAnswers, ABroadcastWaitsForNothing) {
    Bench bench;
    const auto request = pdu("06 00 01 00 02");
    bench.pending.begin(request.span());
    const auto token = bench.pending.put_off();
    EXPECT_EQ(bench.pending.end({}).kind, Kind::silence);
    EXPECT_EQ(bench.pending.size(), 0u);
    bench.pending.done(token);
    EXPECT_TRUE(bench.answers.given.empty());
}

TEST(PendingAnswers, ARelayedAnswerIsTheWholeAnswer) {
    Bench bench;
    bench.pending.begin(pdu("03 00 00 00 01").span());
    const auto token = bench.pending.put_off();
    EXPECT_EQ(bench.pending.end(serve::Answer::pending(token)).kind, Kind::pending);
    bench.pending.complete(token, pdu("03 02 00 07").span());
    EXPECT_EQ(bench.answers.of(token), "03 02 00 07");
}

TEST(PendingAnswers, OfAClientThatIsGoneAreNotDelivered) {
    Bench bench;
    const auto token = bench.write(1);
    bench.pending.forget(token);
    bench.pending.done(token);
    bench.pending.complete(token, pdu("03 02 00 07").span());
    EXPECT_TRUE(bench.answers.given.empty());
}

TEST(PendingAnswers, PartsMayOutliveTheirRouter) {
    PendingAnswers::Done late;
    {
        PendingAnswers pending;
        pending.begin(pdu("06 00 01 00 02").span());
        late = pending.put_off_until_called();
        (void)pending.end(serve::Answer::response(pdu("06 00 01 00 02")));
    }
    late({});
}

TEST(PendingAnswers, GoToTheListenerThatWaitsAndToTheObserverFirst) {
    test::Answers other;
    Bench bench;
    std::vector<serve::Token> seen;
    bench.pending.add(other);
    bench.pending.set_observer([&](serve::Token token, Bytes) {
        EXPECT_FALSE(bench.answers.has(token)) << "before it is delivered";
        seen.push_back(token);
    });
    const auto first = bench.write(1);
    const auto second = bench.write(1);
    EXPECT_NE(first, second);
    bench.answers.only = first;
    bench.pending.done(second);
    bench.pending.done(first);
    EXPECT_TRUE(other.has(second));
    EXPECT_TRUE(bench.answers.has(first));
    EXPECT_FALSE(other.has(first));
    EXPECT_EQ(seen, (std::vector{second, first}));
}

TEST(PendingAnswers, AClientMayAskAgainFromInsideTheDelivery) {
    Bench bench;
    const auto first = bench.write(1);
    serve::Token second = 0;
    bench.answers.on_answer = [&] { second = bench.write(1); };
    bench.pending.done(first);
    bench.answers.on_answer = {};
    EXPECT_EQ(bench.pending.size(), 1u);
    bench.pending.done(second);
    EXPECT_TRUE(bench.answers.has(second));
}

// With any order of the parts of many requests, each is answered once, after its last part.
RC_GTEST_PROP(PendingAnswers, EachIsAnsweredOnceAfterItsLastPart, ()) {
    Bench bench;
    std::vector<serve::Token> parts;
    std::map<serve::Token, int> left;
    for (int i = 0; i < 10; ++i) {
        const int count = *rc::gen::inRange(1, 4);
        const auto token = bench.write(count);
        parts.insert(parts.end(), static_cast<std::size_t>(count), token);
        left[token] = count;
    }
    while (!parts.empty()) {
        const auto at = *rc::gen::inRange<std::size_t>(0, parts.size());
        const auto token = parts[at];
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(at));
        bench.pending.done(token);
        RC_ASSERT(bench.answers.has(token) == (--left[token] == 0));
    }
    RC_ASSERT(bench.answers.given.size() == left.size());
}

}  // namespace pending_answers_test
}  // namespace takt::endpoint
