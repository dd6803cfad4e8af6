// The lines of failed exchanges, as codes with their arguments, in time that the test moves.
#include "../failure_log.hpp"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>
#include <vector>

#include "projects.hpp"
#include "rig.hpp"

namespace takt::host::test {
namespace {

struct Lines {
    std::vector<std::string> all;

    Log log() { return {"host", {nullptr, this, write}}; }
    static void write(void* context, LogLevel, std::string_view, std::string_view code,
                      std::span<const LogArgument> arguments) {
        std::string line(code);
        for (const auto& argument : arguments) {
            line.append(" ").append(argument.name).append("=").append(argument.text);
            if (argument.error != nullptr) line.append(argument.error->subject.view());
        }
        static_cast<Lines*>(context)->all.push_back(line);
    }
    [[nodiscard]] std::size_t with(std::string_view part) const {
        return static_cast<std::size_t>(std::ranges::count_if(
            all, [&](const std::string& line) { return line.find(part) != std::string::npos; }));
    }
};

const std::string kPlant = project_with(line_of("main", pump()));

TEST(FailureLog, NamesLineDeviceRequestReasonTimeAndAttempt) {
    Lines lines;
    Rig rig(kPlant, {.log = lines.log()});
    rig.run(300ms);
    EXPECT_EQ(lines.with("exchange_failed"), 0U);
    rig.devices(0).find(UnitId{2})->behaviour.dead = true;
    rig.run(3s);
    ASSERT_GE(lines.with("log.exchange_failed"), 3U);
    EXPECT_EQ(lines.with("attempt=1 attempts=3"), 1U);
    EXPECT_EQ(lines.with("attempt=2 attempts=3"), 1U);
    EXPECT_EQ(lines.with("line=main"), lines.all.size());
    EXPECT_GE(lines.with("request=log.request.3 why=log.why.timeout device="), 3U);
    EXPECT_EQ(lines.with("state=app.state.not_answering"), 1U);
}

TEST(FailureLog, RepeatedFailuresAreSummarised) {
    const auto project = project_of(kPlant);
    Lines lines;
    FailureLog log(lines.log(), project);
    poll::FailedExchange failed{.device = 0, .unit = UnitId{3}, .took = 100ms};
    Instant now{};
    for (int i = 0; i < 241; ++i, now += 250ms) {
        failed.took += 1us;
        log.on_failed(now, 0, failed);
        log.on_tick(now);
    }
    ASSERT_EQ(lines.all.size(), 2U);
    EXPECT_EQ(lines.with("log.exchange_failed line=main count=0"), 1U);
    EXPECT_EQ(lines.with("log.exchange_repeated line=main count=240 seconds=60"), 1U);
    failed.status = bus::Status::exception;
    failed.exception = 2;
    failed.device.reset();
    log.on_failed(now, 0, failed);
    EXPECT_EQ(lines.with("log.relayed_failed"), 1U) << "another reason is another message";
    EXPECT_EQ(lines.with("name=exception.2"), 1U);
}

TEST(FailureLog, LinksToo) {
    const auto project = project_of(kPlant);
    Lines lines;
    FailureLog log(lines.log(), project);
    Instant now{};
    for (int i = 0; i < 5; ++i, now += 1s)
        log.on_link_down(now, 0, fail(Code::cannot_open, "plc:502", ECONNREFUSED).error());
    log.finish(now);
    EXPECT_EQ(lines.all,
              (std::vector<std::string>{"log.link_down line=main count=0 seconds=0 error=plc:502",
                                        "log.link_repeated line=main count=4 seconds=5 error=plc:502"}));
}

TEST(FailureLog, WithoutASinkNothingIsKept) {
    const auto project = project_of(kPlant);
    FailureLog log(Log(), project);
    log.on_failed(Instant{}, 0, {});
    log.finish(Instant{});
}

}  // namespace
}  // namespace takt::host::test
