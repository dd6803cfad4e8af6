// What a user sees of an output.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/publish/mqtt_status.hpp"
#include "takt/store/journal.hpp"

namespace takt::publish {

/// Samples of an output. sampled = delivered + waiting + dropped at all times, also over restarts: samples
/// that were not durable at a crash are in none of these counts; the gap `restart` covers them.
struct OutputSamples {
    std::uint64_t sampled = 0;    ///< since the journal was created
    std::uint64_t delivered = 0;  ///< acknowledged by the destination
    std::uint64_t waiting = 0;    ///< can still be delivered, as far as is known
    std::uint64_t dropped = 0;    ///< known to be missing, or rejected by the destination
};

enum class OutputState : std::uint8_t {
    starting,      ///< the journal is being opened
    connecting,    ///< to a broker
    delivering,    ///< the destination takes samples
    falls_behind,  ///< it takes fewer than are sampled
    waiting,       ///< the destination is away; the next attempt follows
    stopped,       ///< a user must act; see the failure
    ended,
    removed,  ///< from the project, with samples that wait; the destination is the directory of the journal
};
std::string_view name(OutputState state);

struct OutputStatus {
    std::string name;
    OutputState state = OutputState::starting;
    OutputSamples samples;
    std::uint64_t gaps = 0;  ///< with missing samples, since the journal was created; delivered or not
    std::optional<std::int64_t> oldest_waiting_ns;  ///< wall time of the oldest durable sample not delivered
    std::string destination;                        ///< the broker in use, or the file
    std::optional<Error> journal_failure;           ///< of its disk; none as soon as it works again
    Duration disk_waits{};           ///< for so long the disk has not answered; zero: less than 2 s
    std::uint64_t behind_per_s = 0;  ///< of falls_behind: samples a second that are not delivered
    std::string remedies;            ///< of MQTT: model::output_remedies()
    std::string failure;             ///< the last one of the destination; empty: none since the last success
    store::JournalStatus journal;
    std::optional<MqttStatus> mqtt;  ///< of an MQTT output
    // Of this run.
    std::uint64_t commands = 0;             ///< received
    std::uint64_t commands_refused = 0;     ///< of them, before the host got them
    std::uint64_t answers_dropped = 0;      ///< too many waited for the broker
    std::uint64_t commands_unrecorded = 0;  ///< without a line in commands.log, which could not be written
    std::uint64_t lost = 0;                 ///< samples that were dropped
    std::uint64_t too_large = 0;            ///< samples that exceed the largest packet of the broker
    std::uint64_t damaged = 0;  ///< of a history: damaged rows that gaps replaced when it was opened
    std::string set_aside;      ///< of a history: where a damaged file was moved; empty: there was none
};

}  // namespace takt::publish
