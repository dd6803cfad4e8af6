#include "options.hpp"

namespace takt::gatewaysim {

std::optional<std::string> parse_options(std::span<char*> arguments, Options& options) {
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        const std::string key = arguments[i];
        bool* const flag = key == "--print-project" ? &options.print_project : seeds::flag_of(key, options);
        if (flag) {
            *flag = true;
            continue;
        }
        if (i + 1 == arguments.size()) return key + ": its value is missing; --help shows all";
        const std::string value = arguments[++i];
        std::string allowed;
        switch (seeds::parse_value(key, value, options, allowed)) {
            case seeds::Parsed::good: break;
            case seeds::Parsed::unknown: return "unknown option " + key + "; --help shows all";
            case seeds::Parsed::wrong: return key + " " + value + ": " + allowed;
        }
    }
    return std::nullopt;
}

std::string usage() {
    return R"(usage: takt-gateway-sim [--seeds A..B] [--minutes M] [--jobs N] [--resume FILE] [--json]
                        [--trace] [--print-project]

Runs the real gateway between simulated lines, disk, brokers and clocks, all from the seed, and judges what
happens.
  --seeds     which runs, each with a random project of its own (default 1)
  --minutes   of virtual time for each (default 3); the last 50 s are without troubles
  --jobs      processes at a time (default 1)
  --resume    stores the results in FILE, and continues from there
  --json      one object a line
  --trace     every event on stderr
  --print-project  only prints the random project of the first seed
Exit codes: 0 all rules hold, 1 one does not, or a kind of trouble was never seen, 2 bad usage.
)";
}

}  // namespace takt::gatewaysim
