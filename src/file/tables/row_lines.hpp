// The lines of a table, and their connections.
#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/convert.hpp"
#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"

namespace takt::file {

/// Reports settings of a line or device whose rows disagree, each key once.
class Disagreements {
public:
    /// @param reporter  outlives it
    explicit Disagreements(Reporter& reporter) : reporter_(reporter) {}
    /// @param first  the value of an earlier row
    void report(const model::Node& cell, std::string_view key, const std::string& first);

private:
    Reporter& reporter_;
    std::set<std::string, std::less<>> reported_;
};

/// The lines that the rows of a table name, in order of appearance. Rows that name none belong to the first
/// one. A line has the connection of its kTargetColumn; the first one without has that of `surroundings`,
/// and a later one is an error, because two lines cannot share a connection.
class RowLines {
public:
    /// All outlive it.
    RowLines(const Surroundings& surroundings, Reporter& reporter, Disagreements& disagreements);

    /// @returns the index of the line of a row
    std::size_t of(const model::Node& row);

    [[nodiscard]] std::string name(std::size_t line) const;

    /// `Modbus ASCII`: the framing of a serial line. The target of another one has its own.
    void take_protocol(std::size_t line, const model::Node& cell);

    /// The lines with these devices, as a list of a project.
    /// @param devices  one list for each line
    model::Node take(std::vector<model::Node> devices);

    [[nodiscard]] std::size_t count() const { return lines_.size(); }

private:
    struct Line {
        model::Node settings;
        std::string target;  // the cell; empty: none
        std::string protocol;
        bool named = false;
    };

    void take_target(Line& line, const model::Node& cell);

    const Surroundings& surroundings_;
    Reporter& reporter_;
    Disagreements& disagreements_;
    std::vector<Line> lines_;
};

}  // namespace takt::file
