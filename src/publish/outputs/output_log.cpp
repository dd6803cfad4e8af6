#include "outputs/output_log.hpp"

#include <array>
#include <chrono>
#include <string>

namespace takt::publish {
namespace {

bool is_lasting(OutputState state) {
    return state == OutputState::delivering || state == OutputState::falls_behind ||
           state == OutputState::waiting || state == OutputState::stopped;
}

}  // namespace

void OutputLog::note(const OutputStatus& status) {
    if (!log_.enabled()) return;
    note_destination(status);
    note_journal(status);
    note_unrecorded(status);
    note_too_large(status);
    note_oversized(status);
    note_damaged(status);
    note_set_aside(status);
    note_journal_set_aside(status);
}

void OutputLog::note_destination(const OutputStatus& status) {
    if (!is_lasting(status.state) || (status.state == state_ && status.failure == failure_)) return;
    state_ = status.state;
    failure_ = status.failure;
    if (state_ == OutputState::falls_behind) return note_behind(status);
    const std::string code = "app.output." + std::string(publish::name(status.state));
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "destination", .text = status.destination},
                               LogArgument{.name = "failure", .text = failure_},
                               LogArgument{.name = "state", .text = code, .is_code = true}};
    if (failure_.empty())
        log_.message(LogLevel::info, "log.output.state", arguments);
    else
        log_.message(LogLevel::warning, "log.output.failed", arguments);
}

void OutputLog::note_behind(const OutputStatus& status) {
    const auto mqtt = status.mqtt.value_or(MqttStatus());
    const auto rate = std::to_string(status.behind_per_s);
    const auto window = std::to_string(mqtt.window);
    const auto round_trip = std::to_string(
        std::chrono::round<std::chrono::milliseconds>(mqtt.round_trip.value_or(Duration{})).count());
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "destination", .text = status.destination},
                               LogArgument{.name = "rate", .text = rate},
                               LogArgument{.name = "window", .text = window},
                               LogArgument{.name = "round_trip", .text = round_trip}};
    log_.message(LogLevel::warning, "log.output.falls_behind", arguments);
}

// The first of a series; their number is in the status.
void OutputLog::note_unrecorded(const OutputStatus& status) {
    if (status.commands_unrecorded == unrecorded_) return;
    const bool first = unrecorded_ == 0;
    unrecorded_ = status.commands_unrecorded;
    if (!first) return;
    const LogArgument name{.name = "name", .text = status.name};
    log_.message(LogLevel::error, "log.output.unrecorded", std::array{name});
}

// Once in a run; their number is in the status.
void OutputLog::note_too_large(const OutputStatus& status) {
    if (too_large_noted_ || status.too_large == 0) return;
    too_large_noted_ = true;
    const auto limit = status.mqtt ? status.mqtt->maximum_packet : std::nullopt;
    const auto bytes = limit ? std::to_string(*limit) : std::string("?");
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "destination", .text = status.destination},
                               LogArgument{.name = "bytes", .text = bytes}};
    log_.message(LogLevel::error, "log.output.too_large", arguments);
}

// The first one, and the latest each time their number has doubled: a broker must not fill the log.
void OutputLog::note_oversized(const OutputStatus& status) {
    const std::uint64_t count = status.mqtt ? status.mqtt->counters.oversized : 0;
    if (count == 0 || count < 2 * oversized_) return;
    oversized_ = count;
    const auto total = std::to_string(count);
    const auto bytes = std::to_string(status.mqtt->last_oversized.bytes);
    const auto allowed = std::to_string(kMostReceivedBytes);
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "destination", .text = status.destination},
                               LogArgument{.name = "topic", .text = status.mqtt->last_oversized.topic},
                               LogArgument{.name = "bytes", .text = bytes},
                               LogArgument{.name = "allowed", .text = allowed},
                               LogArgument{.name = "count", .text = total}};
    log_.message(LogLevel::warning, "log.output.oversized", arguments);
}

void OutputLog::note_damaged(const OutputStatus& status) {
    if (status.damaged == damaged_) return;
    damaged_ = status.damaged;
    const auto count = std::to_string(damaged_);
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "destination", .text = status.destination},
                               LogArgument{.name = "count", .text = count}};
    log_.message(LogLevel::error, "log.output.damaged", arguments);
}

void OutputLog::note_set_aside(const OutputStatus& status) {
    if (status.set_aside == set_aside_) return;
    set_aside_ = status.set_aside;
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "file", .text = set_aside_}};
    log_.message(LogLevel::error, "log.output.set_aside", arguments);
}

void OutputLog::note_journal_set_aside(const OutputStatus& status) {
    if (status.journal.set_aside == journal_set_aside_) return;
    journal_set_aside_ = status.journal.set_aside;
    const std::array arguments{LogArgument{.name = "name", .text = status.name},
                               LogArgument{.name = "file", .text = journal_set_aside_}};
    log_.message(LogLevel::error, "log.output.journal_set_aside", arguments);
}

// The error of each further attempt names another file: only the first one is logged.
void OutputLog::note_journal(const OutputStatus& status) {
    if (status.journal_failure.has_value() == journal_failed_) return;
    journal_failed_ = status.journal_failure.has_value();
    const LogArgument name{.name = "name", .text = status.name};
    if (!journal_failed_) return log_.message(LogLevel::info, "log.output.journal_works", std::array{name});
    const std::array arguments{name, LogArgument{.name = "failure", .error = &*status.journal_failure}};
    log_.message(LogLevel::error, "log.output.journal_failed", arguments);
}

}  // namespace takt::publish
