// What a place served, and whom it did not: told at the end of `takt serve`.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/app/texts.hpp"
#include "takt/line/slave_session.hpp"
#include "takt/serve/counters.hpp"
#include "takt/store/register_file.hpp"

namespace takt::app {

struct ServedPlace {
    std::string where;  ///< "tcp://127.0.0.1:1502", "rtu /dev/ttyUSB0 19200 bit/s"
    serve::Counters counters;
    /// Where it listened.
    struct Listening {
        line::TcpServerCounters connections;
        std::uint64_t bad_headers = 0;
        std::uint64_t frame_deadlines = 0;
        std::uint64_t idle_deadlines = 0;
    };
    std::optional<Listening> listening;
};

/// What was written of a unit's retained registers.
struct RetainedSummary {
    UnitId unit;
    std::string file;
    store::RegisterFile::Counters written;
};

struct ServeSummary {
    std::vector<ServedPlace> places;
    std::vector<RetainedSummary> kept;
};

/// A line a place, and one each for connections that were refused or ended, where there are any.
[[nodiscard]] std::string served_text(const Texts& texts, const ServeSummary& summary);

/// One object (docs/cli.md), with its line end.
/// @param event  its first key, where it is one of a stream of events; empty: it is not
[[nodiscard]] std::string served_json(const ServeSummary& summary, std::string_view event = {});

}  // namespace takt::app
