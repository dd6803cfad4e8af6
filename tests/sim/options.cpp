#include "options.hpp"

#include <algorithm>
#include <cmath>

namespace takt::simtest {
namespace {

using seeds::parse_number;

std::optional<Duration> parse_seconds(std::string_view text) {
    double seconds = 0;
    if (!text.ends_with('s') || !parse_number(text.substr(0, text.size() - 1), seconds) || !(seconds > 0) ||
        seconds > 1e6)
        return std::nullopt;
    return Duration(std::llround(seconds * 1e9));
}

/// KIND=RATE: of a million exchanges, or for faults by the clock their mean distance in seconds.
std::optional<std::string> parse_fault(std::string_view text, sim::FaultRates& rates) {
    const auto sign = text.find('=');
    const std::string_view word = text.substr(0, sign);
    const std::string_view value = sign == std::string_view::npos ? "" : text.substr(sign + 1);
    std::string known;
    for (std::size_t i = 0; i < sim::kFaultKinds; ++i) {
        const auto kind = static_cast<sim::FaultKind>(i);
        known += (known.empty() ? "" : ", ") + std::string(name(kind));
        if (name(kind) != word) continue;
        std::uint32_t rate = 0;
        if (is_timed(kind)) {
            const auto mean = parse_seconds(value);
            if (!mean) return "--faults " + std::string(text) + ": a mean distance in seconds, like 30s";
            rates.every(kind, *mean);
        } else if (parse_number(value, rate) && rate <= 1'000'000) {
            rates.set(kind, rate);
        } else {
            return "--faults " + std::string(text) + ": 0..1000000, of a million exchanges";
        }
        return std::nullopt;
    }
    return "--faults " + std::string(text) + ": no such kind; there are " + known;
}

std::optional<std::string> parse_faults(std::string_view text, Options& options) {
    using Kind = FaultChoice::Kind;
    options.faults = text;
    constexpr std::pair<std::string_view, Kind> kWords[] = {
        {"seed", Kind::by_seed}, {"none", Kind::none}, {"few", Kind::few}, {"many", Kind::many}};
    for (const auto& [word, kind] : kWords)
        if (text == word) {
            options.choice.kind = kind;
            return std::nullopt;
        }
    options.choice.kind = Kind::given;
    while (!text.empty()) {
        const auto comma = std::min(text.find(','), text.size());
        if (auto wrong = parse_fault(text.substr(0, comma), options.choice.rates)) return wrong;
        text.remove_prefix(std::min(comma + 1, text.size()));
    }
    return std::nullopt;
}

std::optional<std::string> parse_option(std::string_view key, std::string_view value, Options& options) {
    std::string allowed;
    switch (seeds::parse_value(key, value, options, allowed)) {
        case seeds::Parsed::good: return std::nullopt;
        case seeds::Parsed::wrong: return std::string(key) + " " + std::string(value) + ": " + allowed;
        case seeds::Parsed::unknown: break;
    }
    if (key == "--faults") return parse_faults(value, options);
    if (key != "--project") return "unknown option " + std::string(key) + "; --help shows all";
    options.project = value;
    return std::nullopt;
}

}  // namespace

std::optional<std::string> parse_options(std::span<char*> arguments, Options& options) {
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string_view key = arguments[i];
        bool* const flag = key == "--lenient"         ? &options.lenient
                           : key == "--print-project" ? &options.print_project
                                                      : seeds::flag_of(key, options);
        if (flag) {
            *flag = true;
            continue;
        }
        if (i + 1 == arguments.size()) return std::string(key) + ": its value is missing; --help shows all";
        if (auto wrong = parse_option(key, arguments[++i], options)) return wrong;
    }
    return std::nullopt;
}

std::string usage() {
    return R"(usage: takt-sim [--seeds A..B] [--minutes M] [--jobs N] [--project FILE]
                [--faults none|few|many|KIND=RATE,...] [--lenient] [--resume FILE] [--json]
                [--trace] [--print-project]

Runs the real master on simulated lines with faults and users, all from the seed, and judges what happens.
  --seeds     which runs, each with a random project of its own (default 1)
  --minutes   of virtual time for each (default 10)
  --jobs      processes at a time (default 1)
  --project   this project in every run
  --faults    RATE: of a million exchanges, or for faults by the clock their mean distance (30s)
  --lenient   no copies and no old answers, and late ones come while the master waits for them
  --resume    stores the results in FILE, and continues from there
  --json      one object a line
  --trace     every frame and fault on stderr
  --print-project  only prints the random project of the first seed
Exit codes: 0 all invariants hold, 1 one does not, or a kind of fault or recovery was never seen, 2 bad usage
or project.
)";
}

std::string replay(const Options& options, std::uint64_t seed) {
    std::string made = "takt-sim " + seeds::replay_arguments(options, seed);
    if (options.faults != "seed") made += " --faults " + options.faults;
    if (options.lenient) made += " --lenient";
    if (!options.project.empty()) made += " --project " + options.project;
    return made;
}

}  // namespace takt::simtest
