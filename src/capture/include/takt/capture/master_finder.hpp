// Which polls of a line belong to the same master. Frames do not name the master.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/base/time.hpp"

namespace takt::capture {

/// Polls of one master keep step: one follows another after a time that hardly changes from cycle to cycle.
/// The times between polls of two masters are spread evenly over the period.
///
/// For each pair of polls the time from the last one of the first to the second is counted in kBins parts of
/// the period of the first. The pair keeps step if two neighbouring parts hold three quarters of at least
/// kEnough samples. A request that is sent while the response to another one is due shows two masters, even
/// where their polls keep step, unless it happens in most cycles. Two masters with equal periods that never
/// overlap look like one.
///
/// Allocates at construction and in groups(). One owner, one thread.
class MasterFinder {
public:
    static constexpr std::size_t kMost = 64;  ///< polls that are followed
    static constexpr std::size_t kBins = 16;
    static constexpr std::uint32_t kEnough = 8;
    static constexpr std::uint16_t kConflicts = 2;  ///< overlaps that separate two polls

    MasterFinder();

    /// @returns whether another poll can be added
    [[nodiscard]] bool full() const { return polls_.size() == kMost; }
    /// @returns the number of the new poll. Not full()
    [[nodiscard]] std::size_t add();

    /// @param period  as known by now; zero, or more than a day: unknown
    void on_request(Instant t, std::size_t poll, Duration period);
    /// A request of `later` was sent while the response to one of `earlier` was due.
    void on_overlap(std::size_t earlier, std::size_t later);

    /// The polls with enough samples, grouped by master.
    [[nodiscard]] std::vector<std::vector<std::size_t>> groups() const;

private:
    struct FollowedPoll {
        std::uint64_t requests = 0;
        Instant last;
        Duration period{};
    };
    struct Pair {
        std::array<std::uint32_t, kBins> bins{};
        std::uint16_t overlaps = 0;
    };

    [[nodiscard]] Pair& pair(std::size_t first, std::size_t second) { return pairs_[first * kMost + second]; }
    [[nodiscard]] const Pair& pair(std::size_t first, std::size_t second) const {
        return pairs_[first * kMost + second];
    }
    [[nodiscard]] static std::uint64_t samples(const Pair& pair);
    [[nodiscard]] static double coherence(const Pair& pair);
    [[nodiscard]] bool contradict(std::size_t first, std::size_t second) const;
    [[nodiscard]] bool conflict(const std::vector<std::size_t>& a, const std::vector<std::size_t>& b) const;

    std::vector<FollowedPoll> polls_;
    std::vector<Pair> pairs_;
};

}  // namespace takt::capture
