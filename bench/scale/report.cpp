#include "report.hpp"

#include <fmt/format.h>

namespace takt::bench {
namespace {

double ms(Duration duration) {
    return static_cast<double>(duration.count()) / 1e6;
}

}  // namespace

void print(std::size_t devices, const ScaleMeasured& m) {
    fmt::print("{} devices, one connection and one request a second each, for {:.0f} s\n", devices, m.time_s);
    fmt::print("connected in {:.2f} s; all reset at once: again in {:.2f} s\n", m.connected_s,
               m.reconnected_s);
    fmt::print("requests {}, answered {}, missed periods {}\n", m.sent, m.answered, m.missed);
    fmt::print("lateness ms: p50 {:.3f}, p99 {:.3f}, max {:.3f}\n", ms(m.lateness.percentile(50)),
               ms(m.lateness.percentile(99)), ms(m.lateness.max()));
    fmt::print("processor: {:.1f} % of one core, {:.1f} us a request\n", m.processor * 100,
               m.processor * m.time_s / static_cast<double>(m.sent) * 1e6);
    fmt::print(
        "memory a device: {:.0f} bytes, {:.0f} of them for the connection; beside it the project's {:.0f} "
        "and "
        "the value's {:.0f}\n",
        m.poller_bytes + m.connection_bytes, m.connection_bytes, m.project_bytes, m.value_bytes);
}

void print(const ProgramMeasured& m) {
    fmt::print(
        "takt run: {:.1f} s, {:.1f} % of one core, start included; requests {}, answered {}, missed {}, "
        "overruns {}; peak {} KiB\n",
        m.seconds, m.processor * 100, m.sent, m.answered, m.missed, m.overruns, m.peak_kib);
}

nlohmann::json to_json(std::size_t devices, const ScaleMeasured& m) {
    return {{"devices", devices},
            {"seconds", m.time_s},
            {"connected_s", m.connected_s},
            {"reconnected_s", m.reconnected_s},
            {"sent", m.sent},
            {"answered", m.answered},
            {"missed", m.missed},
            {"lateness_ms",
             {{"p50", ms(m.lateness.percentile(50))},
              {"p99", ms(m.lateness.percentile(99))},
              {"max", ms(m.lateness.max())}}},
            {"processor", m.processor},
            {"bytes",
             {{"device", m.poller_bytes + m.connection_bytes},
              {"connection", m.connection_bytes},
              {"project", m.project_bytes},
              {"value", m.value_bytes}}}};
}

nlohmann::json to_json(const ProgramMeasured& m) {
    return {{"seconds", m.seconds},   {"processor", m.processor}, {"sent", m.sent},
            {"answered", m.answered}, {"missed", m.missed},       {"overruns", m.overruns},
            {"peak_kib", m.peak_kib}};
}

}  // namespace takt::bench
