// Finds one expected answer in a stream of bytes.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "takt/endpoint/answer.hpp"

namespace takt::endpoint {

/// Receives bytes one by one until they end with an answer of its format.
///
/// A line of text that does not match, and a binary answer with another beginning or checksum, is skipped and
/// counted. At most kMostAnswer bytes are buffered. One owner, one thread.
class AnswerScanner {
public:
    /// Discards all bytes and waits for an answer of that format, which outlives the use. nullptr: for none.
    void expect(const model::AnswerFormat* format);

    /// Discards the bytes of an incomplete answer.
    void clear() { buffer_.clear(); }

    /// @returns the measurements if this byte completes an answer
    std::optional<Measurements> take(std::uint8_t byte);

    /// Lines and floods that did not match, since the last call.
    [[nodiscard]] std::uint64_t take_strange();

private:
    std::optional<Measurements> take_text();
    std::optional<Measurements> take_binary();

    const model::AnswerFormat* format_ = nullptr;
    std::vector<std::uint8_t> buffer_;
    std::uint64_t strange_ = 0;
};

}  // namespace takt::endpoint
