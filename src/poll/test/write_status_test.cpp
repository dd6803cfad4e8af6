// The status variables of writes.
#include <gtest/gtest.h>

#include <functional>
#include <string_view>

#include "writing.hpp"

namespace takt::poll {
namespace write_status_test {

using namespace test;

/// How a write is caused, and what it needs of its variable.
struct Cause {
    const char* name;
    Item item;
    std::function<void(Bench&, std::int64_t)> write;
};

std::vector<Cause> every_cause(const Item& item) {
    const auto by_trigger = [](Bench& bench, std::int64_t value) {
        ASSERT_TRUE(bench.set("go", false));
        ASSERT_TRUE(bench.set("v", value));
        ASSERT_TRUE(bench.set("go", true));
    };
    return {
        {"change", item.on_change(),
         [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.set("v", value)); }},
        {"trigger", item.write_on(1), by_trigger},
        {"command", item, [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.write(1, "v", value)); }},
        {"command of a group", item.on_change(),
         [](Bench& bench, std::int64_t value) { ASSERT_TRUE(bench.write(1, "v", value)); }}};
}

TEST(WriteStatus, EveryFailedWriteOfAnyCauseSetsTheStatus) {
    const auto item = int16("v", 0).write(0x06).reports_to(0);
    for (const auto& read : {item, item.read(3).every(1h)})
        for (const auto& cause : every_cause(read)) {
            SCOPED_TRACE(std::string(cause.name) + (read.model::Variable::read ? ", read" : ", not read"));
            auto described = device(1, {cause.item});
            described.poll_enable = 2;
            auto on = local("on");
            on.default_value = model::Constant{.number = 1, .integer = 1};
            Bench bench(project({described}, {local("state", DataType::int16), local("go"), on}));
            bench.run_until(50ms);
            bench.players[1].exception = 3;
            cause.write(bench, 5);
            bench.run_until(100ms);
            EXPECT_EQ(bench.status("state"), 3);
            bench.players[1].exception.reset();
            cause.write(bench, 6);
            bench.run_until(150ms);
            EXPECT_EQ(bench.status("state"), 0) << "after the next success";
            bench.players[1].dead = true;
            cause.write(bench, 7);
            bench.run_until(2s);
            EXPECT_EQ(bench.status("state"), 100);
            bench.link(false);
            EXPECT_EQ(bench.status("state"), 103);
            bench.players[1].dead = false;
            bench.link(true);
            cause.write(bench, 8);
            bench.run_until(3s);
            EXPECT_EQ(bench.status("state"), 0);
            ASSERT_TRUE(bench.set("on", false));
            EXPECT_EQ(bench.status("state"), 104);
        }
}

// A write that is refused at once sets the status too, also before the device was ever switched on.
TEST(WriteStatus, AWriteToADeviceThatIsSwitchedOffSetsTheStatus) {
    for (const auto& cause : every_cause(int16("v", 0).write(0x06).reports_to(0))) {
        if (std::string_view(cause.name) == "change") continue;  // it waits for the device
        SCOPED_TRACE(cause.name);
        auto described = device(1, {cause.item});
        described.poll_enable = 2;
        Bench bench(project({described}, {local("state", DataType::int16), local("go"), local("on")}));
        bench.run_until(50ms);
        EXPECT_EQ(bench.status("state"), 0);
        cause.write(bench, 5);
        bench.run_until(100ms);
        EXPECT_EQ(bench.status("state"), 104);
    }
}

TEST(WriteStatus, BitsThatAreNotSentKeepTheirStatus) {
    auto described = device(1, {boolean("a", 1, 0).read(3).write(0x06).on_change().reports_to(0).every(1h),
                                boolean("b", 1, 1).read(3).write(0x06).on_change().reports_to(1).every(1h)});
    described.fc22 = true;
    described.strategy = model::Strategy::optimal;
    Bench bench(project({described}, {local("sa", DataType::int16), local("sb", DataType::int16)}));
    bench.run_until(50ms);
    bench.players[1].exception = 3;
    ASSERT_TRUE(bench.set("b", true));
    bench.run_until(100ms);
    EXPECT_EQ(bench.status("sa"), 0);
    EXPECT_EQ(bench.status("sb"), 3);
}

}  // namespace write_status_test
}  // namespace takt::poll
