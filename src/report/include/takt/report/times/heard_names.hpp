// The names of a project for what is heard on one of its lines.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "takt/capture/heard_exchange.hpp"
#include "takt/model/project.hpp"

namespace takt::report {

/// A variable in an exchange, and its value as text with its unit.
struct NamedValue {
    const model::Variable* variable = nullptr;
    std::string text;
};

/// Finds devices by their unit and variables by their items. Refers to the project, which must outlive it.
class HeardNames {
public:
    /// No names.
    HeardNames() = default;
    /// The names of the line of that name, else of that port, else of the first serial line, else of the
    /// first other one, else none. Lines that carry frames of Modbus TCP do not count.
    HeardNames(const model::Project& project, const std::string& port, const std::string& name = {});

    /// There is a line to take names from.
    [[nodiscard]] bool has_line() const { return line_ != nullptr; }
    /// nullptr: unknown.
    [[nodiscard]] const model::Device* device(std::uint8_t unit) const;
    /// The variables whose items an exchange reads or writes, in the order of the project, at most kMost. An
    /// exchange without a normal response has none.
    [[nodiscard]] std::vector<NamedValue> values(const capture::Exchange& exchange) const;
    static constexpr std::size_t kMost = 125;

private:
    const model::Line* line_ = nullptr;
};

}  // namespace takt::report
