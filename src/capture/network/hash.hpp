// Hashes of the keys of hash tables.
#pragma once

#include <cstdint>
#include <cstring>

#include "takt/base/network.hpp"

namespace takt::capture {

inline constexpr std::uint64_t kFirstHash = 0x9E3779B97F4A7C15U;

/// `hash` and another part of the key: one step of the finalizer of SplitMix64.
[[nodiscard]] constexpr std::uint64_t mixed(std::uint64_t hash, std::uint64_t value) {
    hash = (hash ^ value) * 0xBF58476D1CE4E5B9U;
    return hash ^ hash >> 31U;
}

[[nodiscard]] inline std::uint64_t mixed(std::uint64_t hash, const IpAddress& address) {
    std::uint64_t words[2];
    std::memcpy(words, address.bytes.data(), sizeof words);
    return mixed(mixed(hash, words[0]), words[1]);
}

}  // namespace takt::capture
