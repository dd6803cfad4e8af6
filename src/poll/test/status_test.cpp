// The status of variables that are not polled: that of their device while it is away, else of their last
// read or write.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace status_test {

using namespace test;

class Statuses : public testing::Test {
protected:
    static model::Project described() {
        return project({device(1, {int16("polled", 0).read(3).every(50ms).reports_to(0),
                                   int16("w", 5).write(0x06).reports_to(1),
                                   int16("r", 9).read(4).read_on(3).every(0ms).reports_to(2)})},
                       {local("s_polled", DataType::int16), local("s_w", DataType::int16),
                        local("s_r", DataType::int16), local("go")});
    }
    void run(Duration length) { bench.run_until(end += length); }
    std::vector<std::int64_t> statuses() const {
        return {bench.status("s_polled"), bench.status("s_w"), bench.status("s_r")};
    }

    Bench bench{described()};
    Duration end{};
};

using All = std::vector<std::int64_t>;

TEST_F(Statuses, ReturnWhenTheDeviceAnswersAgain) {
    run(200ms);
    ASSERT_TRUE(bench.write(1, "w", 5));
    run(200ms);
    EXPECT_EQ(bench.status("s_w"), 0);
    bench.players[1].dead = true;
    run(3s);
    EXPECT_EQ(bench.status("s_w"), 105);
    EXPECT_EQ(bench.status("s_polled"), 105);
    ASSERT_TRUE(bench.write(2, "w", 6));
    EXPECT_EQ(bench.status("s_w"), 105);
    bench.players[1].dead = false;
    run(10s);
    EXPECT_EQ(bench.status("s_w"), 0) << "the write that was refused was never sent";
    EXPECT_EQ(statuses()[0], 0);
    bench.link(false);
    EXPECT_EQ(bench.status("s_w"), 103);
    bench.link(true);
    run(1s);
    EXPECT_EQ(bench.status("s_w"), 0);
}

TEST_F(Statuses, AreThatOfTheLastWriteAfterTheReturn) {
    run(200ms);
    bench.players[1].exception = 3;
    ASSERT_TRUE(bench.write(1, "w", 5));
    run(100ms);
    EXPECT_EQ(bench.status("s_w"), 3);
    bench.players[1].exception.reset();
    bench.link(false);
    EXPECT_EQ(bench.status("s_w"), 103);
    bench.link(true);
    run(1s);
    EXPECT_EQ(statuses(), (All{0, 3, bench.status("s_r")}));
}

// The status and the outcome of a command give the same reason.
TEST_F(Statuses, OfADeadDeviceWithoutALinkIsThatOfTheLink) {
    run(200ms);
    bench.players[1].dead = true;
    run(3s);
    EXPECT_EQ(bench.status("s_w"), 105);
    bench.link(false);
    ASSERT_TRUE(bench.write(1, "w", 5));
    EXPECT_EQ(bench.status("s_w"), 103);
    const auto outcome = bench.master.take_outcome();
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->reason, value::Reason::link_lost);
}

TEST(Recovery, TheProbeIsTheFirstReadOfItsRequest) {
    auto described = device(1, {int16("a", 0).read(3).every(1h), int16("b", 50).read(3).every(1h)});
    Bench bench(project({described}));
    bench.players[1].dead = true;
    bench.run_until(5s);
    bench.players[1].dead = false;
    const auto before = bench.sent.size();
    bench.run_until(2min);
    ASSERT_EQ(bench.slot("a").quality, value::Quality::good);
    ASSERT_EQ(bench.slot("b").quality, value::Quality::good);
    EXPECT_EQ(bench.sent.size(), before + 4) << "the first two may be late responses to earlier probes";
}

}  // namespace status_test
}  // namespace takt::poll
