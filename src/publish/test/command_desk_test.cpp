// Commands of messages, with a host that the test plays.
#include "takt/publish/command_desk.hpp"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <map>
#include <random>
#include <set>
#include <vector>

#include "projects.hpp"
#include "rig.hpp"
#include "takt/file/json.hpp"

namespace takt::publish {
namespace command_desk_test {

using namespace std::chrono_literals;
using file::Json;
using host::Command;

constexpr std::int64_t kWall = 1'795'487'400'000'000'000;  // 2026-11-24T02:30:00Z

const std::string kPlant = host::test::project_with(
    host::test::line_of(
        "main",
        host::test::boiler() + host::test::device_of("Pump", 2,
                                                     host::test::variable_of("Speed", 0) +
                                                         host::test::variable_of("Wish", 1, ", write: 0x06"),
                                                     ", poll_enable: run")),
    "  - {name: run, type: bool}\n  - {name: go, type: bool}\n  - {name: note, type: string}\n"
    "  - {name: limit, type: int}\n  - {name: hidden, type: bool}\n");

struct Desk {
    Desk() {
        CommandRights rights{.configuration = host::test::configuration_of(kPlant)};
        for (const auto* name : {"Setpoint", "Wish", "run", "go", "note", "limit"})
            rights.commandable.insert(*rights.configuration->find(name));
        rights.readable.insert(*rights.configuration->find("Level"));
        configuration = rights.configuration;
        desk.set_rights(std::move(rights));
    }

    bool give(const std::string& payload, const std::string& topic = "takt/cloud/command",
              MqttProperties properties = {}, bool retain = false, bool subscribed = true) {
        MqttInbound inbound{.connection = 1, .subscribed = subscribed};
        inbound.message = {
            .topic = topic, .payload = payload, .retain = retain, .properties = std::move(properties)};
        return desk.on_message(now, "mqtt://broker:1883", inbound);
    }
    std::optional<Command> next() { return desk.next_command(now); }
    void pass(Duration length) {
        now.t += length;
        now.wall_ns += length.count();
    }
    void done(const Command& command, value::CommandResult result = value::CommandResult::done,
              host::Outcome::Progress progress = host::Outcome::Progress::settled) {
        desk.on_outcome(now, {.tag = command.tag,
                              .kind = command.kind,
                              .slot = command.slot,
                              .t = now.t,
                              .result = result,
                              .progress = progress,
                              .value = command.value});
    }
    std::optional<MqttMessage> answer() {
        const auto* const first = desk.first_answer();
        if (first == nullptr) return std::nullopt;
        auto message = first->message;
        short_answer = first->short_payload;
        desk.remove_first_answer();
        return message;
    }
    std::string refusal() {
        const auto message = answer();
        if (!message) return "no answer";
        EXPECT_FALSE(next()) << "a refused command is executed: " << message->payload;
        return message->payload;
    }

    CommandTime now{Instant{100s}, kWall};
    std::string short_answer;  // of the last answer()
    std::vector<std::string> audit;
    bool disk_full = false;
    host::ConfigurationPtr configuration;
    CommandDesk desk{{.output = "cloud",
                      .control_topic = "takt/cloud",
                      .id_prefix = "t1-",
                      .audit = [this](std::string_view line) {
                          if (!disk_full) audit.emplace_back(line);
                          return !disk_full;
                      }}};
};

std::string request(const std::string& id, const std::string& rest) {
    return R"({"id":")" + id + R"(",)" + rest + "}";
}
const std::string kSet = R"("command":"set","variable":"Setpoint","value":5)";

TEST(CommandDesk, AnswersACommandThatTheHostHasDone) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", kSet), "takt/cloud/command",
                          {.response_topic = "reply/1", .correlation_data = std::string("\0x", 2)}));
    const auto command = desk.next();
    ASSERT_TRUE(command);
    EXPECT_EQ(command->kind, Command::Kind::write) << "written on change: must not wait beyond its expiry";
    EXPECT_EQ(command->expires, desk.now.t + 10s);
    EXPECT_EQ(command->value, value::Value(std::int64_t{5}));
    EXPECT_FALSE(desk.answer());
    desk.done(*command);
    const auto answer = desk.answer();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->topic, "reply/1");
    EXPECT_EQ(answer->properties.correlation_data, std::string("\0x", 2));
    EXPECT_EQ(answer->payload, R"({"id":"a","command":"set","variable":"Setpoint","outcome":"done",)"
                               R"("value":5,"time":"2026-11-24T02:30:00.000Z"})");
    EXPECT_EQ(desk.short_answer,
              R"({"id":"a","outcome":"done","shortened":true,"time":"2026-11-24T02:30:00.000Z"})");
    ASSERT_EQ(desk.audit.size(), 1U);
    EXPECT_EQ(desk.audit[0],
              R"({"time":"2026-11-24T02:30:00.000Z","event":"command","output":"cloud",)"
              R"("broker":"mqtt://broker:1883","topic":"takt/cloud/command","id":"a","command":"set",)"
              R"("variable":"Setpoint","value":5,"outcome":"done"})"
              "\n");
}

TEST(CommandDesk, CountsCommandsThatCannotBeRecorded) {
    Desk desk;
    const auto execute = [&](const char* id) {
        ASSERT_TRUE(desk.give(request(id, kSet)));
        desk.done(*desk.next());
    };
    desk.disk_full = true;
    execute("1");
    execute("2");
    EXPECT_TRUE(desk.audit.empty());
    EXPECT_EQ(desk.desk.counters().unrecorded, 2U);
    desk.disk_full = false;
    execute("3");
    execute("4");
    ASSERT_EQ(desk.audit.size(), 2U);
    EXPECT_TRUE(desk.audit[0].starts_with(
        R"({"time":"2026-11-24T02:30:00.000Z","event":"lines_missing","output":"cloud","count":2})"
        "\n{"))
        << desk.audit[0];
    EXPECT_EQ(desk.audit[1].find("lines_missing"), std::string::npos) << "reported once";
    EXPECT_EQ(desk.desk.counters().unrecorded, 2U);
}

TEST(CommandDesk, RefusesByReason) {
    const struct {
        std::string rest;
        std::string reason;
        std::string detail;
    } cases[] = {
        {R"("command":"set","variable":"Setpont","value":5)", "unknown_variable", "nearest: Setpoint"},
        {R"("command":"set","variable":"Level","value":5)", "not_listed", "variable: Level; allowed: "},
        {R"("command":"get","variable":"Speed")", "not_listed", "variable: Speed"},
        {R"("command":"trigger","variable":"hidden")", "not_listed", "variable: hidden"},
        {R"("command":"set","variable":"Setpoint","value":40000)", "malformed", "-32768..32767"},
        {R"("command":"set","variable":"Setpoint","value":1.5)", "malformed", "value: 1.5"},
        {R"("command":"set","variable":"Setpoint","value":"5")", "malformed", "a number"},
        {R"("command":"set","variable":"Setpoint","value":true)", "malformed", "value: true"},
        {R"("command":"set","variable":"note","value":5)", "malformed", "a string"},
        {R"("command":"trigger","variable":"Setpoint")", "malformed", "a local of type bool"},
        {R"("command":"trigger","variable":"limit")", "malformed", "a local of type bool"},
        {R"("command":"enable","device":"Boiler")", "no_poll_enable", "device: Boiler"},
        {R"("command":"enable","device":"Pimp")", "unknown_variable", "nearest: Pump"},
        {kSet + R"(,"sent":"2026-11-24T02:31:01Z")", "clock", "60 s"},
        {kSet + R"(,"sent":"2026-11-24T02:29:50Z")", "expired", ""},
        {kSet + R"(,"sent":"2026-11-24T02:29:55Z","expiry_s":5)", "expired", ""},
        {kSet + R"(,"expires":"2026-11-24T02:30:00Z")", "expired", ""},
        {kSet + R"(,"more":1)", "malformed", "unknown"},
    };
    for (const auto& [rest, reason, detail] : cases) {
        Desk desk;
        ASSERT_TRUE(desk.give(request("a", rest)));
        const auto answer = desk.refusal();
        EXPECT_NE(answer.find(R"("reason":")" + reason + '"'), std::string::npos) << rest << answer;
        EXPECT_NE(answer.find(detail), std::string::npos) << rest << answer;
        EXPECT_EQ(desk.audit.size(), 1U);
        EXPECT_EQ(desk.desk.counters().refused, 1U);
    }
}

TEST(CommandDesk, AnAnswerHasTheValueOfTheRequest) {
    const struct {
        std::string given;
        std::string answered;
    } cases[] = {{"1.5", "1.5"}, {"true", "true"}, {R"("5")", R"("5")"}, {"70000", "70000"}};
    for (const auto& [given, answered] : cases) {
        Desk desk;
        ASSERT_TRUE(desk.give(request("a", R"("command":"set","variable":"Setpoint","value":)" + given)));
        EXPECT_NE(desk.refusal().find(R"("value":)" + answered + ","), std::string::npos) << given;
    }
}

TEST(CommandDesk, ASetVariableWithoutWriteOnChangeIsNotWritten) {
    const struct {
        std::string subject;
        bool written;
    } cases[] = {{"Wish", false}, {"limit", true}, {"Setpoint", true}};
    for (const auto& [subject, written] : cases) {
        Desk desk;
        ASSERT_TRUE(desk.give(request("a", R"("command":"set","value":5,"variable":")" + subject + '"')));
        using Progress = host::Outcome::Progress;
        const auto command = *desk.next();
        desk.done(command, value::CommandResult::done, written ? Progress::settled : Progress::not_written);
        EXPECT_EQ(command.kind == Command::Kind::write, subject == "Setpoint");
        const auto answer = desk.answer()->payload;
        EXPECT_EQ(answer.find(R"("outcome":"done","reason":"not_written")") == std::string::npos, written)
            << answer;
    }
}

TEST(CommandDesk, RefusesRetainedCommandsAndThoseOfAnEarlierConnection) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", kSet), "takt/cloud/command", {}, true));
    EXPECT_NE(desk.refusal().find("\"retained\""), std::string::npos);
    ASSERT_TRUE(desk.give(request("a", kSet), "takt/cloud/command", {}, false, false));
    EXPECT_NE(desk.refusal().find("\"not_subscribed\""), std::string::npos);
    ASSERT_TRUE(desk.give("5", "takt/cloud/set/Setpoint", {}, true));
    EXPECT_NE(desk.refusal().find("\"retained\""), std::string::npos);
    EXPECT_FALSE(desk.give("5", "takt/cloud/answer"));
    EXPECT_FALSE(desk.give("5", "takt/cloudy/command"));
}

TEST(CommandDesk, TheEarliestExpiryHolds) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", kSet), "takt/cloud/command", {.expiry_s = 3}));
    EXPECT_EQ(desk.next()->expires, desk.now.t + 3s);
    ASSERT_TRUE(desk.give(request("b", kSet + R"(,"sent":"2026-11-24T02:29:58Z")")));
    EXPECT_EQ(desk.next()->expires, desk.now.t + 8s);
    ASSERT_TRUE(desk.give(request("c", kSet + R"(,"expires":"2999-11-24T02:29:58Z")")));
    EXPECT_NE(desk.refusal().find("malformed"), std::string::npos);
    ASSERT_TRUE(desk.give(request("d", kSet)));
    desk.pass(10s);
    EXPECT_FALSE(desk.next());
    EXPECT_NE(desk.answer()->payload.find("\"expired\""), std::string::npos);
}

TEST(CommandDesk, AKnownIdIsNeverExecutedAgain) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", kSet)));
    const auto command = desk.next();
    ASSERT_TRUE(command);
    ASSERT_TRUE(desk.give(request("a", kSet)));
    EXPECT_FALSE(desk.next());
    EXPECT_FALSE(desk.answer()) << "it still runs";
    desk.done(*command);
    const auto first = desk.answer();
    desk.pass(1min);
    ASSERT_TRUE(desk.give(request("a", kSet)));
    EXPECT_FALSE(desk.next());
    EXPECT_EQ(desk.answer(), first);
    ASSERT_TRUE(desk.give(request("a", R"("command":"set","variable":"Setpoint","value":6)")));
    EXPECT_NE(desk.refusal().find("\"duplicate_id\""), std::string::npos);
}

// The host ends what it has not sent when it stops.
TEST(CommandDesk, ACommandThatEndsBeforeItExpiresIsRefused) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", kSet)));
    desk.done(*desk.next(), value::CommandResult::expired);
    EXPECT_NE(desk.answer()->payload.find(R"("outcome":"refused","reason":"stopped")"), std::string::npos);
    ASSERT_TRUE(desk.give(request("b", kSet)));
    const auto command = desk.next();
    desk.pass(10s);
    desk.done(*command, value::CommandResult::expired);
    EXPECT_NE(desk.answer()->payload.find(R"("outcome":"expired","reason":"expired")"), std::string::npos);
}

TEST(CommandDesk, AnAnswerToGetHasTheTimeOfTheLastGoodRead) {
    Desk desk;
    ASSERT_TRUE(desk.give(request("a", R"("command":"get","variable":"Level")")));
    const auto command = desk.next();
    ASSERT_TRUE(command);
    desk.desk.on_outcome(desk.now, {.tag = command->tag,
                                    .kind = command->kind,
                                    .slot = command->slot,
                                    .t = desk.now.t,
                                    .quality = value::Quality::bad,
                                    .good_at = desk.now.t - 1500ms,
                                    .value = std::int64_t{7}});
    const auto answer = desk.answer();
    ASSERT_TRUE(answer);
    EXPECT_NE(answer->payload.find(R"("quality":"bad","last_good":"2026-11-24T02:29:58.500Z","time")"),
              std::string::npos)
        << answer->payload;
}

TEST(CommandDesk, MostCommandsAndAnswersAreLimited) {
    Desk desk;
    for (std::size_t i = 0; i < CommandDesk::kMostOpen; ++i) desk.give(request(fmt::format("{}", i), kSet));
    EXPECT_EQ(desk.desk.open(), CommandDesk::kMostOpen);
    desk.give(request("one more", kSet));
    EXPECT_NE(desk.answer()->payload.find("\"too_many\""), std::string::npos);
    while (desk.next()) {}
    desk.desk.stop(desk.now);
    EXPECT_EQ(desk.desk.open(), 0U);
    std::size_t answers = 0;
    for (; const auto answer = desk.answer(); ++answers)
        EXPECT_NE(answer->payload.find(R"("outcome":"unknown","reason":"stopped")"), std::string::npos);
    EXPECT_EQ(answers, CommandDesk::kMostOpen);
    EXPECT_FALSE(desk.give(request("late", kSet)));
}

TEST(CommandDesk, ABurstOfCommandsIsAnswered) {
    Desk desk;
    const std::size_t many = CommandDesk::kMostAnswers + 3;
    for (std::size_t i = 0; i < many; ++i)
        desk.give(request(fmt::format("{}", i), R"("command":"get","variable":"Nothing")"));
    EXPECT_EQ(desk.desk.counters().answers_dropped, 3U);
    EXPECT_NE(desk.answer()->payload.find(R"("id":"3")"), std::string::npos) << "the oldest are dropped";
    std::size_t answers = 1;
    while (desk.answer()) ++answers;
    EXPECT_EQ(answers, CommandDesk::kMostAnswers);
}

TEST(CommandDesk, TheBytesOfAnswersAreLimited) {
    Desk desk;
    MqttProperties reply{.response_topic = std::string(500, 'r'), .correlation_data = std::string(524, 'c')};
    for (int i = 0; i < 1000; ++i)
        desk.give(request(fmt::format("{}", i), kSet + R"(,"extra":0)"), "takt/cloud/command", reply);
    std::size_t bytes = 0;
    std::uint64_t answers = 0;
    for (; const auto answer = desk.answer(); ++answers) bytes += answer->payload.size() + 1024;
    EXPECT_GT(answers, 100U);
    EXPECT_LE(bytes, CommandDesk::kMostAnswerBytes);
    EXPECT_EQ(desk.desk.counters().answers_dropped, 1000 - answers);
    reply.correlation_data += '+';
    desk.give(request("long", kSet), "takt/cloud/command", reply);
    const auto refused = desk.answer();
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->topic, "takt/cloud/answer");
    EXPECT_NE(refused->payload.find("response topic and correlation data: 1025 bytes; allowed: 1024"),
              std::string::npos)
        << refused->payload;
}

TEST(CommandDesk, OtherCommandsBecomeCommandsOfTheHost) {
    Desk desk;
    const struct {
        std::string rest;
        Command::Kind kind;
        const char* slot;
        value::Value value;
    } cases[] = {{R"("command":"trigger","variable":"go")", Command::Kind::pull, "go", {}},
                 {R"("command":"enable","device":"Pump")", Command::Kind::set, "run", true},
                 {R"("command":"disable","device":"Pump")", Command::Kind::set, "run", false},
                 {R"("command":"get","variable":"Level")", Command::Kind::get, "Level", {}},
                 {R"("command":"set","variable":"note","value":"7")", Command::Kind::set, "note", "7"},
                 {R"("command":"set","variable":"go","value":false)", Command::Kind::set, "go", false}};
    int id = 0;
    for (const auto& [rest, kind, slot, value] : cases) {
        ASSERT_TRUE(desk.give(request(fmt::format("{}", ++id), rest)));
        const auto command = desk.next();
        ASSERT_TRUE(command) << rest << desk.answer()->payload;
        EXPECT_EQ(command->kind, kind);
        EXPECT_EQ(command->slot, *desk.configuration->find(slot));
        EXPECT_EQ(command->value, value);
    }
    ASSERT_TRUE(desk.give("-3", "takt/cloud/set/Setpoint"));
    EXPECT_EQ(desk.next()->value, value::Value(std::int64_t{-3}));
}

TEST(CommandDesk, AnAnswerNeverGoesToATopicOfCommands) {
    for (const auto* topic : {"", "takt/cloud/command", "takt/cloud/set/Setpoint", "a/#", "+"}) {
        Desk desk;
        ASSERT_TRUE(desk.give("x", "takt/cloud/command", {.response_topic = topic}));
        EXPECT_EQ(desk.answer()->topic, "takt/cloud/answer");
    }
}

// Random messages, outcomes, time and connections. Every id has the same outcome in all its answers, and is
// executed once at most.
TEST(CommandDesk, EveryAcceptedCommandHasExactlyOneOutcome) {
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        std::mt19937 random(seed);
        const auto below = [&](std::uint32_t most) { return random() % most; };
        Desk desk;
        std::map<std::uint64_t, Command> running;
        std::map<std::string, int> executed;  // by the value: the number of the command
        std::map<std::string, std::string> outcomes;
        const auto take = [&] {
            while (const auto answer = desk.answer()) {
                const auto json = Json::parse(answer->payload);
                ASSERT_TRUE(json);
                const auto* const id = json->find("id");
                const auto* const reason = json->find("reason");
                const bool anonymous = id == nullptr || id->is_null();
                if (anonymous ||
                    (reason != nullptr && (*reason == Json("retained") || *reason == Json("not_subscribed") ||
                                           *reason == Json("duplicate_id"))))
                    continue;
                const auto [known, fresh] =
                    outcomes.try_emplace(std::get<std::string>(id->value()), answer->payload);
                EXPECT_TRUE(fresh || known->second == answer->payload) << seed << answer->payload;
            }
        };
        std::map<int, bool> allowed;  // by value: it may be executed
        std::size_t accepted = 0;
        for (int step = 0; step < 400; ++step) {
            switch (below(5)) {
                case 0:
                case 1: {
                    const auto number = static_cast<int>(below(60));
                    const bool retain = below(6) == 0;
                    const bool subscribed = below(6) != 0;
                    const bool old = number % 7 == 0;
                    const bool unlisted = number % 5 == 0;
                    allowed[number] = !old && !unlisted;
                    desk.give(request(fmt::format("{}", number),
                                      fmt::format(R"("command":"set","variable":"{}","value":{}{})",
                                                  unlisted ? "Level" : "Setpoint",
                                                  below(8) == 0 ? number + 100 : number,
                                                  old ? R"(,"sent":"2026-11-24T02:00:00Z")" : "")),
                              "takt/cloud/command", {}, retain, subscribed);
                    break;
                }
                case 2:
                    while (const auto command = desk.next()) {
                        const auto value = static_cast<int>(std::get<std::int64_t>(command->value)) % 100;
                        EXPECT_TRUE(allowed[value]) << seed;
                        EXPECT_EQ(++executed[fmt::format("{}", value)], 1) << seed;
                        EXPECT_GT(*command->expires, desk.now.t);
                        running.emplace(command->tag, *command);
                        ++accepted;
                    }
                    break;
                case 3:
                    if (!running.empty()) {
                        const auto first = running.begin();
                        desk.done(first->second, static_cast<value::CommandResult>(below(4)));
                        running.erase(first);
                    }
                    break;
                default: desk.pass(std::chrono::milliseconds(below(8000)));
            }
            if (below(3) == 0) take();
        }
        desk.desk.stop(desk.now);
        take();
        EXPECT_EQ(desk.desk.open(), 0U);
        EXPECT_GT(accepted, 0U);
        for (const auto& [id, times] : executed) EXPECT_TRUE(outcomes.contains(id)) << seed;
    }
}

TEST(CommandDesk, RandomBytesAreRefused) {
    std::mt19937 random(7);
    Desk desk;
    std::set<std::string> given;
    const std::string seed = request("a", kSet + R"(,"sent":"2026-11-24T02:30:00Z","expiry_s":2.5)");
    for (int i = 0; i < 20'000; ++i) {
        std::string payload = random() % 2 == 0 ? seed : std::string(random() % 40, '\0');
        for (auto changes = random() % 4 + 1; changes > 0 && !payload.empty(); --changes)
            payload[random() % payload.size()] = static_cast<char>(random());
        const bool plain = random() % 3 == 0;
        const auto lines = desk.audit.size();
        ASSERT_TRUE(desk.give(payload, plain ? "takt/cloud/set/" + payload : "takt/cloud/command"));
        while (const auto command = desk.next()) desk.done(*command);
        if (desk.audit.size() == lines) {
            EXPECT_TRUE(!plain && given.contains(payload)) << "only a repeated command has no line";
        }
        if (!plain) given.insert(payload);
        while (const auto answer = desk.answer()) ASSERT_TRUE(Json::parse(answer->payload));
    }
}

}  // namespace command_desk_test
}  // namespace takt::publish
