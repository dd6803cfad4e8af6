// The table of the figures, or one JSON object.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>

#include "servers.hpp"

namespace bench {

/// One figure of each server, beside each other.
struct Row {
    std::string name;
    std::string unit;
    std::array<std::optional<double>, kKinds.size()> figures{};
    std::array<std::size_t, kKinds.size()> wrong{};
    std::array<std::size_t, kKinds.size()> unanswered{};

    void set(Kind kind, double figure) { figures[static_cast<std::size_t>(kind)] = figure; }
    /// The figure of takt in units of another's.
    [[nodiscard]] std::optional<double> ratio(Kind other) const;
};

class Report {
public:
    explicit Report(bool json);
    void add(const Row& row);
    /// @returns the exit code: 1 when a good client of takt got a wrong answer, or none
    int end();

private:
    bool json_;
    bool first_ = true;
    bool failed_ = false;
};

}  // namespace bench
