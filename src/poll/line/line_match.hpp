// Another project is applied: what of a line is the same as before.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "line/tables.hpp"

namespace takt::poll {

/// Which devices, variables and requests of the line before a line continues. Devices are the same if name,
/// address and settings of their polling are; variables if their name, type and place on the wire are, on the
/// same device; requests if they read or write the same items of the same device in the same way.
class LineMatch {
public:
    LineMatch(const LineTables& now, const LineTables& old);

    /// Their indices in the line before.
    [[nodiscard]] std::optional<std::size_t> device(std::size_t now) const { return devices_[now]; }
    [[nodiscard]] std::optional<std::size_t> variable(std::size_t now) const { return variables_[now]; }
    /// The request that reads what this one reads.
    [[nodiscard]] std::optional<std::size_t> read(std::size_t now) const;
    /// Whether a request of the line before writes for the same cause and in the same way.
    [[nodiscard]] bool same_write(std::size_t now, std::size_t old) const;

    /// Whether these variables are those of the line before, in their order.
    [[nodiscard]] bool same_variables(std::span<const std::size_t> now,
                                      std::span<const std::size_t> old) const;
    /// Whether one of these variables is one of the line before.
    [[nodiscard]] bool share_variables(std::span<const std::size_t> now,
                                       std::span<const std::size_t> old) const;

private:
    LineTables now_;
    LineTables old_;
    std::vector<std::optional<std::size_t>> devices_;
    std::vector<std::optional<std::size_t>> variables_;
};

}  // namespace takt::poll
