// Values longer than a request: read in parts, published as a whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::poll {

/// The registers of one value, assembled from the parts that several requests read.
class SplitValue {
public:
    /// @param registers  of the whole value
    explicit SplitValue(std::size_t registers) : registers_(registers) {}

    /// The request reads `count` registers of it from `first` on.
    void add_part(std::size_t request, std::size_t first, std::size_t count);

    /// A part was read. Parts of other rounds are dropped.
    /// @param round  parts with the same number belong together; nothing: parts that are read one after the
    ///               other
    /// @param registers  of this part, as many as it has
    /// @param sampled_at  the begin of its read
    void take(std::size_t request, std::optional<std::int64_t> round,
              std::span<const std::uint16_t> registers, Instant sampled_at);
    /// The earliest begin of the reads of its parts.
    [[nodiscard]] Instant sampled_at() const { return sampled_at_; }

    /// The whole value, once all its parts were read; valid until the next take() or forget().
    [[nodiscard]] std::optional<std::span<const std::uint16_t>> whole() const;

    void forget();

    struct Part {
        std::size_t request = 0;
        std::size_t first = 0;
        std::size_t count = 0;
        bool there = false;
    };
    /// The part that the request reads; nullptr: none.
    [[nodiscard]] const Part* part_of(std::size_t request) const;

private:
    std::vector<Part> parts_;
    std::vector<std::uint16_t> registers_;
    std::optional<std::int64_t> round_;
    Instant sampled_at_ = kNever;
};

/// The values of a line that are read in parts. Variables are numbers of the caller.
class SplitValues {
public:
    /// The request reads `count` registers of the variable from `first` on.
    /// @param registers  of the whole value
    void add_part(std::size_t variable, std::size_t registers, std::size_t request, std::size_t first,
                  std::size_t count);
    /// nullptr: it is read as a whole.
    [[nodiscard]] SplitValue* find(std::size_t variable) {
        return has(variable) ? &values_[index_[variable]] : nullptr;
    }
    [[nodiscard]] bool has(std::size_t variable) const {
        return variable < index_.size() && index_[variable] != kNone;
    }
    /// Parts that were read are dropped.
    void forget(std::size_t variable) {
        if (auto* const value = find(variable)) value->forget();
    }
    /// No value is read in parts any more.
    void clear() {
        values_.clear();
        index_.clear();
    }

private:
    static constexpr std::uint32_t kNone = UINT32_MAX;
    std::vector<SplitValue> values_;
    std::vector<std::uint32_t> index_;  // by variable; shorter if the last ones are read as a whole
};

}  // namespace takt::poll
