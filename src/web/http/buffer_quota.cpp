#include "http/buffer_quota.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"

namespace takt::web {

BufferQuota::Verdict BufferQuota::change(std::string_view visitor, std::ptrdiff_t change) {
    const auto found = own_.find(visitor);
    const std::size_t before = found == own_.end() ? 0 : found->second;
    TAKT_ASSERT(change >= 0 || before >= static_cast<std::size_t>(-change));
    const std::size_t after = before + static_cast<std::size_t>(change);
    held_ += std::min(after, visitor_) - std::min(before, visitor_);
    if (after == 0 && found != own_.end()) own_.erase(found);
    if (after != 0 && found == own_.end()) own_.emplace(visitor, after);
    if (after != 0 && found != own_.end()) found->second = after;
    if (after > visitor_) return Verdict::visitor_full;
    return held_ > all_ ? Verdict::full : Verdict::admitted;
}

}  // namespace takt::web
