#include "reads/split.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::poll {

void SplitValue::add_part(std::size_t request, std::size_t first, std::size_t count) {
    TAKT_ASSERT(first + count <= registers_.size());
    parts_.push_back({request, first, count});
}

const SplitValue::Part* SplitValue::part_of(std::size_t request) const {
    const auto found = std::find_if(parts_.begin(), parts_.end(),
                                    [request](const Part& part) { return part.request == request; });
    return found == parts_.end() ? nullptr : &*found;
}

void SplitValue::take(std::size_t request, std::optional<std::int64_t> round,
                      std::span<const std::uint16_t> registers, Instant sampled_at) {
    const Part* const known = part_of(request);
    TAKT_ASSERT(known && registers.size() == known->count);
    Part& part = parts_[static_cast<std::size_t>(known - parts_.data())];
    if (round != round_ || (!round && part.there)) forget();
    round_ = round;
    part.there = true;
    sampled_at_ = std::min(sampled_at_, sampled_at);
    std::copy(registers.begin(), registers.end(),
              registers_.begin() + static_cast<std::ptrdiff_t>(part.first));
}

// Requests may cover a register twice: the value is whole when the parts cover each register.
std::optional<std::span<const std::uint16_t>> SplitValue::whole() const {
    std::size_t reached = 0;
    for (bool grown = true; grown && reached < registers_.size();) {
        grown = false;
        for (const Part& part : parts_) {
            if (!part.there || part.first > reached || part.first + part.count <= reached) continue;
            reached = part.first + part.count;
            grown = true;
        }
    }
    if (reached < registers_.size()) return std::nullopt;
    return std::span<const std::uint16_t>(registers_);
}

void SplitValue::forget() {
    for (Part& part : parts_) part.there = false;
    round_.reset();
    sampled_at_ = kNever;
}

void SplitValues::add_part(std::size_t variable, std::size_t registers, std::size_t request,
                           std::size_t first, std::size_t count) {
    if (!has(variable)) {
        if (variable >= index_.size()) index_.resize(variable + 1, kNone);
        index_[variable] = static_cast<std::uint32_t>(values_.size());
        values_.emplace_back(registers);
    }
    values_[index_[variable]].add_part(request, first, count);
}

}  // namespace takt::poll
