// Text of bounded length, stored in place.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace takt {

/// At most N bytes of text. Longer text is truncated; never allocates. Not zero-terminated.
template <std::size_t N>
class InplaceString {
public:
    constexpr InplaceString() = default;
    constexpr InplaceString(std::string_view text) {
        assign(text);
    }  // NOLINT(*-explicit-*): a string view in place
    constexpr InplaceString(const char* text) { assign(text); }  // NOLINT(*-explicit-*)

    constexpr void assign(std::string_view text) {
        size_ = std::min(text.size(), N);
        std::copy_n(text.begin(), size_, bytes_.begin());
    }

    [[nodiscard]] constexpr std::string_view view() const { return {bytes_.data(), size_}; }
    [[nodiscard]] constexpr std::size_t size() const { return size_; }
    [[nodiscard]] constexpr bool empty() const { return size_ == 0; }
    static constexpr std::size_t capacity() { return N; }

    friend constexpr bool operator==(const InplaceString& a, const InplaceString& b) {
        return a.view() == b.view();
    }

private:
    std::array<char, N> bytes_{};
    std::size_t size_ = 0;
};

}  // namespace takt
