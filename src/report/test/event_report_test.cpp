#include "takt/report/states/event_report.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "host_sample.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/report/states/command_report.hpp"

namespace takt::report {
namespace event_report_test {

using namespace test;
using namespace std::chrono_literals;
using value::CommandResult;
using value::Quality;
using value::Reason;
using value::Value;

const Instant kStarted = Instant{1s};
const Error kNoPort = fail(Code::cannot_open, "/dev/ttyUSB0", 2).error();

host::Event event(decltype(host::Event::body) body) {
    return {.number = 7, .generation = 1, .t = kStarted + 2500ms, .body = std::move(body)};
}

std::string text_of(decltype(host::Event::body) body, const Texts& texts = english()) {
    return event_text(texts, *plant(), event(std::move(body)));
}

file::Json json_of(decltype(host::Event::body) body, const Texts& texts = english()) {
    return event_json(texts, *plant(), kStarted, event(std::move(body)));
}

/// The members of an event behind its name and time.
std::string members_of(decltype(host::Event::body) body, const std::string& name) {
    const auto text = json_of(std::move(body)).dump();
    const auto head = R"({"event":")" + name + R"(","time_ms":2500.0)";
    EXPECT_TRUE(text.starts_with(head)) << text;
    return text.starts_with(head) ? text.substr(head.size()) : text;
}

host::ValueChanged changed(const std::string& name, Value value, Quality quality = Quality::good,
                           Reason reason = Reason::ok, std::optional<Duration> age = 250ms) {
    return {.slot = slot_of(name),
            .value = std::move(value),
            .quality = quality,
            .reason = reason,
            .sampled_at = age ? std::optional(kStarted + 2500ms - *age) : std::nullopt};
}

host::RequestKey request(std::optional<wire::Function> read, std::optional<wire::Function> write = {}) {
    return {.read = read, .write = write, .start = 0, .quantity = 2};
}

TEST(EventReport, AChangedValueAsText) {
    const auto why = [](Quality quality, Reason reason) {
        return " (" + english().quality(quality, reason) + ")";
    };
    const struct {
        host::ValueChanged changed;
        std::string text;
    } cases[] = {
        {changed("Level", std::int64_t{-17}), "Котёл Level = -17 мм"},
        {changed("Speed", 2.5), "Котёл Speed = 2.5"},
        {changed("Pump", false), "Котёл Pump = false"},
        {changed("go", true), "go = true"},
        {changed("Level", {}, Quality::never_read),
         "Котёл Level = – мм" + why(Quality::never_read, Reason::ok)},
        {changed("Level", std::int64_t{3}, Quality::uncertain, Reason::timeout),
         "Котёл Level = 3 мм" + why(Quality::uncertain, Reason::timeout)},
        {changed("Level", std::int64_t{3}, Quality::bad, value::exception_reason(2)),
         "Котёл Level = 3 мм" + why(Quality::bad, value::exception_reason(2))},
        {changed("Tag", kHostile), "Котёл Tag = " + kHostileLine},
    };
    for (const auto& [body, text] : cases) EXPECT_EQ(text_of(body), text);
}

TEST(EventReport, AChangedValueAsJson) {
    const struct {
        host::ValueChanged changed;
        const char* members;
    } cases[] = {
        {changed("Level", std::int64_t{-17}),
         R"(,"line":"main","device":"Котёл","name":"Level","value":-17,"quality":"good","reason":"",)"
         R"("age_ms":250.0})"},
        {changed("Speed", std::numeric_limits<double>::quiet_NaN()),
         R"(,"line":"main","device":"Котёл","name":"Speed","value":null,"quality":"good","reason":"",)"
         R"("age_ms":250.0})"},
        {changed("go", true, Quality::good, Reason::ok, -1s),
         R"(,"line":"","device":"","name":"go","value":true,"quality":"good","reason":"","age_ms":0.0})"},
        {changed("Pump", {}, Quality::bad, Reason::not_answering, std::nullopt),
         R"(,"line":"main","device":"Котёл","name":"Pump","value":null,"quality":"bad",)"
         R"("reason":"not_answering","age_ms":null})"},
        {changed("Pump", true, Quality::uncertain, value::exception_reason(200)),
         R"(,"line":"main","device":"Котёл","name":"Pump","value":true,"quality":"uncertain",)"
         R"("reason":"exception 200","age_ms":250.0})"},
        {changed("Tag", kHostile + "\xFF"),
         R"(,"line":"main","device":"Котёл","name":"Tag","value":"a\u001b[2J\nb\"\\\u0007)"
         "\xEF\xBF\xBD"
         R"(","quality":"good","reason":"","age_ms":250.0})"},
    };
    for (const auto& [body, members] : cases) EXPECT_EQ(members_of(body, "value"), members);
}

TEST(EventReport, StatesOfDevices) {
    const struct {
        poll::DeviceState state;
        const char* word;
    } cases[] = {{poll::DeviceState::unknown, "unknown"},
                 {poll::DeviceState::answering, "answering"},
                 {poll::DeviceState::not_answering, "not_answering"},
                 {poll::DeviceState::switched_off, "switched_off"},
                 {poll::DeviceState::link_down, "link_down"}};
    for (const auto& [state, word] : cases) {
        const host::DeviceStateChanged body{.state = state};
        EXPECT_EQ(members_of(body, "device"),
                  R"(,"line":"main","device":"Котёл","state":")" + std::string(word) + "\"}");
        for (const auto language : kLanguages) {
            const Texts texts(language);
            EXPECT_EQ(text_of(body, texts), "Котёл: " + texts("app.state." + std::string(word)));
            expect_complete(text_of(body, texts));
        }
    }
}

// In the words of `ctl status` and of the page.
TEST(EventReport, ADeviceThatDoesNotAnswerHasAReason) {
    using value::Reason;
    const std::pair<Reason, const char*> cases[] = {
        {Reason::timeout, "not answering (time-out)"},
        {Reason::bad_checksum, "answers are damaged"},
        {Reason::unexpected_reply, "answers do not fit"},
        {Reason::closed, "not answering (closed by the peer)"},
        {value::exception_reason(11), "not answering (exception 11: "},
    };
    for (const auto& [failure, text] : cases) {
        const host::DeviceStateChanged body{.state = poll::DeviceState::not_answering, .failure = failure};
        expect_contains(text_of(body, english()), std::string(": ") + text);
        expect_contains(members_of(body, "device"), R"("cause":")");
        for (const auto language : kLanguages) expect_complete(text_of(body, Texts(language)));
    }
}

TEST(EventReport, ADeviceThatChangesOften) {
    using Shown = host::DeviceStateChanged::Shown;
    host::DeviceStateChanged body{
        .state = poll::DeviceState::answering, .shown = Shown::often, .changes = 6, .in = 12s};
    EXPECT_EQ(text_of(body, english()),
              "Котёл: changes often: 6 changes in 12 s; the next ones are only counted");
    expect_contains(members_of(body, "device"), R"("changes_often":true,"changes":6,"in_ms":12000.0)");
    body.shown = Shown::counted;
    EXPECT_EQ(text_of(body, english()), "");
    EXPECT_TRUE(json_of(body).is_null());
    body.shown = Shown::steady;
    EXPECT_EQ(text_of(body, english()), "Котёл: answering; it changed 6 times in 12 s and is steady now");
    expect_contains(members_of(body, "device"), R"("changes_often":false)");
    for (const auto language : kLanguages) expect_complete(text_of(body, Texts(language)));
    body.shown = Shown::total;
    EXPECT_EQ(text_of(body, english()), "Котёл: answering; it changed 6 times in 12 s");
    for (const auto language : kLanguages) expect_complete(text_of(body, Texts(language)));
}

TEST(EventReport, Links) {
    const host::LinkChanged down{.up = false, .why = kNoPort};
    const host::LinkChanged again{.up = false, .why = kNoPort, .repeated = 14, .in = 70s};
    expect_contains(members_of(again, "link"), R"("repeated":14,"in_ms":70000.0)");
    for (const auto language : kLanguages) expect_complete(text_of(again, Texts(language)));
    EXPECT_EQ(members_of(host::LinkChanged{.up = true}, "link"), R"(,"line":"main","up":true})");
    EXPECT_EQ(members_of(host::LinkChanged{.up = false}, "link"), R"(,"line":"main","up":false})");
    EXPECT_JSON(at(json_of(down), "text"), english().describe(kNoPort));
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(text_of(host::LinkChanged{.up = true}, texts), texts("app.link_up", {{"line", "main"}}));
        EXPECT_EQ(text_of(down, texts),
                  texts("app.link_down", {{"line", "main"}, {"why", texts.describe(kNoPort)}}));
    }
    const auto hostile = fail(Code::cannot_open, kHostile, 2).error();
    expect_contains(text_of(host::LinkChanged{.up = false, .why = hostile}), kHostileLine);
}

std::string registers_read(const Texts& texts) {
    return texts("log.request.3", {{"items", "0..1"}});
}

TEST(EventReport, NoiseBeforeTheAnswersOfADevice) {
    const host::NoiseFound one{.line = 0, .device = 0, .finding = {.least = 1, .most = 1}};
    EXPECT_EQ(text_of(one, english()),
              "1 byte of noise before the answers of Котёл: check bias and driver enable");
    EXPECT_EQ(members_of(one, "noise"),
              R"(,"line":"main","device":"Котёл","least_bytes":1,"most_bytes":1,"text":")" +
                  text_of(one, english()) + "\"}");
    const host::NoiseFound some{.line = 0, .device = 0, .finding = {.least = 1, .most = 3}};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(text_of(some, texts), texts("app.noise", {{"where", "Котёл"}, {"count", "1..3"}}));
    }
}

TEST(EventReport, DelaysOfADevice) {
    using Setting = poll::DelayFinding::Setting;
    for (const auto setting : {Setting::response_timeout, Setting::turnaround, Setting::learnt_timeout}) {
        const host::DelaysFound body{.line = 0, .device = 0, .finding = {setting, 148ms, 100ms, 300ms, 3}};
        const std::string name(poll::name(setting));
        const auto text =
            english()("app.delays." + name,
                      {{"where", "Котёл"}, {"delay", "148"}, {"limit", "100"}, {"advised", "300"}});
        EXPECT_EQ(members_of(body, "delays"),
                  R"(,"line":"main","device":"Котёл","setting":")" + name +
                      R"(","delay_ms":148.0,"limit_ms":100.0,"advised_ms":300.0,"count":3,"later":0,)" +
                      R"("text":")" + text + "\"}");
        for (const auto language : kLanguages) {
            const Texts texts(language);
            EXPECT_EQ(text_of(body, texts),
                      texts("app.delays." + name,
                            {{"where", "Котёл"}, {"delay", "148"}, {"limit", "100"}, {"advised", "300"}}));
        }
    }
    EXPECT_EQ(
        text_of(host::DelaysFound{.finding = {Setting::response_timeout, 148ms, 100ms, 300ms}}, english()),
        "Device Котёл answered 148 ms after its request; response_timeout is 100 ms: set 300ms");
    EXPECT_EQ(
        text_of(host::DelaysFound{.finding = {Setting::turnaround, 148ms, 20ms, 100ms, 40, 2}}, english()),
        "Device Котёл answered 148 ms after its request; turnaround is 20 ms: set 100ms (2 of 40 such "
        "responses took longer)");
    const host::DelaysFound pause{.finding = {Setting::response_timeout, 148ms, 100ms, {}, 2}};
    EXPECT_EQ(text_of(pause, english()),
              "Device Котёл answered 148 ms after its request; response_timeout is 100 ms");
    expect_contains(members_of(pause, "delays"), R"("advised_ms":null,"count":2,"later":0,)");
}

TEST(EventReport, OverrunsOfAPeriod) {
    for (const bool overrun : {true, false}) {
        const host::PeriodOverrun body{.request = request(wire::Function::read_holding_registers),
                                       .period = 500ms,
                                       .real = 1234ms,
                                       .overrun = overrun};
        EXPECT_EQ(
            members_of(body, "overrun"),
            std::string(R"(,"line":"main","device":"Котёл","function":3,"start":0,"period_ms":500.0,)") +
                R"("real_period_ms":1234.0,"overrun":)" + (overrun ? "true}" : "false}"));
        for (const auto language : kLanguages) {
            const Texts texts(language);
            EXPECT_EQ(text_of(body, texts),
                      texts(overrun ? "app.overrun" : "app.overrun_over", {{"where", "Котёл"},
                                                                           {"request", registers_read(texts)},
                                                                           {"period", "500"},
                                                                           {"real", "1234"}}));
        }
    }
}

TEST(EventReport, AWriteThatWaits) {
    const struct {
        host::RequestKey request;
        int function;
    } cases[] = {
        {request({}, wire::Function::write_multiple_registers), 16},
        {request(wire::Function::read_holding_registers, wire::Function::write_multiple_registers), 3}};
    for (const auto& [key, function] : cases) {
        const host::WriteWaiting body{.request = key, .variable = 1};
        EXPECT_EQ(members_of(body, "write_waiting"), R"(,"line":"main","device":"Котёл","function":)" +
                                                         std::to_string(function) +
                                                         R"(,"start":0,"name":"Speed"})");
        EXPECT_EQ(text_of(body), english()("app.write_waiting", {{"where", "Котёл"},
                                                                 {"request", "write holding registers 0..1"},
                                                                 {"name", "Speed"}}));
    }
}

TEST(EventReport, AValueThatIsReadBackAsAnother) {
    const host::VerifyFailed numbers{slot_of("Level"), std::int64_t{50}, std::int64_t{49}};
    EXPECT_EQ(members_of(numbers, "verify_failed"),
              R"(,"line":"main","device":"Котёл","name":"Level","written":50,"read":49})");
    EXPECT_EQ(text_of(numbers),
              english()("app.verify_failed",
                        {{"where", "Котёл"}, {"name", "Level"}, {"written", "50 мм"}, {"read", "49 мм"}}));
    const host::VerifyFailed hostile{slot_of("Tag"), std::string("ok"), kHostile};
    expect_contains(text_of(hostile), kHostileLine);
    EXPECT_TRUE(file::Json::parse(json_of(hostile).dump()));
}

TEST(EventReport, LearntGaps) {
    using Kind = poll::GapEvent::Kind;
    const struct {
        Kind kind;
        const char* word;
        std::uint8_t exception;
        const char* exception_json;
    } cases[] = {{Kind::confirmed, "confirmed", 0, "null"},
                 {Kind::refused, "refused", 2, "2"},
                 {Kind::too_long, "too_long", 3, "3"},
                 {Kind::doubted, "doubted", 255, "255"}};
    for (const auto& [kind, word, exception, exception_json] : cases) {
        const host::GapLearnt body{.line = 0,
                                   .gap_event = {.kind = kind, .items = {2, 9}, .exception = exception}};
        EXPECT_EQ(members_of(body, "learnt"),
                  R"(,"line":"main","device":"Котёл","function":3,"first":2,"last":9,"result":")" +
                      std::string(word) + R"(","exception":)" + exception_json + '}');
        for (const auto language : kLanguages) {
            const auto text = text_of(body, Texts(language));
            expect_complete(text);
            expect_contains(text, "Котёл: ");
            expect_contains(text, " 2..9");
        }
    }
}

host::WriteFinished finished(CommandResult result, Reason reason = Reason::ok) {
    return {.outcome = {.id = 1,
                        .kind = host::Command::Kind::write,
                        .slot = slot_of("Level"),
                        .result = result,
                        .reason = reason,
                        .value = std::int64_t{50}}};
}

TEST(EventReport, WritesThatWereNotDone) {
    const struct {
        CommandResult result;
        const char* word;
        Reason reason;
        const char* why;  // its code; nullptr: none is given
        const char* number = "";
        const char* exception = "";
    } cases[] = {
        {CommandResult::refused, "refused", value::exception_reason(2), "log.why.exception", "2",
         "exception.2"},
        {CommandResult::refused, "refused", value::exception_reason(0), "log.why.exception", "0",
         "exception.unknown"},
        {CommandResult::refused, "refused", value::exception_reason(200), "log.why.exception", "200",
         "exception.unknown"},
        {CommandResult::refused, "refused", Reason::not_answering, "app.reason.not_answering"},
        {CommandResult::refused, "refused", Reason::superseded, "app.reason.superseded"},
        {CommandResult::refused, "refused", Reason::ok, "app.write.why.refused"},
        {CommandResult::unknown, "unknown", Reason::timeout, "app.reason.timeout"},
        {CommandResult::unknown, "unknown", Reason::ok, "app.write.why.unknown"},
        {CommandResult::expired, "expired", Reason::ok, nullptr},
        {CommandResult::queue_full, "queue_full", Reason::ok, nullptr},
    };
    for (const auto language : kLanguages) {
        const Texts texts(language);
        for (const auto& [result, word, reason, code, number, exception] : cases) {
            const auto why =
                code ? texts(code, {{"code", number}, {"exception", texts(exception)}}) : std::string();
            const auto text = text_of(finished(result, reason), texts);
            EXPECT_EQ(text, texts("app.write." + std::string(word), {{"where", "Котёл"},
                                                                     {"name", "Level"},
                                                                     {"wanted", "50 мм"},
                                                                     {"cause", texts("app.write.by_write")},
                                                                     {"why", why}}));
            expect_complete(text);
            const auto json = json_of(finished(result, reason), texts);
            EXPECT_JSON(at(json, "event"), "outcome");
            EXPECT_JSON(at(json, "outcome"), word);
            EXPECT_JSON(at(json, "reason"), reason_word(reason));
            EXPECT_JSON(at(json, "time_ms"), 2500.0);
        }
    }
}

TEST(EventReport, TheCauseOfAWrite) {
    auto body = finished(CommandResult::refused, Reason::not_answering);
    const auto with = [&](const char* cause) {
        return "Котёл: Level: 50 мм was not written (" + std::string(cause) + "): not answering";
    };
    body.outcome.kind = host::Command::Kind::set;
    EXPECT_EQ(text_of(body), with("command `set`"));
    body.outcome.id = 0;
    EXPECT_EQ(text_of(body), with("write on change"));
    body.outcome.trigger = slot_of("go");
    EXPECT_EQ(text_of(body), with("trigger go"));
}

TEST(EventReport, SomeEventsNeedNoLine) {
    EXPECT_EQ(text_of(finished(CommandResult::done)), "");
    EXPECT_TRUE(json_of(finished(CommandResult::done)).is_null());
    EXPECT_EQ(text_of(finished(CommandResult::refused, Reason::differs)), "") << "VerifyFailed reports it";
    EXPECT_JSON(at(json_of(finished(CommandResult::refused, Reason::differs)), "reason"), "differs");
    EXPECT_EQ(text_of(host::AuditRecorded{}), "");
    EXPECT_TRUE(json_of(host::AuditRecorded{}).is_null());
}

TEST(EventReport, Notices) {
    using Severity = host::Notice::Severity;
    const auto without = without_stop(english().describe(kNoPort));
    const host::Notice::Arguments serving{{"where", "tcp://127.0.0.1:1502"}, {"units", "1"}};
    const struct {
        host::Notice notice;
        std::string_view severity;
        std::string text;
    } cases[] = {
        {{Severity::status, "endpoint.serving", serving, {}},
         "status",
         english()("endpoint.serving", {{"where", "tcp://127.0.0.1:1502"}, {"units", "1"}})},
        {{Severity::error, "host.learnt.failed", {}, kNoPort},
         "error",
         english()("host.learnt.failed", {{"error", without}})},
        {{Severity::error, "host.retain.failed", {}, kNoPort},
         "error",
         english()("host.retain.failed", {{"error", without}})},
        {{Severity::warning, "host.retain.foreign", {{"file", "a.state"}}, {}},
         "warning",
         english()("host.retain.unavailable",
                   {{"error", english()("host.retain.foreign", {{"file", "a.state"}})}})},
    };
    for (const auto& [notice, severity, text] : cases) {
        EXPECT_EQ(notice_text(english(), notice), text);
        EXPECT_EQ(text_of(notice), text);
        EXPECT_JSON(at(json_of(notice), "severity"), severity);
        EXPECT_JSON(at(json_of(notice), "code"), notice.code);
        EXPECT_JSON(at(json_of(notice), "text"), text);
    }
    const host::Notice hostile{
        Severity::status, "endpoint.serving", {{"where", kHostile}, {"units", "1"}}, {}};
    expect_contains(text_of(hostile), kHostileLine);
}

TEST(EventReport, MissedEventsAndAnotherProject) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(text_of(host::EventsLost{.count = 3}, texts), texts("app.missed", {{"count", "3"}}));
        EXPECT_EQ(missed_text(texts, 3), texts("app.missed", {{"count", "3"}}));
        EXPECT_EQ(text_of(host::ConfigurationChanged{.generation = 2}, texts), texts("app.applied"));
    }
    EXPECT_EQ(missed_json(18446744073709551615U).dump(), R"({"event":"gap","missed":18446744073709551615})");
    EXPECT_EQ(json_of(host::EventsLost{.count = 3}), missed_json(3));
    EXPECT_EQ(members_of(host::ConfigurationChanged{.generation = 2}, "applied"), R"(,"generation":2})");
}

}  // namespace event_report_test
}  // namespace takt::report
