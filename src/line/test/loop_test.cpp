#include "takt/line/loop.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <thread>

#include "support.hpp"

namespace takt::line {
namespace {

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

TEST(Loop, TellsSignals) {
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

TEST(Watch, TellsWhatCanBeReadOncePerRequest) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends), 0);
    const Fd one(ends[0]);
    const Fd other(ends[1]);
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
    const Fd one(ends[0]);
    const Fd other(ends[1]);
    std::unique_ptr<Watch> watch;
    watch = std::make_unique<Watch>(*loop, one.get(), [] {}, [&] { watch.reset(); });
    watch->want_read();
    watch->want_write();
    EXPECT_TRUE(loop->run_until([&] { return !watch; }, kDeadline));
}

TEST(Watch, LeavesAStandardInputBlocking) {
    const auto loop = make_loop();
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const Fd input(ends[0]);
    const Fd other(ends[1]);
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

}  // namespace
}  // namespace takt::line
