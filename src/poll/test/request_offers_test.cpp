// What a line offers to its arbiter, without a poller. The order of what is sent is tested in
// polling_test.cpp and read_queue_test.cpp.
#include "line/request_offers.hpp"

#include <gtest/gtest.h>

#include "line/transfer.hpp"
#include "write_fixture.hpp"

namespace takt::poll::test {
namespace request_offers_test {

constexpr std::size_t kPolled = 0;
constexpr std::size_t kTriggered = 1;
constexpr std::size_t kGroup = 2;

/// A line with one device, whose link came up at 0 s. Request 0 polls a register each 100 ms, request 1 reads
/// another one by a trigger, request 2 writes a third one on change.
class Line : public WriteFixture {
public:
    explicit Line(bool distinct_reads = true)
        : WriteFixture({Item(int16("a", 0).read(3)), Item(int16("b", 1).read(3)),
                        Item(int16("c", 2).write(0x10).on_change())}),
          described(
              project({device(1, {int16("a", 0).read(3), int16("b", 1).read(3), int16("d", 2).read(3)})})),
          engine({.format = described.lines[0].format}),
          commands(values, 16),
          reads(tables(), arrivals),
          groups(values, commands, arrivals),
          distinct(described, described.lines[0], tables()),
          arbiter(1, 0ms, false),
          offers({.engine = engine,
                  .tables = tables(),
                  .reads = reads,
                  .write_groups = groups,
                  .commands = commands,
                  .distinct_reads = distinct_reads ? &distinct : nullptr,
                  .arbiter = arbiter},
                 false) {
        for (std::size_t v = 0; v < models.size(); ++v)
            variables.push_back({.model = &models[v], .slot = slot(v)});
        auto& only = devices.emplace_back();
        only.model = &described.lines[0].devices[0];
        only.health = DeviceHealth(1, {.first = 8s, .limit = 8s}, true);
        only.health.set_reads(true);
        only.delay_learner = DelayLearner(*only.model, 100ms, false);
        only.requests = {kPolled, kTriggered, kGroup};
        plans.resize(3);
        plans[kPolled].period = 100ms;
        plans[kPolled].read = plans[kTriggered].read = Function::read_holding_registers;
        plans[kPolled].quantity = 3;
        requests.resize(3);
        for (std::size_t r = 0; r < 3; ++r) requests[r].plan = &plans[r];
        add_read(kPolled, 3);
        add_read(kTriggered, 1);
        groups.add(kGroup,
                   {.plan = &plans[kGroup],
                    .members = {2},
                    .shape = bus::answer_shape(Function::write_multiple_registers, 1),
                    .rank = 5},
                   true, false);
        distinct.set_requests(plans);
        arbiter.set_plan(0.5, 3);
        offers.set_requests();
        engine.on_link(at(0s), true);
        reads.restart(at(0s), 0);
        now = at(10ms);
    }

    /// What is sent next: the offers of a choice, and the arbiter's decision.
    std::optional<Candidate> choose() {
        arbiter.begin();
        offers.offer_requests(now);
        offers.offer_early_probes(now);
        return arbiter.choose();
    }
    /// The read is sent, and ends at `end` without a response.
    void fail(std::size_t read, Instant end) {
        bus::Transaction transaction{
            .id = read, .unit = UnitId{1}, .request = offers.read_to_send(now, read)};
        ASSERT_TRUE(engine.submit(now, transaction));
        ASSERT_FALSE(engine.transmit(now).empty());
        requests[read].read->last_start = now;
        reads.start(now, read, false);
        engine.on_tick(end);
        ASSERT_EQ(engine.take_outcome()->status, bus::Status::timeout);
        reads.ended(read);
        now = end;
    }
    void set(std::size_t variable, std::int64_t value) {
        values.want(variable, written(variable, number(value)));
        groups.set(now, variable);
        offers.note_event(kGroup);
    }

    model::Project described;
    std::vector<plan::Request> plans;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    bus::TransactionEngine engine;
    ArrivalCounter arrivals;
    CommandQueue commands;
    ReadSchedule reads;
    WriteGroups groups;
    DistinctReads distinct;
    bus::Arbiter arbiter;
    RequestOffers offers;
    Instant now;

private:
    [[nodiscard]] LineTables tables() const { return {variables, devices, requests}; }
    void add_read(std::size_t index, std::uint16_t quantity) {
        requests[index].read =
            ReadJob{.request = prepared({Function::read_holding_registers, DataAddress{0}, quantity}),
                    .rank = 2 * index,
                    .deadline = 100ms,
                    .polled = index == kPolled};
        std::optional<RateLimitedEvent> trigger;
        if (index == kTriggered) trigger = RateLimitedEvent(model::RateLimit{1s, 1});
        reads.add(index, index == kPolled ? 100ms : 0ms, std::move(trigger));
    }
};

std::optional<bus::TransactionId> job(const std::optional<Candidate>& candidate) {
    return candidate ? std::optional(candidate->job) : std::nullopt;
}

TEST(RequestOffers, APolledReadIsOfferedWhenItIsDue) {
    Line line;
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::read, kPolled));
    line.reads.start(line.now, kPolled, false);
    EXPECT_EQ(line.choose(), std::nullopt) << "it is in flight";
    line.reads.ended(kPolled);
    EXPECT_EQ(line.choose(), std::nullopt);
    EXPECT_EQ(line.arbiter.wakeup(), at(100ms)) << "its next release";
}

TEST(RequestOffers, NothingIsOfferedBeforeTheLineIsSilent) {
    Line line;
    line.now = at(0s);
    EXPECT_EQ(line.choose(), std::nullopt);
    EXPECT_EQ(line.arbiter.wakeup(), line.offers.line_free());
    EXPECT_GT(line.offers.line_free(), at(0s));
}

TEST(RequestOffers, ATriggerGoesFirstAndPassesItsBucket) {
    Line line;
    line.reads.pull_trigger(line.now, kTriggered);
    line.offers.note_event(kTriggered);
    const auto chosen = line.choose();
    EXPECT_EQ(job(chosen), transaction_id(JobKind::read, kTriggered));
    EXPECT_TRUE(chosen->by_trigger);
    line.reads.start(line.now, kTriggered, true);
    line.reads.ended(kTriggered);
    line.reads.start(line.now, kPolled, false);
    line.reads.ended(kPolled);
    line.reads.pull_trigger(line.now, kTriggered);
    line.offers.note_event(kTriggered);
    EXPECT_EQ(line.choose(), std::nullopt) << "one token a second";
    line.now = at(1010ms);
    line.choose();
    EXPECT_EQ(job(line.arbiter.best()), transaction_id(JobKind::read, kTriggered));
}

TEST(RequestOffers, AGroupIsOfferedWhenItIsDueAndItsDeviceDoesNotWrite) {
    Line line;
    line.set(2, 7);
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::group_write, kGroup));
    line.devices[0].writing = true;
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::read, kPolled)) << "writes keep their order";
    line.devices[0].in_flight = 1;
    EXPECT_EQ(line.choose(), std::nullopt) << "the device takes no further transaction";
}

TEST(RequestOffers, ALineThatPollsNoMoreIsOfferedWritesAlone) {
    Line line;
    line.arbiter.begin();
    line.offers.offer_writes(line.now);
    EXPECT_EQ(line.arbiter.choose(), std::nullopt);
    line.set(2, 7);
    line.offers.offer_writes(line.now);
    EXPECT_EQ(job(line.arbiter.choose()), transaction_id(JobKind::group_write, kGroup));
}

TEST(RequestOffers, AProbeGoesOutEarlyIfNothingIsDueBeforeItHasTimedOut) {
    Line line;
    auto& health = line.devices[0].health;
    line.fail(kPolled, at(200ms));
    line.now = at(400ms);
    health.ended(at(10ms), line.now, {.reason = value::Reason::timeout}, false);
    ASSERT_TRUE(health.probed());
    ASSERT_EQ(health.probe_at(), at(8400ms));
    line.requests[kTriggered].read->last_start = at(20ms);
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::read, kPolled)) << "the read sent least recently";
    line.arbiter.begin();
    line.offers.offer_requests(line.now);
    EXPECT_EQ(line.arbiter.best(), std::nullopt) << "its back-off has not passed";
    line.arbiter.wake_at(after(line.now, 100ms));
    line.offers.offer_early_probes(line.now);
    EXPECT_EQ(line.arbiter.best(), std::nullopt) << "something is due before its time-out of 100 ms";
    line.now = health.probe_at();
    line.arbiter.begin();
    line.offers.offer_requests(line.now);
    EXPECT_NE(line.arbiter.best(), std::nullopt);
}

TEST(RequestOffers, AReadWhoseResponseCouldBeMistakenIsReplaced) {
    Line line;
    line.fail(kPolled, at(200ms));
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::read, kPolled));
    const auto sent = line.offers.read_to_send(line.now, kPolled);
    EXPECT_LT(sent.quantity(), 3) << "a part: nothing else may be read";
    EXPECT_FALSE(line.distinct.whole(kPolled));
}

TEST(RequestOffers, WithoutDistinctReadsAReadWhoseResponseCouldBeMistakenWaits) {
    Line line(false);
    line.fail(kPolled, at(200ms));
    EXPECT_EQ(line.choose(), std::nullopt);
    EXPECT_GT(line.arbiter.wakeup(), line.now);
    line.now = line.arbiter.wakeup();
    EXPECT_EQ(job(line.choose()), transaction_id(JobKind::read, kPolled));
    EXPECT_EQ(line.offers.read_to_send(line.now, kPolled).quantity(), 3);
}

}  // namespace request_offers_test
}  // namespace takt::poll::test
