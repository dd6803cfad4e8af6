// Commands as lines: divided, executed, answered; from a stream, from clients of a socket, to a slave's
// faults.
#include "takt/console/command_reader.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

#include "folder.hpp"
#include "loop_turn.hpp"
#include "support.hpp"
#include "takt/console/control_server.hpp"
#include "takt/console/fault_commands.hpp"
#include "takt/console/input_commands.hpp"

namespace takt::console {
namespace command_reader_test {

using namespace test;

/// Answers each line with itself; "bad" is no command.
Result<void> echo(const std::string& line, const Reply& reply, const Texts&) {
    if (line == "bad") return fail(Code::syntax, line);
    reply({"ok " + line + "\n", file::Json::object()});
    return {};
}

TEST(CommandReader, AnswersEveryCommandAndIgnoresEmptyLines) {
    Answers answers;
    CommandReader reader(echo, english());
    EXPECT_EQ(reader.feed("one\n\n  \t\r\ntw", answers.reply()), 1U);
    EXPECT_EQ(reader.feed("o\nbad\n", answers.reply()), 2U);
    ASSERT_EQ(answers.lines.size(), 3U);
    EXPECT_EQ(answers.lines[0], "ok one\n");
    EXPECT_EQ(answers.lines[1], "ok two\n");
    EXPECT_TRUE(answers.lines[2].starts_with("error syntax "));
    EXPECT_NE(answers.json[2].find("\"error\""), std::string::npos);
}

TEST(CommandReader, AnswersWithJsonIfAskedTo) {
    Answers answers;
    CommandReader reader(
        [](const std::string& line, const Reply& reply, const Texts&) -> Result<void> {
            if (line == "bad") return fail(Code::syntax, line);
            reply({"ok " + line + "\n", "as an event", line == "get x" ? "as data" : file::Json()});
            return {};
        },
        english());
    reader.feed("--json get x\n --json  set y 1 \n--jsonx\n--json\n--json bad\n", answers.reply());
    ASSERT_EQ(answers.lines.size(), 5U);
    EXPECT_EQ(answers.lines[0], "\"as data\"\n");
    EXPECT_EQ(answers.lines[1], "\"as an event\"\n");
    EXPECT_EQ(answers.lines[2], "ok --jsonx\n");
    EXPECT_EQ(answers.lines[3], "ok --json\n");
    EXPECT_TRUE(answers.lines[4].starts_with(R"({"event":"error","code":"syntax")")) << answers.lines[4];
}

TEST(CommandReader, AnswersInTheLanguageThatIsAskedFor) {
    Answers answers;
    CommandReader reader(
        [](const std::string& line, const Reply& reply, const Texts& texts) -> Result<void> {
            if (line == "bad") return fail(Code::not_found, line);
            reply({"ok " + line + ' ' + texts("app.state.answering") + '\n', file::Json::object()});
            return {};
        },
        english());
    reader.feed("--lang ru one\n--lang uk bad\n--lang ru --json two\n--lang xx two\ntwo\n", answers.reply());
    ASSERT_EQ(answers.lines.size(), 5U);
    EXPECT_EQ(answers.lines[0], "ok one отвечает\n");
    EXPECT_EQ(answers.lines[1], "error not_found bad: не знайдено\n");
    EXPECT_EQ(answers.lines[2], "{}\n");
    EXPECT_EQ(answers.lines[3], "ok two answering\n");
    EXPECT_EQ(answers.lines[4], "ok two answering\n");
}

TEST(CommandReader, AnswersALineThatIsTooLongOnce) {
    Answers answers;
    CommandReader reader(echo, english());
    EXPECT_EQ(reader.feed(std::string(3 * LineSplitter::kMaxLine, 'x') + "\nnext\n", answers.reply()), 2U);
    ASSERT_EQ(answers.lines.size(), 2U);
    EXPECT_TRUE(answers.lines[0].starts_with("error too_long ")) << answers.lines[0];
    EXPECT_EQ(answers.lines[1], "ok next\n");
}

TEST(CommandReader, ExecutesALastLineWithoutALineEnd) {
    Answers answers;
    CommandReader reader(echo, english());
    EXPECT_EQ(reader.feed("one\ntwo", answers.reply()), 1U);
    EXPECT_EQ(reader.end(answers.reply()), 1U);
    EXPECT_EQ(reader.end(answers.reply()), 0U);
    EXPECT_EQ(answers.lines, (std::vector<std::string>{"ok one\n", "ok two\n"}));
}

TEST(InputCommands, ExecutesTheLinesOfAStreamUntilItsEnd) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const auto loop = *line::Loop::create();
    Answers answers;
    {
        const InputCommands input(*loop, ends[0], echo, english(), answers.reply());
        ASSERT_EQ(::write(ends[1], "one\ntwo\n", 8), 8);
        ::close(ends[1]);
        loop->run_until([&] { return answers.lines.size() == 2; }, 5s);
    }
    EXPECT_EQ(answers.lines, (std::vector<std::string>{"ok one\n", "ok two\n"}));
    ::close(ends[0]);
}

class ControlServerTest : public testing::Test {
protected:
    ControlServerTest() : loop(*line::Loop::create()) {}
    ~ControlServerTest() override {
        for (const int client : clients) ::close(client);
    }

    Result<std::unique_ptr<ControlServer>> listen(Execute execute = echo) {
        return ControlServer::listen(*loop, path, std::move(execute), english());
    }

    int connect() {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0);
        EXPECT_EQ(::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
        clients.push_back(fd);
        return fd;
    }

    /// Runs the loop until the client has a line, or its end.
    std::string line_of(int fd) {
        std::string text;
        loop->run_until(
            [&] {
                char byte = 0;
                while (!text.ends_with('\n')) {
                    const auto count = ::read(fd, &byte, 1);
                    if (count == 0) return true;
                    if (count < 0) return false;
                    text += byte;
                }
                return true;
            },
            5s);
        return text;
    }

    std::string ask(int fd, const std::string& line) {
        EXPECT_EQ(::write(fd, line.data(), line.size()), static_cast<ssize_t>(line.size()));
        return line_of(fd);
    }

    std::unique_ptr<line::Loop> loop;
    takt::test::Folder folder;
    std::string path = folder / "control";
    std::vector<int> clients;
};

TEST_F(ControlServerTest, AnswersEachClientItsOwnCommands) {
    const auto server = listen();
    ASSERT_TRUE(server);
    const int first = connect();
    const int second = connect();
    EXPECT_EQ(ask(second, "two\n"), "ok two\n");
    EXPECT_EQ(ask(first, "one\n"), "ok one\n");
}

TEST_F(ControlServerTest, AClientThatHangsUpFreesItsSlotBeforeItsCommandsEnd) {
    constexpr std::string_view kMany = "wait\n";
    for (const bool half_closes_first : {false, true})
        for (const std::size_t commands : {1U, 100U}) {  // a client with 64 commands is not read
            SCOPED_TRACE(testing::Message() << half_closes_first << ' ' << commands);
            std::vector<Reply> waiting;
            const auto server =
                listen([&waiting](const std::string& line, const Reply& reply, const Texts&) -> Result<void> {
                    if (line == "wait")
                        waiting.push_back(reply);
                    else
                        reply({"ok " + line + "\n", file::Json::object()});
                    return {};
                });
            ASSERT_TRUE(server);
            const std::size_t accepted = ControlServer::kMaxClients * std::min<std::size_t>(commands, 64);
            for (std::size_t i = 0; i < ControlServer::kMaxClients; ++i) {
                const int client = connect();
                for (std::size_t n = 0; n < commands; ++n)
                    ASSERT_EQ(::write(client, kMany.data(), kMany.size()),
                              static_cast<ssize_t>(kMany.size()));
                if (half_closes_first) ::shutdown(client, SHUT_WR);
            }
            ASSERT_TRUE(loop->run_until([&] { return waiting.size() >= accepted; }, 5s));
            EXPECT_TRUE(ask(connect(), "now\n").starts_with("error busy"));
            for (const int client : std::exchange(clients, {})) ::close(client);
            EXPECT_EQ(ask(connect(), "now\n"), "ok now\n");
            for (const auto& reply : waiting) reply({"ok late\n", file::Json::object()});
        }
}

TEST_F(ControlServerTest, ReplacesTheClientThatIsIdleForTheLongestTime) {
    const auto server = listen();
    ASSERT_TRUE(server);
    std::vector<int> all;
    for (std::size_t i = 0; i < ControlServer::kMaxClients; ++i) {
        all.push_back(connect());
        ASSERT_EQ(ask(all.back(), "hello\n"), "ok hello\n");
    }
    ASSERT_EQ(ask(all[0], "again\n"), "ok again\n");
    EXPECT_EQ(ask(connect(), "new\n"), "ok new\n");
    EXPECT_TRUE(line_of(all[1]).starts_with("error idle "));
    EXPECT_EQ(ask(all[0], "still\n"), "ok still\n");
}

TEST_F(ControlServerTest, RefusesAClientWhileAllOthersWaitForAnswers) {
    std::vector<Reply> waiting;
    const auto server = listen([&](const std::string&, const Reply& reply, const Texts&) {
        waiting.push_back(reply);
        return Result<void>();
    });
    ASSERT_TRUE(server);
    for (std::size_t i = 0; i < ControlServer::kMaxClients; ++i) {
        const int client = connect();
        ASSERT_EQ(::write(client, "wait\n", 5), 5);
        loop->run_until([&] { return waiting.size() == i + 1; }, 5s);
    }
    EXPECT_TRUE(line_of(connect()).starts_with("error busy "));
    waiting[3]({"done\n", {}});
    EXPECT_EQ(line_of(clients[3]), "done\n");
}

TEST_F(ControlServerTest, AnswersAHalfClosedClientAndThenClosesIt) {
    std::vector<Reply> waiting;
    const auto server = listen([&](const std::string&, const Reply& reply, const Texts&) {
        waiting.push_back(reply);
        return Result<void>();
    });
    ASSERT_TRUE(server);
    const int client = connect();
    ASSERT_EQ(::write(client, "one\ntwo", 7), 7);
    ::shutdown(client, SHUT_WR);
    loop->run_until([&] { return waiting.size() == 2; }, 5s);
    ASSERT_EQ(waiting.size(), 2U) << "the last line has no line end";
    for (const Reply& reply : waiting) reply({"done\n", {}});
    EXPECT_EQ(line_of(client), "done\n");
    EXPECT_EQ(line_of(client), "done\n");
    EXPECT_EQ(line_of(client), "") << "the end";
}

TEST_F(ControlServerTest, AClientThatAsksWithoutPauseTakesABoundedShare) {
    std::vector<Reply> waiting;
    const auto server = listen([&](const std::string& line, const Reply& reply, const Texts& texts) {
        if (line != "get x") return echo(line, reply, texts);
        waiting.push_back(reply);
        return Result<void>();
    });
    ASSERT_TRUE(server);
    constexpr std::size_t kCommands = 1000;
    std::string flood;
    for (std::size_t i = 0; i < kCommands; ++i) flood += "get x\n";
    const int greedy = connect();
    ASSERT_EQ(::write(greedy, flood.data(), flood.size()), static_cast<ssize_t>(flood.size()));
    EXPECT_EQ(ask(connect(), "other\n"), "ok other\n");
    EXPECT_EQ(waiting.size(), 64U);
    std::size_t answered = 0;
    while (loop->run_until([&] { return answered < waiting.size() || answered == kCommands; }, 5s) &&
           answered < kCommands) {
        EXPECT_LE(waiting.size() - answered, 64U);
        waiting[answered++]({"done\n", {}});
        EXPECT_EQ(line_of(greedy), "done\n");
    }
    EXPECT_EQ(answered, kCommands) << "each command gets its answer";
}

TEST_F(ControlServerTest, AClientThatReadsNothingIsCutOffAtOnce) {
    const std::string much(32 << 10, 'x');
    const auto server = listen([&](const std::string&, const Reply& reply, const Texts&) {
        reply({much + "\n", {}});
        return Result<void>();
    });
    ASSERT_TRUE(server);
    const int client = connect();
    bool ended = false;
    for (int i = 0; i < 64 && !ended; ++i) {
        ended = ::send(client, "x\n", 2, MSG_NOSIGNAL) < 0;
        takt::test::turn(*loop);
    }
    EXPECT_TRUE(ended);
}

TEST_F(ControlServerTest, AnAnswerAfterTheClientIsGoneIsDropped) {
    Reply late;
    const auto server = listen([&](const std::string&, const Reply& reply, const Texts&) {
        late = reply;
        return Result<void>();
    });
    ASSERT_TRUE(server);
    const int client = connect();
    ASSERT_EQ(::write(client, "wait\n", 5), 5);
    loop->run_until([&] { return late != nullptr; }, 5s);
    ::close(client);
    clients.clear();
    const int next = connect();
    takt::test::turn(*loop, 2);
    late({"done\n", {}});
    EXPECT_EQ(::write(next, "x\n", 2), 2);
}

TEST_F(ControlServerTest, ReplacesALeftOverSocketAndNothingElse) {
    {
        const auto server = listen();
        ASSERT_TRUE(server);
        const auto second = listen();
        ASSERT_FALSE(second);
        EXPECT_EQ(second.error().code, Code::busy);
    }
    EXPECT_FALSE(std::filesystem::exists(path));
    const int left_over = ::socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(left_over, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(left_over);
    EXPECT_TRUE(listen());
    std::ofstream(path) << "mine";
    const auto beside = listen();
    ASSERT_FALSE(beside);
    EXPECT_EQ(beside.error().code, Code::cannot_open);
    EXPECT_TRUE(std::filesystem::is_regular_file(path));
}

TEST(FaultCommands, SwitchFaultsAndListThoseInForce) {
    const auto faults = std::make_shared<sim::AnswerFaults>();
    bool quit = false;
    const auto execute = fault_commands(
        faults, std::make_shared<ServedDevices>(), [] { return Instant{1s}; }, [&] { quit = true; });
    Answers answers;
    EXPECT_TRUE(execute("fault add silence", answers.reply(), english()));
    EXPECT_TRUE(execute("fault add exception=4:10%", answers.reply(), english()));
    EXPECT_TRUE(execute("fault list", answers.reply(), english()));
    EXPECT_TRUE(execute("fault clear", answers.reply(), english()));
    ASSERT_EQ(answers.lines.size(), 4U);
    EXPECT_EQ(answers.lines[0], "ok silence\n");
    EXPECT_EQ(answers.lines[1], answers.lines[2]);
    EXPECT_NE(answers.lines[2].find("exception=4"), std::string::npos);
    EXPECT_EQ(answers.lines[3], "ok\n");
    for (const auto* const line :
         {"fault", "fault add", "fault add nonsense", "fault list all", "quit now"}) {
        const auto done = execute(line, answers.reply(), english());
        ASSERT_FALSE(done) << line;
        EXPECT_EQ(done.error().code, Code::syntax) << line;
    }
    EXPECT_EQ(answers.lines.size(), 4U);
    EXPECT_FALSE(quit);
    EXPECT_TRUE(execute("quit", answers.reply(), english()));
    EXPECT_TRUE(quit);
}

}  // namespace command_reader_test
}  // namespace takt::console
