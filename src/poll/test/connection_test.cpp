// A TCP connection that takes everything and answers nothing is made anew.
#include <gtest/gtest.h>

#include "bench.hpp"

namespace takt::poll {
namespace connection_test {

using namespace test;

/// A line of that transport with one device; nothing answers at its other end.
class Silence {
public:
    explicit Silence(model::Transport transport)
        : project_(described(transport)), plan_(plan::make_plan(project_)), master_(project_, plan_) {}

    /// Brings the link up and waits until it is to be made anew. @returns how long that took, at most `limit`
    Duration lasts(Duration limit) {
        auto& line = master_.line(0);
        line.on_link(now_, true);
        const Instant start = now_;
        while (now_ < start + limit && !line.must_reconnect()) {
            line.on_tick(now_);
            while (!line.transmit(now_).empty()) {}
            if (line.must_reconnect()) break;
            now_ = std::min(start + limit, std::max(line.next_wakeup(), now_));
        }
        line.on_tick(now_);
        const Duration lasted = now_ - start;
        if (!says_.empty()) line.on_bytes(now_, says_);
        line.on_link(now_, false);
        return lasted;
    }
    void says(std::vector<std::uint8_t> bytes) { says_ = std::move(bytes); }

private:
    static model::Project described(model::Transport transport) {
        auto project = test::project({device(1, {int16("a", 0).read(3)})});
        project.lines[0].transport = transport;
        if (transport == model::Transport::tcp) project.lines[0].framing = wire::Framing::tcp;
        return project;
    }

    model::Project project_;
    plan::Plan plan_;
    Master master_;
    Instant now_ = at(1s);
    std::vector<std::uint8_t> says_;
};

TEST(ConnectionSilence, IsGivenUpAndTheAllowedTimeGrows) {
    Silence silence(model::Transport::tcp);
    for (const auto& [least, most] : {std::pair{30s, 60s}, {60s, 130s}, {120s, 240s}, {240s, 360s}}) {
        const Duration lasted = silence.lasts(1h);
        EXPECT_GE(lasted, least);
        EXPECT_LE(lasted, most);
    }
    for (int i = 0; i < 10; ++i) EXPECT_LE(silence.lasts(1h), 11min);
}

TEST(ConnectionSilence, BeginsAnewWhenSomethingWasHeard) {
    Silence silence(model::Transport::tcp);
    silence.lasts(1h);
    silence.says({0, 9, 0, 0, 0, 3, 1, 0x83, 2});
    silence.lasts(1h);
    EXPECT_LE(silence.lasts(1h), 60s);
}

TEST(ConnectionSilence, IsNothingUnusualOnASerialLine) {
    EXPECT_EQ(Silence(model::Transport::serial).lasts(1h), 1h);
}

// The rest of the first response never comes. Until the driver has closed the connection nothing is sent: it
// would be lost, and the second device charged.
TEST(ConnectionSilence, NothingIsSentOnAConnectionThatIsToBeMadeAnew) {
    auto project = test::project({device(1, {int16("a", 0).read(3)}), device(2, {int16("b", 0).read(3)})});
    project.lines[0].transport = model::Transport::tcp;
    project.lines[0].framing = wire::Framing::tcp;
    const auto plan = plan::make_plan(project);
    Master master(project, plan);
    auto& line = master.line(0);
    Instant now = at(1s);
    line.on_link(now, true);
    ASSERT_FALSE(line.transmit(now).empty());
    ASSERT_TRUE(line.transmit(now).empty());
    const std::uint8_t begun[] = {0, 0, 0, 0, 0, 5};
    line.on_bytes(now += 1ms, begun);
    while (!line.must_reconnect() && now < at(60s)) {
        now = line.next_wakeup();
        line.on_tick(now);
    }
    EXPECT_TRUE(line.must_reconnect());
    EXPECT_TRUE(line.transmit(now).empty());
}

}  // namespace connection_test
}  // namespace takt::poll
