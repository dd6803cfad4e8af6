// Why a running project is not in order.
#include "states/problems.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "host_sample.hpp"
#include "takt/report/states/state_report.hpp"

namespace takt::report {
namespace problems_test {

using namespace test;
using namespace std::chrono_literals;
using value::Quality;
using value::Reason;
using Kind = Problem::Kind;
using Severity = Problem::Severity;

/// The line is up, its device answered 11,511 requests, and every value was read.
host::Snapshot healthy() {
    auto made = snapshot_of(plant());
    made.lines[0].up = made.lines[0].was_up = true;
    made.lines[0].devices[0].state = poll::DeviceState::answering;
    made.lines[0].devices[0].counters.sent = 11511;
    for (auto& slot : made.values) slot = {.quality = Quality::good, .good_at = made.t - 100ms};
    return made;
}

void fail(host::Snapshot& snapshot, const std::string& name, Reason reason, Duration since = 4s) {
    auto& slot = snapshot.values[slot_of(name).value];
    slot.quality = Quality::bad;
    slot.reason = reason;
    slot.good_at = snapshot.t - since;
}

/// The request that reads the variable.
std::size_t request_of(const host::Snapshot& snapshot, const std::string& name) {
    const auto& requests = snapshot.lines[0].plan->requests;
    const auto& variables = plant()->project().lines[0].devices[0].variables;
    const auto reads = [&](const plan::Request& request) {
        return std::ranges::any_of(request.variables,
                                   [&](std::size_t v) { return request.read && variables[v].name == name; });
    };
    return static_cast<std::size_t>(std::ranges::find_if(requests, reads) - requests.begin());
}

std::vector<Problem> problems(const host::Snapshot& snapshot) {
    return find_problems(english(), snapshot);
}

std::string text_of(const host::Snapshot& snapshot) {
    const auto json = status_json(english(), snapshot, "");
    return problems_text(english(), *json.find("problems"));
}

TEST(Problems, AHealthyProjectHasNone) {
    EXPECT_TRUE(problems(healthy()).empty());
    EXPECT_EQ(health_word(healthy(), {}), "ok");
}

TEST(Problems, ARefusedRequestNamesRangeVariableExceptionAndRemedy) {
    auto snapshot = healthy();
    fail(snapshot, "Pump", value::exception_reason(2), 240s);
    auto& counters = snapshot.lines[0].requests[request_of(snapshot, "Pump")].counters;
    counters.sent = counters.exceptions = counters.exceptions_by_code[2] = 3837;
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, Kind::refused);
    EXPECT_EQ(found[0].severity, Severity::warning);
    EXPECT_EQ(found[0].variables, std::vector<std::string>{"Pump"});
    EXPECT_EQ(found[0].since, 240s);
    EXPECT_EQ(text_of(snapshot),
              "  warning: Котёл: 0x01 3: the device answers with exception 2: illegal data address, "
              "3837 of 3837 requests (100.0 %), for 4 min: Pump\n"
              "    The device does not have these addresses. Check start and quantity; addresses on the wire "
              "start at zero.\n");
    EXPECT_EQ(health_word(snapshot, found), "degraded");

    snapshot.values[slot_of("Pump").value].quality = Quality::good;
    EXPECT_EQ(problems(snapshot)[0].severity, Severity::note) << "it answers again";
    EXPECT_EQ(health_word(snapshot, problems(snapshot)), "ok");
}

// A device that refuses some of its requests at random has one problem with one time, whichever values are
// good at the moment. What it always refuses is a problem of its own.
TEST(Problems, ADeviceThatRefusesOftenIsOneProblem) {
    auto snapshot = healthy();
    auto& line = snapshot.lines[0];
    auto& device = line.devices[0];
    for (int i = 0; i < 40; ++i) device.refusals.ended(snapshot.t - 60s, i % 5 > 2);
    for (auto& request : line.requests) {
        request.counters.sent = 50;
        request.counters.answered = 20;
        request.counters.exceptions = request.counters.exceptions_by_code[4] = 30;
    }
    const auto check = [&](const std::vector<std::string>& bad) {
        for (auto& slot : snapshot.values) slot = {.quality = Quality::good, .good_at = snapshot.t - 100ms};
        for (const auto& name : bad) fail(snapshot, name, value::exception_reason(4));
        const auto found = problems(snapshot);
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].kind, Kind::refused);
        EXPECT_EQ(found[0].severity, Severity::warning);
        EXPECT_EQ(found[0].since, 60s);
        EXPECT_EQ(found[0].variables, bad);
        expect_contains(found[0].text, "exception 4");
        expect_contains(text_of(snapshot), "(60.0 %)");
        expect_contains(found[0].request, "0x01 3");
        expect_contains(found[0].advice, "less often");
        EXPECT_EQ(health_word(snapshot, found), "degraded");
        EXPECT_EQ(device_state_text(english(), device), "answering, with findings");
    };
    check({});
    check({"Pump"});
    check({"Pump", "Level"});

    for (auto& request : line.requests)
        std::swap(request.counters.exceptions_by_code[2], request.counters.exceptions_by_code[4]);
    EXPECT_EQ(problems(snapshot)[0].advice.find("does not have"), std::string::npos) << "it has answered";
    for (auto& request : line.requests)
        std::swap(request.counters.exceptions_by_code[2], request.counters.exceptions_by_code[4]);

    auto& always = line.requests[request_of(snapshot, "Pump")].counters;
    always.answered = 0;
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0].request, "0x01 3");
    EXPECT_EQ(found[0].since, 4s);
    EXPECT_FALSE(found[1].request.contains("0x01 3"));

    // Those of a gateway: the device does not answer in between.
    always.answered = 20;
    for (int i = 0; i < 40; ++i) device.share.ended(snapshot.t - 60s, i % 2 == 0);
    device.counters.exceptions = device.counters.exceptions_by_code[11] = 100;
    device.counters.timeouts = 3;
    for (const auto state : {poll::DeviceState::answering, poll::DeviceState::not_answering}) {
        device.state = state;
        device.failure = state == poll::DeviceState::answering ? Reason::ok : value::exception_reason(11);
        for (auto& request : line.requests) {
            request.counters.exceptions_by_code[4] = 0;
            request.counters.exceptions_by_code[11] = 30;
        }
        fail(snapshot, "Level", Reason::not_answering);
        const auto of_gateway = problems(snapshot);
        ASSERT_EQ(of_gateway.size(), 1U);
        EXPECT_EQ(of_gateway[0].severity, Severity::warning);
        expect_contains(of_gateway[0].text, "exception 11");
    }
}

// All its responses come after the time-out: it is no dead device.
TEST(Problems, ADeviceThatAnswersTooLateIsNotSilent) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = poll::DeviceState::not_answering;
    device.failure = Reason::timeout;
    device.counters.sent = device.counters.timeouts = 24;
    device.delays = poll::DelayFinding{.delay = 401ms, .limit = 200ms, .advised = 500ms, .count = 240};
    using enum poll::DelayFinding::Setting;
    for (const auto setting : {response_timeout, turnaround, learnt_timeout}) {
        device.delays->setting = setting;
        device.late = 24;
        auto found = problems(snapshot);
        ASSERT_EQ(found.size(), 1U) << "it is listed once";
        EXPECT_EQ(found[0].severity, Severity::error);
        EXPECT_EQ(found[0].kind, Kind::slow);
        EXPECT_EQ(found[0].count, 24U);
        expect_contains(found[0].text, setting == learnt_timeout ? "500 ms" : "set 500ms");
        EXPECT_EQ(device_state_text(english(), device), "answers come too late");
        expect_contains(status_json(english(), snapshot, "").dump(), R"("cause":"late")");

        for (const auto late : {2U, 0U}) {
            device.late = late;
            found = problems(snapshot);
            ASSERT_EQ(found.size(), 2U) << "most were lost, and some came late, or only in earlier runs";
            EXPECT_EQ(found[0].kind, Kind::silent);
            EXPECT_EQ(device_state_text(english(), device), "not answering (time-out)");
        }
    }
}

// All its responses have another unit, transaction id or function: it is no dead device.
TEST(Problems, ADeviceThatAnswersForAnotherOneIsNotSilent) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = poll::DeviceState::not_answering;
    device.failure = Reason::unexpected_reply;
    device.counters.sent = device.counters.timeouts = device.foreign = 24;
    const auto asked = plant()->project().lines[0].devices[0].address;
    device.last_foreign = {Mismatch::Part::unit, 99, asked.value};
    const auto text = [&] {
        const auto found = problems(snapshot);
        EXPECT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].kind, Kind::unfitting);
        EXPECT_EQ(found[0].severity, Severity::error);
        EXPECT_EQ(found[0].count, 24U);
        return found[0].text + ". " + found[0].advice;
    };
    expect_contains(text(), "a response of unit 99 came, unit " + std::to_string(asked.value) + " was asked");
    expect_contains(text(), "Set `address: 99`");
    auto project = plant()->project();
    auto& other = project.lines[0].devices.emplace_back();
    other.name = "Pump";
    other.address = UnitId{99};
    snapshot.configuration = configuration_of(project);
    expect_contains(text(), "99 is the address of Pump: two devices may have the same address");
    device.last_foreign = {Mismatch::Part::function, 4, 3};
    expect_contains(text(), "a response to function 4 came, function 3 was asked");
    device.last_foreign = {Mismatch::Part::transaction, 0, 7};
    expect_contains(text(), "a response with transaction id 0 came, 7 was asked");
    EXPECT_EQ(device_state_text(english(), device), "answers do not fit");
}

TEST(Problems, ResponsesThatAreCutShortAreNotDamaged) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = poll::DeviceState::not_answering;
    device.failure = Reason::bad_checksum;
    device.counters.sent = device.counters.checksums = 24;
    device.cut_short = 12;
    device.last_cut_short = {Mismatch::Part::length, 6, 9};
    expect_contains(problems(snapshot)[0].text, "the responses of");  // half of them only
    device.cut_short = 13;
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].count, 24U);
    expect_contains(found[0].text, "6 of 9 bytes of the response came");
    expect_contains(found[0].advice, "The end of the response is missing");
}

// While it stops and begins to answer again, there is one problem, and its time is that of the first
// failures.
TEST(Problems, ADeviceThatFailsOftenIsOneProblem) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.counters.timeouts = 700;
    for (int i = 0; i < 20; ++i) device.share.ended(snapshot.t - 60s, i % 2 == 0);
    for (const auto state : {poll::DeviceState::answering, poll::DeviceState::not_answering}) {
        device.state = state;
        device.failure = state == poll::DeviceState::answering ? Reason::ok : Reason::timeout;
        fail(snapshot, "Level", Reason::not_answering);
        const auto found = problems(snapshot);
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].kind, Kind::unanswered);
        EXPECT_EQ(found[0].severity, Severity::warning);
        EXPECT_EQ(found[0].since, 60s);
        EXPECT_EQ(found[0].variables, std::vector<std::string>{"Level"});
        EXPECT_EQ(device_state_text(english(), device), "answering, with findings");
        EXPECT_EQ(health_word(snapshot, found), "degraded");
    }
}

// A third of its responses come after the time-out. A slow one answers requests that the engine has
// forgotten.
TEST(Problems, ADeviceThatIsOftenLateIsNotUnanswering) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.counters.sent = 1315;
    device.counters.timeouts = 510;
    device.delays = poll::DelayFinding{.delay = 351ms, .limit = 200ms, .advised = 500ms, .count = 9};
    device.late = 509;
    for (int i = 0; i < 20; ++i) device.share.ended(snapshot.t - 60s, i % 2 == 0);
    fail(snapshot, "Level", Reason::not_answering);
    const auto expect_late = [&] {
        const auto found = problems(snapshot);
        ASSERT_EQ(found.size(), 1U);
        EXPECT_EQ(found[0].kind, Kind::slow);
        EXPECT_EQ(found[0].severity, Severity::warning);
        EXPECT_EQ(found[0].since, 60s);
        EXPECT_EQ(found[0].tried, "") << "it is not probed";
        expect_contains(found[0].text, "set 500ms");
    };
    expect_late();
    device.late = 13;
    device.foreign = 490;
    device.last_foreign = {Mismatch::Part::transaction, 49403, 38435};
    expect_late();
}

// A gateway refuses each request to the device.
TEST(Problems, AnExceptionOfAllRequestsIsOneProblem) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = poll::DeviceState::not_answering;
    device.failure = value::exception_reason(10);
    device.counters.sent = device.counters.exceptions = device.counters.exceptions_by_code[10] = 50;
    auto& counters = snapshot.lines[0].requests[request_of(snapshot, "Pump")].counters;
    counters.sent = counters.exceptions = counters.exceptions_by_code[10] = 50;
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].count, 50U);
    EXPECT_EQ(found[0].of, 50U);
}

TEST(Problems, ASilentDeviceHasTheSentenceOfARead) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.state = poll::DeviceState::not_answering;
    device.failure = Reason::timeout;
    device.back_off = 8s;
    device.availability.begin(snapshot.started);
    device.availability.down(snapshot.t - 7s);
    for (const auto* const name : {"Level", "Speed", "Pump", "Tag"})
        fail(snapshot, name, Reason::not_answering);
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U) << "its values are no further problems";
    EXPECT_EQ(found[0].kind, Kind::silent);
    expect_contains(found[0].text, "no answer within");
    expect_contains(found[0].advice, "Check the unit address");
    expect_contains(found[0].tried, "after a pause, now 8 s, that doubles up to 1 min");
    EXPECT_EQ(health_word(snapshot, found), "failed");

    device.failure = value::exception_reason(10);
    expect_contains(problems(snapshot)[0].text, "gateway path unavailable");

    device.failure = Reason::bad_checksum;
    device.counters.checksums = 16;
    device.counters.sent = 25;
    EXPECT_EQ(problems(snapshot)[0].kind, Kind::damaged) << "it answers, and each response is damaged";
    expect_contains(text_of(snapshot), "are damaged, 16 of 25 requests");
    expect_contains(text_of(snapshot), "termination");
}

TEST(Problems, SomeDamagedResponsesAreANote) {
    auto snapshot = healthy();
    auto& counters = snapshot.lines[0].devices[0].counters;
    counters.checksums = 2;
    counters.sent = 25;
    EXPECT_TRUE(problems(snapshot).empty()) << "two may come on any line";
    counters.checksums = 3;
    ASSERT_EQ(problems(snapshot).size(), 1U);
    EXPECT_EQ(problems(snapshot)[0].severity, Severity::note);
    counters.sent = 301;
    EXPECT_TRUE(problems(snapshot).empty()) << "less than one in a hundred";
    counters.sent = 25;
    fail(snapshot, "Level", Reason::bad_checksum);
    ASSERT_EQ(problems(snapshot).size(), 1U) << "the same problem, with a value that is missing";
    EXPECT_EQ(problems(snapshot)[0].severity, Severity::warning);
}

TEST(Problems, RepeatedResponsesAreANote) {
    auto snapshot = healthy();
    auto& device = snapshot.lines[0].devices[0];
    device.counters.sent = 100;
    device.surplus = 2;
    EXPECT_TRUE(problems(snapshot).empty());
    device.surplus = 40;
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, Kind::repeated);
    EXPECT_EQ(found[0].severity, Severity::note);
    expect_contains(text_of(snapshot), "answers requests more than once, 40 of 100 requests");
    device.shifted = true;
    ASSERT_EQ(problems(snapshot).size(), 1U);
    EXPECT_EQ(problems(snapshot)[0].kind, Kind::shifted);
}

TEST(Problems, EachKindHasItsWord) {
    EXPECT_EQ(name(Kind::late), "late");
    EXPECT_EQ(name(Kind::shifted), "shifted");
    EXPECT_EQ(name(Kind::noise), "noise");
}

TEST(Problems, EachValueThatIsNotGoodIsNamedOnce) {
    for (const auto reason :
         {Reason::timeout, Reason::bad_checksum, Reason::unexpected_reply, Reason::link_lost, Reason::closed,
          Reason::differs, Reason::stale, Reason::ambiguous, Reason::not_answering,
          value::exception_reason(2), value::exception_reason(99)}) {
        auto snapshot = healthy();
        fail(snapshot, "Level", reason);
        std::vector<std::string> names;
        for (const auto& problem : problems(snapshot))
            names.insert(names.end(), problem.variables.begin(), problem.variables.end());
        EXPECT_EQ(names, std::vector<std::string>{"Level"}) << value::name(reason);
        EXPECT_EQ(health_word(snapshot, problems(snapshot)), "degraded");
    }
}

TEST(Problems, ALinkThatIsDownIsOneProblem) {
    auto snapshot = healthy();
    auto& line = snapshot.lines[0];
    line.up = false;
    line.why = takt::fail(Code::cannot_open, "/dev/ttyUSB0", ENOENT).error();
    line.devices[0].state = poll::DeviceState::link_down;
    for (const auto* const name : {"Level", "Speed", "Pump", "Tag"}) fail(snapshot, name, Reason::link_lost);
    const auto found = problems(snapshot);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, Kind::link);
    expect_contains(found[0].text, "/dev/ttyUSB0");
    expect_contains(found[0].advice, "adapter is plugged in");
}

TEST(Problems, ASwitchedOffDeviceIsNone) {
    auto snapshot = healthy();
    snapshot.lines[0].devices[0].state = poll::DeviceState::switched_off;
    for (const auto* const name : {"Level", "Speed", "Pump", "Tag"})
        fail(snapshot, name, Reason::switched_off);
    EXPECT_TRUE(problems(snapshot).empty());
}

bool has_late(const std::vector<Problem>& found) {
    return std::ranges::any_of(found, [](const Problem& problem) { return problem.kind == Kind::late; });
}

TEST(Problems, TheWorstComesFirst) {
    auto snapshot = healthy();
    snapshot.lines[0].devices[0].noise = poll::NoiseFinding{.least = 1, .most = 2};
    snapshot.lines[0].requests[0].overrun = true;
    snapshot.lines[0].requests[0].period = 500ms;
    snapshot.lines[0].requests[0].recent_period = 900ms;
    fail(snapshot, "Level", Reason::timeout);
    std::vector<Kind> kinds;
    for (const auto& problem : problems(snapshot)) kinds.push_back(problem.kind);
    EXPECT_EQ(kinds, (std::vector{Kind::unanswered, Kind::late, Kind::noise}))
        << "by severity, causes before effects";
    expect_contains(text_of(snapshot), "polled every 900 ms instead of 500 ms");
    const auto advice = [&] {
        const auto found = problems(snapshot);
        return std::ranges::find(found, Kind::late, &Problem::kind)->advice;
    };
    expect_contains(advice(), "higher bit rate");
    snapshot.lines[0].devices[0].counters.timeouts = 200;
    expect_contains(advice(), "waits for responses of Котёл");
    snapshot.lines[0].devices[0].counters.timeouts = 0;
    snapshot.lines[0].devices[0].counters.link_lost = 200;
    expect_contains(advice(), "lost during requests to Котёл");
    snapshot.lines[0].devices[0].counters.link_lost = 0;
    auto& counters = snapshot.lines[0].requests[0].counters;
    counters.sent = 100;
    counters.exceptions_by_code[6] = 30;
    expect_contains(advice(), "busy");
    counters.exceptions_by_code[6] = 0;
    snapshot.lines[0].requests[0].recent_period = {};
    EXPECT_FALSE(has_late(problems(snapshot))) << "it was not sent lately";
    for (const Duration kept : {Duration(499ms), Duration(500ms), Duration(525ms)}) {
        snapshot.lines[0].requests[0].recent_period = kept;
        EXPECT_FALSE(has_late(problems(snapshot))) << "it keeps the period: " << kept.count();
    }
    snapshot.lines[0].requests[0].recent_period = 900ms;
    snapshot.lines[0].up = false;
    EXPECT_FALSE(has_late(problems(snapshot))) << "of a line that is down";
}

TEST(Problems, TextsAreCompleteInEachLanguage) {
    auto snapshot = healthy();
    snapshot.lines[0].requests[0].overrun = true;
    snapshot.lines[0].requests[0].recent_period = 900ms;
    for (const auto* const name : {"Level", "Speed", "Pump", "Tag"}) fail(snapshot, name, Reason::stale);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = status_json(texts, snapshot, "");
        const auto text = problems_text(texts, *json.find("problems"));
        expect_complete(text);
        expect_contains(text, "Tag");
        expect_contains(problems_text(texts, *json.find("problems"), 1),
                        texts("problem.more", {{"count", "1"}}));
    }
}

}  // namespace problems_test
}  // namespace takt::report
