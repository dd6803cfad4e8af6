// The golden sets of requests as projects: each request a device of its own.
#pragma once

#include <cstring>

#include "builder.hpp"
#include "golden_responses.hpp"

namespace takt::plan::test {

inline bool mentions(const golden::Row& row, const char* word) {
    return std::strstr(row.name, word) != nullptr;
}

inline int registers_of(const golden::Row& row) {
    return mentions(row, "x20")   ? 20 * static_cast<int>(row.frames.size())
           : mentions(row, "x60") ? 60
           : mentions(row, "x10") ? 10
           : mentions(row, "x2")  ? 2
                                  : 1;
}

inline Item item_of(const golden::Row& golden) {
    const auto period = std::chrono::microseconds(golden.period);
    if (!mentions(golden, "FC6")) return int16(0).read(mentions(golden, "FC4") ? 4 : 3).every(period);
    Item written = int16(0).write(6).on_change().every(0ms);
    written.admission = model::RateLimit{.min_interval = period};
    written.deadline = std::chrono::microseconds(golden.deadline);
    return written;
}

/// The response timeout with which a transaction is given up 500 ms after its request.
inline Duration half_a_second_in_all(const model::Line& line, const golden::Row& golden) {
    const int characters = mentions(golden, "FC6") ? 8 : 5 + 2 * registers_of(golden);
    return 500ms - 2ms - wire::transmission_time(line.format, static_cast<std::size_t>(characters));
}

inline model::Project project_of(const golden::Set& set) {
    auto made = project({}, {});
    model::Line& line = made.lines.front();
    line.format = {set.baud, 8, wire::Parity::even, 1};
    line.devices.clear();
    made.derive_timeouts = std::strstr(set.name, "derived") != nullptr;
    made.backoff.first = 10s;
    for (const auto& golden : set.rows) {
        const Settings settings{.registers_per_request =
                                    golden.frames.size() > 1 ? std::uint16_t{20} : std::uint16_t{60}};
        const int address = static_cast<int>(line.devices.size()) + 1;
        line.devices.push_back(device(address, settings, row(registers_of(golden), item_of(golden))));
        line.devices.back().turnaround = 5ms;
        line.devices.back().attempts = 2;
        line.devices.back().response_timeout = half_a_second_in_all(line, golden);
    }
    return made;
}

}  // namespace takt::plan::test
