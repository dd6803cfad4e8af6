// Values longer than a request: read in parts, never shown torn.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace takt::poll {

/// The registers of one value, put together from the parts that several requests read.
class SplitValue {
public:
    /// @param registers  of the whole value
    explicit SplitValue(std::size_t registers) : registers_(registers) {}

    /// What the request reads of it: `count` registers from `first` on.
    void add_part(std::size_t request, std::size_t first, std::size_t count);

    /// A part was read. Parts of other rounds are forgotten.
    /// @param round  parts with the same number belong together; nothing: parts that are read in turn
    /// @param registers  of this part, as many as it has
    void take(std::size_t request, std::optional<std::int64_t> round,
              std::span<const std::uint16_t> registers);

    /// The whole value, as soon as all its parts are there; until the next call of take() or forget().
    [[nodiscard]] std::optional<std::span<const std::uint16_t>> whole() const;

    void forget();

    struct Part {
        std::size_t request = 0;
        std::size_t first = 0;
        std::size_t count = 0;
        bool there = false;
    };
    /// What that request reads of it; nullptr: nothing.
    [[nodiscard]] const Part* part_of(std::size_t request) const;

private:
    std::vector<Part> parts_;
    std::vector<std::uint16_t> registers_;
    std::optional<std::int64_t> round_;
};

}  // namespace takt::poll
