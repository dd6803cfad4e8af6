// Text is judged at its end bytes. A binary answer is judged when it is complete; after a mismatch only its
// first byte is dropped, because an answer may begin behind it.
#include "takt/endpoint/answer_scanner.hpp"

#include <algorithm>
#include <utility>

namespace takt::endpoint {

void AnswerScanner::expect(const model::AnswerFormat* format) {
    format_ = format;
    buffer_.clear();
}

std::uint64_t AnswerScanner::take_strange() {
    return std::exchange(strange_, 0);
}

std::optional<Measurements> AnswerScanner::take(std::uint8_t byte) {
    if (format_ == nullptr) return std::nullopt;
    buffer_.push_back(byte);
    auto found = format_->until.empty() ? take_binary() : take_text();
    if (found || buffer_.size() >= kMostAnswer) {
        if (!found) ++strange_;
        buffer_.clear();
    }
    return found;
}

std::optional<Measurements> AnswerScanner::take_text() {
    const auto& until = format_->until;
    const auto ends = [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); };
    if (buffer_.size() < until.size() ||
        !std::equal(buffer_.end() - static_cast<std::ptrdiff_t>(until.size()), buffer_.end(), until.begin(),
                    ends))
        return std::nullopt;
    auto found = read_answer(*format_, buffer_);
    if (found) return found;
    ++strange_;
    buffer_.clear();
    return std::nullopt;
}

std::optional<Measurements> AnswerScanner::take_binary() {
    while (true) {
        const auto found = find_answer(*format_, buffer_);
        buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(found.skip));
        if (found.answer == 0) return std::nullopt;
        if (auto measured = read_answer(*format_, Bytes(buffer_).first(found.answer))) return measured;
        ++strange_;
        buffer_.erase(buffer_.begin());
    }
}

}  // namespace takt::endpoint
