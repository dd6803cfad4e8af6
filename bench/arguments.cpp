#include "arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "working_folder.hpp"

namespace takt::bench {

Arguments::Arguments(int count, char** arguments, std::initializer_list<ValueOption> allowed) {
    for (int i = 1; i < count; ++i) {
        const std::string_view name = arguments[i];
        if (name == "--json") {
            json_ = true;
            continue;
        }
        if (std::ranges::find(allowed, name, &ValueOption::name) == allowed.end())
            throw std::invalid_argument(fmt::format("unknown option `{}`", name));
        if (++i == count) throw std::invalid_argument(fmt::format("`{}` has no value", name));
        values_[name] = arguments[i];
    }
}

std::string Arguments::text(std::string_view name, std::string otherwise) const {
    const auto found = values_.find(name);
    return found == values_.end() ? std::move(otherwise) : std::string(found->second);
}

std::uint64_t Arguments::clamped(std::string_view name, std::uint64_t otherwise, std::uint64_t least,
                                 std::uint64_t most) const {
    const auto found = values_.find(name);
    if (found == values_.end()) return otherwise;
    const std::string_view text = found->second;
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        throw std::invalid_argument(
            fmt::format("{}: `{}` is not a number, allowed: {}..{}", name, text, least, most));
    return std::clamp(value, least, most);
}

int run_benchmark(int count, char** arguments, std::initializer_list<ValueOption> allowed,
                  const std::function<int(const Arguments&)>& run) {
    const auto program = std::filesystem::path(arguments[0]).filename().string();
    try {
        const Arguments parsed(count, arguments, allowed);
        catch_signals();
        return run(parsed);
    } catch (const std::invalid_argument& wrong) {
        std::string usage = "usage: " + program;
        for (const auto& option : allowed) usage += fmt::format(" [{} {}]", option.name, option.value);
        fmt::print(stderr, "{}: {}\n{} [--json]\n", program, wrong.what(), usage);
        return 2;
    } catch (const std::exception& failure) {
        fmt::print(stderr, "{}: {}\n", program, failure.what());
        return 1;
    }
}

}  // namespace takt::bench
