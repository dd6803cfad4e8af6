// The command line and the main function of a benchmark.
#pragma once

#include <concepts>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>

namespace takt::bench {

/// An option with a value. `value` is its word in the usage line, as in "N".
struct ValueOption {
    std::string_view name;
    std::string_view value;
};

/// The options that were given: `--json`, and pairs of name and value.
class Arguments {
public:
    /// Throws std::invalid_argument: an option that is not allowed, or one without a value.
    Arguments(int count, char** arguments, std::initializer_list<ValueOption> allowed);

    [[nodiscard]] bool json() const { return json_; }
    [[nodiscard]] std::string text(std::string_view name, std::string otherwise) const;
    /// A number beyond the limits is replaced by the nearest limit. Throws std::invalid_argument for a text
    /// that is not a decimal number.
    template <std::integral T>
    [[nodiscard]] T number(std::string_view name, T otherwise, std::type_identity_t<T> least,
                           std::type_identity_t<T> most) const {
        const auto wide = [](T value) { return static_cast<std::uint64_t>(value); };
        return static_cast<T>(clamped(name, wide(otherwise), wide(least), wide(most)));
    }

private:
    [[nodiscard]] std::uint64_t clamped(std::string_view name, std::uint64_t otherwise, std::uint64_t least,
                                        std::uint64_t most) const;

    bool json_ = false;
    std::map<std::string_view, std::string_view> values_;
};

/// Catches signals, parses the command line and calls `run`.
/// @returns the exit status: that of `run`; 1 if it throws, 2 for a wrong option. Both print an error
int run_benchmark(int count, char** arguments, std::initializer_list<ValueOption> allowed,
                  const std::function<int(const Arguments&)>& run);

}  // namespace takt::bench
