// Why a running project is not in order: the reasons behind its health, and what can be done about them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/time.hpp"
#include "takt/file/json.hpp"
#include "takt/host/snapshot.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::report {

struct Problem {
    enum class Severity : std::uint8_t {
        error,    ///< a line, a device or an output fails
        warning,  ///< values are missing, late or in doubt
        note,     ///< nothing is wrong now
    };
    /// In the order of the list.
    enum class Kind : std::uint8_t {
        link,        ///< the port is not open, the connection not made
        silent,      ///< the device does not answer
        damaged,     ///< its responses have wrong checksums
        unfitting,   ///< its responses are not those to the requests
        refused,     ///< it answers a request with an exception
        output,      ///< an output loses or holds back samples
        values,      ///< values are not good for another reason
        shifted,     ///< responses may have been those to earlier requests
        repeated,    ///< it answers requests more than once
        unanswered,  ///< some requests were not answered
        slow,        ///< a setting is too short for the device
        noise,
        late,  ///< a request is not sent as often as it should be: mostly because of those before
    };
    Severity severity = Severity::warning;
    Kind kind = Kind::values;
    std::string line = {};  ///< names; empty: none
    std::string device = {};
    std::string output = {};
    std::string request = {};                 ///< "0x03 500..501"
    std::vector<std::string> variables = {};  ///< that are not good
    std::optional<std::uint64_t> count = {};  ///< how often it happened
    std::optional<std::uint64_t> of = {};     ///< among so many requests
    std::optional<Duration> since = {};       ///< before the snapshot
    std::string text = {};                    ///< what is wrong: a sentence without its stop
    std::string tried = {};                   ///< what the program does about it; empty: nothing
    std::string advice = {};                  ///< the next step; empty: unknown
};
std::string_view name(Problem::Severity severity);
std::string_view name(Problem::Kind kind);

/// Of lines, devices, requests and values; the worst first.
/// @param snapshot  with values and statistics
[[nodiscard]] std::vector<Problem> find_problems(const Texts& texts, const host::Snapshot& snapshot);

/// "failed": devices are polled and none answers; "degraded": there is an error or a warning; "ok".
[[nodiscard]] std::string_view health_word(const host::Snapshot& snapshot,
                                           const std::vector<Problem>& problems);

/// docs/commands/ctl.md, "JSON".
[[nodiscard]] file::Json problem_json(const Problem& problem);

/// One line: what is wrong, how often, since when, and which values are not good.
/// @param problem  of problem_json()
[[nodiscard]] std::string problem_line(const Texts& texts, const file::Json& problem);

/// The lines of a list of problem_json(), each with what was tried and the next step.
/// @param most  problems; the others are counted
[[nodiscard]] std::string problems_text(const Texts& texts, const file::Json& problems,
                                        std::size_t most = SIZE_MAX);

}  // namespace takt::report
