#include "takt/line/loop.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <thread>

#include "support.hpp"

namespace takt::line {
namespace loop_test {

TEST(Loop, TimersRunInOrderAndNeverEarly) {
    const auto loop = make_loop();
    const Instant start = now();
    std::vector<int> order;
    Timer late(*loop, [&](Instant t) {
        EXPECT_GE(t, start + 3ms);
        order.push_back(2);
    });
    Timer early(*loop, [&](Instant t) {
        EXPECT_GE(t, start + 1ms);
        order.push_back(1);
    });
    late.set(start + 3ms);
    early.set(start + 1ms);
    EXPECT_TRUE(loop->run_until([&] { return order.size() == 2; }, kDeadline));
    EXPECT_EQ(order, (std::vector{1, 2}));
    EXPECT_EQ(late.when(), kNever);
}

TEST(Loop, ATimerCanBeMovedCancelledAndSetAgainFromItsCallback) {
    const auto loop = make_loop();
    const Instant start = now();
    int moved_runs = 0;
    Timer moved(*loop, [&](Instant t) {
        EXPECT_GE(t, start + 5ms);
        ++moved_runs;
    });
    moved.set(start);  // has passed already, but the loop has not seen it
    moved.set(start + 5ms);
    bool cancelled_ran = false;
    Timer cancelled(*loop, [&](Instant) { cancelled_ran = true; });
    cancelled.set(start + 1ms);
    cancelled.set(kNever);
    int ticks = 0;
    Timer* self = nullptr;
    Timer repeated(*loop, [&](Instant t) {
        if (++ticks < 10) self->set(t + 1ms);
    });
    self = &repeated;
    repeated.set(start);
    EXPECT_TRUE(loop->run_until([&] { return ticks == 10 && moved_runs > 0; }, kDeadline));
    EXPECT_EQ(moved_runs, 1);
    EXPECT_FALSE(cancelled_ran);
}

TEST(Loop, ATimerMayBeDestroyedByItsCallback) {
    const auto loop = make_loop();
    std::unique_ptr<Timer> timer;
    timer = std::make_unique<Timer>(*loop, [&](Instant) { timer.reset(); });
    timer->set(now());
    EXPECT_TRUE(loop->run_until([&] { return !timer; }, kDeadline));
}

// However timers are set, moved and cancelled: each runs once, in the order of the moments they were set to
// last, none before its own.
RC_GTEST_PROP(Loop, TimersRunOnceInOrder, ()) {
    const auto moves = *rc::gen::container<std::vector<std::pair<int, int>>>(
        rc::gen::pair(rc::gen::inRange(0, 20), rc::gen::inRange(-1, 500)));
    const auto loop = make_loop();
    const Instant start = now();
    std::vector<std::unique_ptr<Timer>> timers;
    std::vector<Instant> set(20, kNever);
    std::vector<Instant> ran;
    for (std::size_t i = 0; i < set.size(); ++i)
        timers.push_back(std::make_unique<Timer>(*loop, [&, i](Instant t) {
            RC_ASSERT(t >= set[i]);
            ran.push_back(set[i]);
        }));
    for (const auto& [which, microseconds] : moves) {
        const auto index = static_cast<std::size_t>(which);
        set[index] = microseconds < 0 ? kNever : start + microseconds * 1us;
        timers[index]->set(set[index]);
        RC_ASSERT(timers[index]->when() == set[index]);
    }
    const auto expected = set.size() - static_cast<std::size_t>(std::ranges::count(set, kNever));
    RC_ASSERT(loop->run_until([&] { return ran.size() >= expected; }, kDeadline));
    loop->run_until([] { return false; }, 1ms);
    RC_ASSERT(ran.size() == expected);
    RC_ASSERT(std::ranges::is_sorted(ran));
    for (const auto& timer : timers) RC_ASSERT(timer->when() == kNever);
}

TEST(Loop, ATimerThatIsAlwaysDueHoldsUpNothingElse) {
    const auto loop = make_loop();
    Timer* self = nullptr;
    int ticks = 0;
    Timer restless(*loop, [&](Instant) {
        ++ticks;
        self->set({});
    });
    self = &restless;
    restless.set({});
    bool posted = false;
    loop->post([&] { posted = true; });
    EXPECT_TRUE(loop->run_until([&] { return posted && ticks > 10; }, kDeadline));
}

TEST(Loop, PostsFromOtherThreadsInOrder) {
    const auto loop = make_loop();
    std::vector<int> got;
    std::thread other([&] {
        for (int i = 0; i < 100; ++i) loop->post([&got, i] { got.push_back(i); });
        loop->post([&] { loop->stop(); });
    });
    loop->run();
    other.join();
    ASSERT_EQ(got.size(), 100u);
    EXPECT_TRUE(std::ranges::is_sorted(got));
    EXPECT_TRUE(loop->stopped());
}

// Each wait is longer than the loop spins: it spins first, and then sleeps.
TEST(Loop, ThatSpinsSleepsAfterwardsAndMissesNothing) {
    const auto loop = make_loop();
    loop->set_spin(200us);
    const Instant start = now();
    int ticks = 0;
    Timer* self = nullptr;
    Timer repeated(*loop, [&](Instant t) {
        EXPECT_GE(t, start + 2ms);
        if (++ticks < 5) self->set(t + 2ms);
    });
    self = &repeated;
    repeated.set(start + 2ms);
    int posted = 0;
    std::thread other([&] {
        for (int i = 0; i < 20; ++i) {
            loop->post([&] { ++posted; });
            std::this_thread::sleep_for(100us * i);
        }
    });
    EXPECT_TRUE(loop->run_until([&] { return ticks == 5 && posted == 20; }, kDeadline));
    other.join();
    const std::clock_t before = std::clock();
    EXPECT_FALSE(loop->run_until([] { return false; }, 200ms));
    const auto used = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    EXPECT_LT(used, 0.1) << "it has slept";
}

// The steady cycle makes the loop wake up early; an event that does not come must not keep it awake.
TEST(Loop, ThatExpectsEventsMissesNoneAndSleepsWhenTheyEnd) {
    const auto loop = make_loop();
    loop->set_spin(200us);
    std::array<int, 2> ends{};
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()), 0);
    const os::Descriptor ours(ends[0]), theirs(ends[1]);
    std::size_t got = 0;
    Watch* self = nullptr;
    Watch watch(*loop, ours.get(), [&] {
        std::array<char, 64> bytes{};
        got +=
            static_cast<std::size_t>(std::max<ssize_t>(::recv(ours.get(), bytes.data(), bytes.size(), 0), 0));
        self->want_read();
    });
    self = &watch;
    watch.want_read();
    std::thread other([&] {
        for (int i = 0; i < 60; ++i) {
            std::this_thread::sleep_for(i < 40 ? 2ms : 100us * i);
            ASSERT_EQ(::send(theirs.get(), "x", 1, 0), 1);
        }
    });
    EXPECT_TRUE(loop->run_until([&] { return got == 60; }, kDeadline));
    other.join();
    const std::clock_t before = std::clock();
    EXPECT_FALSE(loop->run_until([] { return false; }, 200ms));
    const auto used = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    EXPECT_LT(used, 0.1) << "it has slept";
}

TEST(Loop, MayBeStoppedBeforeItRuns) {
    const auto loop = make_loop();
    loop->stop();
    loop->run();
    EXPECT_FALSE(loop->run_until([] { return false; }, kDeadline));
}

TEST(Loop, GivesUpAtTheLimit) {
    const auto loop = make_loop();
    EXPECT_FALSE(loop->run_until([] { return false; }, 5ms));
    EXPECT_FALSE(loop->stopped());
}

TEST(Loop, ReportsSignals) {
    const auto loop = make_loop();
    std::vector<int> got;
    ASSERT_TRUE(loop->on_signals({SIGINT, SIGTERM}, [&](int number) {
        got.push_back(number);
        if (got.size() == 1) ::raise(SIGTERM);
    }));
    ::raise(SIGINT);
    EXPECT_TRUE(loop->run_until([&] { return got.size() == 2; }, kDeadline));
    EXPECT_EQ(got, (std::vector{SIGINT, SIGTERM}));
}

TEST(Watch, ReportsWhatCanBeReadOncePerRequest) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    const os::Descriptor one(ends[0]);
    const os::Descriptor other(ends[1]);
    int calls = 0;
    Watch watch(*loop, one.get(), [&] { ++calls; });
    ASSERT_TRUE(watch.ok());
    watch.want_read();
    watch.want_read();
    ASSERT_EQ(::write(other.get(), "x", 1), 1);
    EXPECT_TRUE(loop->run_until([&] { return calls == 1; }, kDeadline));
    // Nothing was read: a new request is answered for the same byte.
    watch.want_read();
    EXPECT_TRUE(loop->run_until([&] { return calls == 2; }, kDeadline));
}

TEST(Watch, MayBeDestroyedByItsCallback) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    const os::Descriptor one(ends[0]);
    const os::Descriptor other(ends[1]);
    std::unique_ptr<Watch> watch;
    watch = std::make_unique<Watch>(*loop, one.get(), [] {}, [&] { watch.reset(); });
    watch->want_read();
    watch->want_write();
    EXPECT_TRUE(loop->run_until([&] { return !watch; }, kDeadline));
}

TEST(Watch, IsNotCalledOnceAnotherHasDestroyedIt) {
    const auto loop = make_loop();
    int ends[2][2];
    std::vector<os::Descriptor> held;
    std::array<std::unique_ptr<Watch>, 2> watches;
    int calls = 0;
    for (std::size_t i = 0; i < 2; ++i) {
        ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends[i]), 0);
        held.emplace_back(ends[i][0]);
        held.emplace_back(ends[i][1]);
        watches[i] = std::make_unique<Watch>(*loop, ends[i][0], [&, i] {
            ++calls;
            watches[1 - i].reset();
        });
        watches[i]->want_read();
        ASSERT_EQ(::write(ends[i][1], "x", 1), 1);
    }
    loop->run_until([] { return false; }, 5ms);
    EXPECT_EQ(calls, 1);
}

TEST(Watch, ReportsAPeerThatIsGoneWhenItIsAskedAgain) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    const os::Descriptor one(ends[0]);
    int reads = 0;
    int writes = 0;
    Watch watch(*loop, one.get(), [&] { ++reads; }, [&] { ++writes; });
    os::Descriptor(ends[1]).reset();
    loop->run_until([] { return false; }, 2ms);
    EXPECT_EQ(reads + writes, 0) << "none was requested";
    watch.want_write();
    EXPECT_TRUE(loop->run_until([&] { return writes == 1; }, kDeadline));
    watch.want_read();
    EXPECT_TRUE(loop->run_until([&] { return reads == 1; }, kDeadline));
    EXPECT_EQ(writes, 1);
}

TEST(Watch, NotifiesOfAHangUpButNotOfAHalfCloseOrOfData) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    const os::Descriptor one(ends[0]);
    os::Descriptor peer(ends[1]);
    int calls = 0;
    Watch watch(*loop, one.get(), [&] { ++calls; });
    watch.want_hang_up();
    ASSERT_EQ(::write(peer.get(), "x", 1), 1);
    ASSERT_EQ(::shutdown(peer.get(), SHUT_WR), 0);
    loop->run_until([] { return false; }, 5ms);
    EXPECT_EQ(calls, 0);
    peer.reset();
    EXPECT_TRUE(loop->run_until([&] { return calls == 1; }, kDeadline));
    loop->run_until([] { return false; }, 2ms);
    EXPECT_EQ(calls, 1) << "once per request";
}

TEST(Watch, LeavesAStandardInputBlocking) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const os::Descriptor input(ends[0]);
    const os::Descriptor other(ends[1]);
    std::string got;
    Watch* self = nullptr;
    Watch watch(*loop, input.get(), [&] {
        char byte = 0;
        if (::read(input.get(), &byte, 1) == 1) got += byte;
        self->want_read();
    });
    self = &watch;
    watch.want_read();
    ASSERT_EQ(::write(other.get(), "quit", 4), 4);
    EXPECT_TRUE(loop->run_until([&] { return got == "quit"; }, kDeadline));
    EXPECT_EQ(::fcntl(input.get(), F_GETFL) & O_NONBLOCK, 0);
}

TEST(Watch, ReadsARegularFile) {
    const auto loop = make_loop();
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::tmpfile(), &std::fclose);
    ASSERT_NE(file, nullptr);
    int calls = 0;
    Watch watch(*loop, ::fileno(file.get()), [&] { ++calls; });
    watch.want_read();
    EXPECT_TRUE(loop->run_until([&] { return calls == 1; }, kDeadline));
}

TEST(Clock, GoesWithTheWallClock) {
    const auto difference = std::chrono::system_clock::now() - wall_clock(now() - 1h);
    EXPECT_GT(difference, 59min);
    EXPECT_LT(difference, 61min);
}

}  // namespace loop_test
}  // namespace takt::line
