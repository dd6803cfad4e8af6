// Outcomes of commands as lines of text and JSON. Hostile text is escaped in both.
#include "takt/report/states/command_report.hpp"

#include <gtest/gtest.h>

#include "host_sample.hpp"

namespace takt::report {
namespace command_report_test {

using namespace test;
using host::Command;
using host::Outcome;
using value::CommandResult;
using value::Quality;
using value::Reason;

Outcome outcome_of(Command::Kind kind, const std::string& name, value::Value value,
                   CommandResult result = CommandResult::done, Reason reason = Reason::ok) {
    Outcome made;
    made.id = kind == Command::Kind::get ? 0 : 9;
    made.kind = kind;
    made.slot = slot_of(name);
    made.value = std::move(value);
    made.result = result;
    made.reason = reason;
    return made;
}

template <class Change>
Outcome with(Outcome outcome, Change change) {
    change(outcome);
    return outcome;
}

TEST(CommandReport, EachOutcomeAsALineAndAsJson) {
    using enum Command::Kind;
    const auto differs = [](Outcome& outcome) {
        outcome.written = std::int64_t{50};
        outcome.read_back = std::int64_t{49};
    };
    const struct {
        Outcome outcome;
        const char* line;
        const char* json;
    } cases[] = {
        {outcome_of(get, "Level", std::int64_t{17}), "ok Level 17",
         R"({"event":"answer","command":"get","name":"Level","value":"17"})"},
        {outcome_of(get, "Level", {}), "ok Level", R"({"event":"answer","command":"get","name":"Level"})"},
        {with(outcome_of(get, "Level", std::int64_t{17}), [](auto& o) { o.quality = Quality::uncertain; }),
         "ok Level 17 uncertain",
         R"({"event":"answer","command":"get","name":"Level","value":"17","quality":"uncertain"})"},
        {with(outcome_of(get, "Level", std::int64_t{17}, CommandResult::done, Reason::timeout),
              [](auto& o) { o.quality = Quality::bad; }),
         "ok Level 17 bad timeout",
         R"({"event":"answer","command":"get","name":"Level","value":"17","quality":"bad",)"
         R"("reason":"timeout"})"},
        {outcome_of(set, "go", true), "ok go true",
         R"({"event":"answer","command":"set","id":9,"name":"go","value":"true"})"},
        {with(outcome_of(set, "Speed", 2.5), [](auto& o) { o.progress = Outcome::Progress::waiting; }),
         "ok Speed 2.5 waiting",
         R"({"event":"answer","command":"set","id":9,"name":"Speed","value":"2.5","waiting":true})"},
        {with(outcome_of(set, "Speed", 2.5), [](auto& o) { o.progress = Outcome::Progress::superseded; }),
         "ok Speed 2.5 superseded",
         R"({"event":"answer","command":"set","id":9,"name":"Speed","value":"2.5","superseded":true})"},
        {with(outcome_of(set, "Speed", 2.5), [](auto& o) { o.progress = Outcome::Progress::not_written; }),
         "ok Speed 2.5 not_written: nothing is sent: Speed has neither `write_on_change` nor "
         "`write_trigger`; use `write Speed` or set `write_on_change: true`",
         R"({"event":"answer","command":"set","id":9,"name":"Speed","value":"2.5","not_written":true,)"
         R"("text":"nothing is sent: Speed has neither `write_on_change` nor `write_trigger`; use )"
         R"(`write Speed` or set `write_on_change: true`"})"},
        {with(outcome_of(set, "Speed", 0.3), [](auto& o) { o.rounded = o.not_retained = true; }),
         "ok Speed 0.3 rounded not_retained",
         R"({"event":"answer","command":"set","id":9,"name":"Speed","value":"0.3","rounded":true,)"
         R"("retained":false})"},
        {outcome_of(set, "Level", std::int64_t{50}, CommandResult::refused, Reason::switched_off),
         "refused Level switched_off wanted 50",
         R"({"event":"outcome","command":"set","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"refused","reason":"switched_off","wanted":"50"})"},
        {outcome_of(write, "Level", std::int64_t{50}), "done Level",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"done","reason":"","wanted":"50"})"},
        {with(outcome_of(write, "Speed", 0.3), [](auto& o) { o.rounded = true; }), "done Speed rounded",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Speed",)"
         R"("outcome":"done","reason":"","wanted":"0.3","rounded":true})"},
        {outcome_of(write, "Level", std::int64_t{50}, CommandResult::refused, value::exception_reason(2)),
         "refused Level exception 2 wanted 50",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"refused","reason":"exception 2","wanted":"50"})"},
        {with(outcome_of(write, "Level", std::int64_t{50}, CommandResult::refused, Reason::differs), differs),
         "refused Level differs written 50 read 49",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"refused","reason":"differs","wanted":"50","written":"50","read":"49"})"},
        {outcome_of(write, "Level", std::int64_t{50}, CommandResult::unknown, Reason::timeout),
         "unknown Level timeout wanted 50",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"unknown","reason":"timeout","wanted":"50"})"},
        {outcome_of(write, "Level", std::int64_t{50}, CommandResult::expired), "expired Level wanted 50",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Level",)"
         R"("outcome":"expired","reason":"","wanted":"50"})"},
        {outcome_of(write, "go", true, CommandResult::queue_full), "queue_full go wanted true",
         R"({"event":"outcome","command":"write","id":9,"name":"go","outcome":"queue_full","reason":"",)"
         R"("wanted":"true"})"},
        {outcome_of(write, "Tag", kHostile, CommandResult::expired),
         R"(expired Tag wanted a\u{1B}[2J\nb"\\u{07})",
         R"({"event":"outcome","command":"write","id":9,"line":"main","device":"Котёл","name":"Tag",)"
         R"("outcome":"expired","reason":"","wanted":"a\u001b[2J\nb\"\\\u0007"})"},
        {outcome_of(get, "Tag", kHostile), R"(ok Tag a\u{1B}[2J\nb"\\u{07})",
         R"({"event":"answer","command":"get","name":"Tag","value":"a\u001b[2J\nb\"\\\u0007"})"},
    };
    for (const auto& [outcome, line, json] : cases) {
        EXPECT_EQ(outcome_line(english(), *plant(), outcome), std::string(line) + '\n');
        EXPECT_EQ(outcome_json(english(), *plant(), outcome).dump(), json);
    }
}

TEST(CommandReport, ACommandThatWasNotAccepted) {
    const auto refused = with(outcome_of(Command::Kind::write, "Level", std::int64_t{50}), [](auto& outcome) {
        outcome.error = fail(Code::out_of_range, "Level", 50, 0, 40).error();
    });
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = texts.describe(*refused.error);
        EXPECT_EQ(outcome_line(texts, *plant(), refused), "error out_of_range " + text + '\n');
        const auto json = outcome_json(texts, *plant(), refused);
        EXPECT_EQ(json, error_json(texts, *refused.error, "write", "Level"));
        EXPECT_JSON(at(json, "event"), "error");
        EXPECT_JSON(at(json, "command"), "write");
        EXPECT_JSON(at(json, "name"), "Level");
        EXPECT_JSON(at(json, "code"), "out_of_range");
        EXPECT_JSON(at(json, "text"), text);
    }
}

TEST(CommandReport, ALineThatIsNoCommand) {
    const auto error = fail(Code::syntax, kHostile).error();
    const auto json = error_json(english(), error, "", "");
    EXPECT_EQ(json.find("command"), nullptr);
    EXPECT_EQ(json.find("name"), nullptr);
    EXPECT_JSON(at(json, "code"), "syntax");
    const auto line = error_line(english(), error);
    EXPECT_TRUE(line.starts_with("error syntax ")) << line;
    expect_contains(line, kHostileLine);
    EXPECT_EQ(count_of(line, "\n"), 1U) << "an answer is one line";
    EXPECT_EQ(error_line("busy", "a\nb"), "error busy a\\nb\n");
}

TEST(CommandReport, Quit) {
    EXPECT_EQ(quit_line(), "ok\n");
    EXPECT_EQ(quit_json().dump(), R"({"event":"answer","command":"quit"})");
}

TEST(CommandReport, ReasonsAsWords) {
    const struct {
        Reason reason;
        const char* word;
    } cases[] = {{Reason::ok, ""},
                 {Reason::timeout, "timeout"},
                 {Reason::bad_checksum, "bad_checksum"},
                 {Reason::unexpected_reply, "unexpected_reply"},
                 {Reason::link_lost, "link_lost"},
                 {Reason::switched_off, "switched_off"},
                 {Reason::not_answering, "not_answering"},
                 {Reason::differs, "differs"},
                 {Reason::superseded, "superseded"},
                 {Reason::stale, "stale"},
                 {Reason::never_connected, "never_connected"},
                 {value::exception_reason(1), "exception 1"},
                 {value::exception_reason(99), "exception 99"},
                 {value::exception_reason(100), "exception 100"},
                 {value::exception_reason(255), "exception 255"},
                 {value::exception_reason(0), "exception 0"}};
    for (const auto& [reason, word] : cases) EXPECT_EQ(reason_word(reason), word);
}

}  // namespace command_report_test
}  // namespace takt::report
