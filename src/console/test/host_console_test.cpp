// A console over a host's engine in virtual time.
#include "takt/console/host_console.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>

#include "loop_turn.hpp"
#include "sessions/snapshot_request.hpp"
#include "support.hpp"

namespace takt::console {
namespace host_console_test {

using namespace test;

/// Fails while the disk is full.
class FullDisk final : public os::Sink {
public:
    FullDisk(std::unique_ptr<os::Sink> below, const std::atomic<bool>& full)
        : below_(std::move(below)), full_(full) {}
    Written write(std::string_view text) override {
        return full_ ? Written{.bytes = 0, .error = ENOSPC, .closed = false} : below_->write(text);
    }

private:
    std::unique_ptr<os::Sink> below_;
    const std::atomic<bool>& full_;
};

class HostConsoleTest : public testing::Test {
protected:
    HostConsoleTest() : loop(*line::Loop::create()) { EXPECT_EQ(::pipe(pipe), 0); }
    ~HostConsoleTest() override {
        console.reset();
        ::close(pipe[0]);
        ::close(pipe[1]);
    }

    Result<void> begin(HostConsole::Options options, TrafficLog* traffic = nullptr) {
        out.emplace(std::make_unique<FullDisk>(memory.sink(), full), output_options(options.json));
        console.emplace(english(),
                        HostConsole::Environment{.loop = *loop,
                                                 .out = *out,
                                                 .messages = {[this](const auto& text) { status += text; },
                                                              [this](const auto& text) { errors += text; }},
                                                 .traffic = traffic,
                                                 .open_session = [this](const host::SessionOptions& wanted)
                                                     -> Result<std::unique_ptr<host::Session>> {
                                                     if (++sessions > most_sessions)
                                                         return fail(Code::queue_full, most_sessions);
                                                     return rig.open(wanted);
                                                 },
                                                 .started = rig.now},
                        std::move(options));
        return console->begin();
    }

    void type(std::string_view text) {
        ASSERT_EQ(::write(pipe[1], text.data(), text.size()), static_cast<ssize_t>(text.size()));
        takt::test::turn(*loop, 2);
    }

    /// The host works for a while, the console reads.
    void run(Duration length) {
        rig.run(length);
        takt::test::turn(*loop, 2);
    }

    /// The output until the end.
    std::string end(const endpoint::Statistics& served = {}) {
        const auto last = rig.snapshot({.values = true, .statistics = true});
        rig.link->set_last_state([last](const host::SnapshotParts&) { return last->snapshot; });
        rig.link->stopped = true;
        rig.link->ended = true;
        console->end(served);
        out->finish();
        return memory.text();
    }

    host::test::Rig rig{kPlant};
    std::unique_ptr<line::Loop> loop;
    int pipe[2] = {-1, -1};
    int sessions = 0;
    int most_sessions = 8;
    std::atomic<bool> full = false;
    std::string status;
    std::string errors;
    Memory memory;
    std::optional<os::LineWriter> out;
    std::optional<HostConsole> console;
};

TEST_F(HostConsoleTest, WritesEventsAsLinesAndTheSummaryAtTheEnd) {
    ASSERT_TRUE(begin({}));
    run(300ms);
    const auto text = end();
    EXPECT_NE(text.find("Boiler Level = "), std::string::npos) << text;
    EXPECT_EQ(text.find('{'), std::string::npos);
    EXPECT_TRUE(text.ends_with('\n'));
}

TEST_F(HostConsoleTest, QuietLeavesOutValuesAndRepetitions) {
    ASSERT_TRUE(begin({.quiet = true}));
    run(300ms);
    const Error refused = fail(Code::cannot_open, "plc:502", ECONNREFUSED).error();
    for (const std::uint64_t repeated : {0U, 3U, 6U})
        rig.engine->publish_event(rig.now,
                                  host::LinkChanged{.line = 0, .why = refused, .repeated = repeated});
    rig.engine->publish_event(rig.now, host::LinkChanged{.line = 0, .up = true});
    rig.engine->publish_event(rig.now, host::LinkChanged{.line = 0, .up = false});
    run(50ms);
    const auto text = end();
    EXPECT_EQ(text.find("Level = "), std::string::npos) << text;
    EXPECT_NE(text.find("Boiler: answering"), std::string::npos) << text;
    const auto count = [&](const std::string& part) {
        std::size_t found = 0;
        for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
        return found;
    };
    EXPECT_EQ(count("connection refused"), 1U) << text;
    EXPECT_EQ(count("main: no link"), 2U) << text;
    EXPECT_EQ(count("main: connected"), 2U) << text;
}

TEST_F(HostConsoleTest, ShowsOneDeviceIfAskedTo) {
    ASSERT_TRUE(begin({.json = true, .device = "Nobody"}));
    run(300ms);
    const auto text = end();
    EXPECT_EQ(text.find(R"("event":"value")"), std::string::npos) << text;
    EXPECT_EQ(text.find(R"("event":"device")"), std::string::npos) << text;
    EXPECT_NE(text.find(R"("event":"link")"), std::string::npos) << text;
}

TEST_F(HostConsoleTest, WritesJsonIfAskedTo) {
    ASSERT_TRUE(begin({.json = true}));
    run(300ms);
    const auto text = end();
    std::istringstream lines(text);
    std::string line;
    std::size_t count = 0;
    for (; std::getline(lines, line); ++count) EXPECT_TRUE(line.starts_with(R"({"event":)")) << line;
    EXPECT_GT(count, 2U);
    EXPECT_NE(text.find(R"({"event":"summary")"), std::string::npos);
}

TEST_F(HostConsoleTest, GoesOnWhenTheDiskIsFullAndCountsTheLostLines) {
    full = true;
    ASSERT_TRUE(begin({.json = true}));
    run(300ms);
    loop->run_until([this] { return !errors.empty(); }, 5s);
    EXPECT_NE(errors.find("stdout"), std::string::npos) << errors;
    EXPECT_FALSE(loop->stopped());
    full = false;
    run(300ms);
    const auto text = end();
    EXPECT_NE(text.find(R"({"event":"gap","missed":)"), std::string::npos) << text;
    EXPECT_NE(text.find(R"({"event":"summary")"), std::string::npos);
}

TEST_F(HostConsoleTest, AnswersCommandsOfItsInputAmongTheEvents) {
    ASSERT_TRUE(begin({.commands = pipe[0]}));
    type("write Level 42\nget Level\nnonsense\n");
    run(500ms);
    const auto text = end();
    EXPECT_NE(text.find("done Level\n"), std::string::npos) << text;
    EXPECT_NE(text.find("ok Level "), std::string::npos);
    EXPECT_NE(text.find("error syntax "), std::string::npos);
    EXPECT_NE(text.find("Boiler Level = 42"), std::string::npos);
}

TEST_F(HostConsoleTest, QuitStopsTheLoop) {
    ASSERT_TRUE(begin({.commands = pipe[0]}));
    EXPECT_FALSE(loop->stopped());
    type("quit\n");
    EXPECT_TRUE(loop->stopped());
}

TEST_F(HostConsoleTest, NoticesAreMessagesAndNoData) {
    ASSERT_TRUE(begin({}));
    rig.engine->publish_event(
        rig.now,
        endpoint::Notice{endpoint::Notice::Severity::status, "endpoint.serving", {{"where", "here"}}, {}});
    run(50ms);
    EXPECT_NE(status.find("here"), std::string::npos);
    EXPECT_EQ(errors, "");
    EXPECT_EQ(end().find("here"), std::string::npos);
}

TEST_F(HostConsoleTest, LogsTheFramesOfTheHost) {
    Memory frames;
    auto log = std::make_unique<TrafficLog>(frames.sink());
    ASSERT_TRUE(begin({}, log.get()));
    run(300ms);
    (void)end();
    console.reset();
    log.reset();  // writes what is left
    EXPECT_NE(frames.text().find("main::Boiler:"), std::string::npos) << frames.text();
}

TEST_F(HostConsoleTest, FailsIfASessionOrTheSocketCannotBeOpened) {
    most_sessions = 0;
    EXPECT_EQ(begin({}).error().code, Code::queue_full);
    most_sessions = 8;
    EXPECT_EQ(begin({.control_path = "/dev/null/control"}).error().code, Code::cannot_open);
}

}  // namespace host_console_test
}  // namespace takt::console
