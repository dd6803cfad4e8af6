#include "outputs/output_log.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace takt::publish {
namespace output_log_test {

struct Lines {
    std::vector<std::string> lines;

    [[nodiscard]] Log log() { return {"publish", {.context = this, .write_message = write}}; }

private:
    static void write(void* context, LogLevel level, std::string_view, std::string_view code,
                      std::span<const LogArgument> arguments) {
        std::string line = std::to_string(static_cast<int>(level)) + " " + std::string(code);
        for (const auto& argument : arguments)
            line += " " +
                    std::string(argument.error != nullptr ? takt::name(argument.error->code) : argument.text);
        static_cast<Lines*>(context)->lines.push_back(line);
    }
};

TEST(OutputLog, HasChangesAndNoAttempts) {
    Lines lines;
    OutputLog log(lines.log());
    OutputStatus status{.name = "cloud", .destination = "mqtt://b:1883"};
    const auto note = [&](OutputState state, const std::string& failure) {
        status.state = state;
        status.failure = failure;
        log.note(status);
    };
    for (int i = 0; i < 3; ++i) {
        note(OutputState::connecting, i == 0 ? "" : "refused");
        note(OutputState::waiting, "refused");
    }
    note(OutputState::connecting, "refused");
    note(OutputState::delivering, "");
    note(OutputState::delivering, "");
    note(OutputState::waiting, "lost");
    note(OutputState::ended, "lost");
    EXPECT_EQ(lines.lines,
              (std::vector<std::string>{"3 log.output.failed cloud mqtt://b:1883 refused app.output.waiting",
                                        "2 log.output.state cloud mqtt://b:1883  app.output.delivering",
                                        "3 log.output.failed cloud mqtt://b:1883 lost app.output.waiting"}));
}

TEST(OutputLog, HasTheWindowOfAnOutputThatFallsBehind) {
    Lines lines;
    OutputLog log(lines.log());
    OutputStatus status{.name = "cloud", .state = OutputState::falls_behind, .destination = "mqtt://b:1883"};
    status.mqtt = MqttStatus{.window = 20, .round_trip = std::chrono::milliseconds(100)};
    for (status.behind_per_s = 640; status.behind_per_s < 643; ++status.behind_per_s) log.note(status);
    EXPECT_EQ(lines.lines,
              (std::vector<std::string>{"3 log.output.falls_behind cloud mqtt://b:1883 640 20 100"}));
}

TEST(OutputLog, HasSamplesThatAreTooLargeOnce) {
    Lines lines;
    OutputLog log(lines.log());
    OutputStatus status{.name = "cloud", .destination = "mqtt://b:1883"};
    status.mqtt = MqttStatus{.maximum_packet = 512};
    log.note(status);
    for (status.too_large = 1; status.too_large < 4; ++status.too_large) log.note(status);
    EXPECT_EQ(lines.lines, (std::vector<std::string>{"4 log.output.too_large cloud mqtt://b:1883 512"}));
}

TEST(OutputLog, HasReceivedMessagesThatAreTooLargeWhenTheirNumberDoubles) {
    Lines lines;
    OutputLog log(lines.log());
    OutputStatus status{.name = "cloud", .destination = "mqtt://b:1883"};
    status.mqtt = MqttStatus{.last_oversized = {.topic = "cmd", .bytes = 70'000}};
    for (int i = 0; i < 5; ++i) {
        log.note(status);
        log.note(status);
        ++status.mqtt->counters.oversized;
    }
    const std::string line = "3 log.output.oversized cloud mqtt://b:1883 cmd 70000 12288 ";
    EXPECT_EQ(lines.lines, (std::vector<std::string>{line + "1", line + "2", line + "4"}));
}

TEST(OutputLog, HasAnErrorOfTheJournalOnce) {
    Lines lines;
    OutputLog log(lines.log());
    OutputStatus status{.name = "cloud"};
    for (const auto* file : {"segment-1", "segment-2"}) {
        status.journal_failure = Error{Code::io_failed, file, {}};
        log.note(status);
    }
    status.journal_failure.reset();
    log.note(status);
    log.note(status);
    EXPECT_EQ(lines.lines, (std::vector<std::string>{"4 log.output.journal_failed cloud io_failed",
                                                     "2 log.output.journal_works cloud"}));
}

}  // namespace output_log_test
}  // namespace takt::publish
