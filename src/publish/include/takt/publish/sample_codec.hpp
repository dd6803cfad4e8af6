// Samples as the payload of a record of the journal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/publish/sample.hpp"

namespace takt::publish {

/// Collects samples for one payload. The series of the samples are in the payload, each once, so that it can
/// be decoded without the project.
class SamplePayload {
public:
    /// @param limit  bytes of the finished payload, at most; at least 1024
    explicit SamplePayload(std::size_t limit);

    /// Adds a sample. `sample.series` is the caller's number of `series`: the same number, the same series.
    /// A text value of more than kLongestTextValue bytes is cut.
    /// @returns false: it would exceed the limit, nothing was changed. An empty payload takes every sample
    ///          whose names have together at most limit - 512 bytes
    [[nodiscard]] bool add(const Series& series, const Sample& sample);

    [[nodiscard]] std::size_t samples() const { return count_; }
    [[nodiscard]] bool empty() const { return count_ == 0; }
    /// Size of the payload that take() would return.
    [[nodiscard]] std::size_t bytes() const;
    [[nodiscard]] std::int64_t newest_wall_ns() const { return newest_; }

    /// Returns the payload and begins another one.
    [[nodiscard]] std::vector<std::uint8_t> take();

private:
    std::size_t limit_;
    std::vector<std::uint8_t> series_;     // encoded
    std::vector<std::uint8_t> body_;       // encoded samples
    std::vector<std::uint32_t> local_of_;  // by the caller's number: number in this payload plus 1
    std::vector<std::uint32_t> used_;      // the caller's numbers, by number in this payload
    Series last_series_;                   // that was added to this payload
    std::vector<std::uint8_t> scratch_;
    std::size_t count_ = 0;
    std::int64_t base_ = 0;  // wall time of the last sample
    std::int64_t newest_ = 0;
};

inline constexpr std::size_t kLongestTextValue = 256;

/// @returns malformed: not a payload of SamplePayload, or one of a later version
[[nodiscard]] Result<SampleBatch> decode_samples(Bytes payload);

}  // namespace takt::publish
