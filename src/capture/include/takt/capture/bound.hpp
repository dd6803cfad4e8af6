// What a number of trials proves about a probability.
#pragma once

#include <cstdint>

namespace takt::capture {

/// The confidence of upper_bound().
inline constexpr double kConfidence = 0.95;

/// The one-sided upper bound of the probability of an event that was seen `events` times in `trials`
/// independent trials: with 95 % confidence the probability is below it.
///
/// Without an event and from 30 trials on it is 3 / trials (rule of three; Hanley and Lippman-Hand, JAMA 249,
/// 1983), otherwise the exact bound of Clopper and Pearson (Biometrika 26, 1934). 1 without trials, and if
/// every trial has the event.
/// @param events  at most `trials`
[[nodiscard]] double upper_bound(std::uint64_t events, std::uint64_t trials);

/// The greatest number with two significant digits that is at most 1 / probability: "fewer than 1 in N". At
/// least 1.
[[nodiscard]] std::uint64_t one_in(double probability);

}  // namespace takt::capture
