// Bus time of plans for real register maps, compared with the least possible, one request per variable,
// strict adjacency and fixed gaps.
//
//   takt_bench_corpus [--corpus FILE] [--seed N] [--json]
//
// A ratio is the sum of bus time over all maps divided by the sum of the least; `worst` is the greatest ratio
// of a single map. The least is computed in reference.cpp, which shares nothing with the planner and is
// itself compared with trying all partitions of small maps first. Exit code 1: a plan does not cover its map,
// or needs more than promised.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>

#include "check.hpp"

namespace {

using namespace corpus;
using namespace takt;
using namespace std::chrono_literals;

constexpr std::uint32_t kBauds[] = {1200, 9600, 19200, 115200, 921600};
constexpr Duration kTurnarounds[] = {0ms, 5ms, 50ms};
constexpr std::uint32_t kGaps[] = {0, 10, 100, 65536};
constexpr long double kPromisedOnePeriod = 1.01L;
constexpr long double kPromisedSeveral = 1.02L;

struct Arguments {
    std::string corpus;
    std::uint64_t seed = 1;
    bool json = false;
};

/// Sums over all maps, and the worst of them.
struct Tally {
    Seconds least = 0;
    Seconds takt = 0, classic = 0, single = 0, per_class = 0;
    Seconds gaps[std::size(kGaps)] = {};
    long double worst = 0;
    Map worst_map;
    std::size_t mistakes = 0;
    std::string mistake;

    void compare(const Map& map, const Checked& checked, Seconds taken, Seconds best) {
        least += best;
        takt += taken;
        if (taken / best > worst) {
            worst = taken / best;
            worst_map = map;
        }
        if (checked.mistake.empty()) return;
        if (mistakes++ == 0) mistake = map.name + ": " + checked.mistake;
    }
};

std::vector<Value> of_function(const Map& map, int function) {
    std::vector<Value> values;
    std::ranges::copy_if(map.values, std::back_inserter(values),
                         [function](const Value& value) { return value.function == function; });
    return values;
}

plan::LinePlan planned(const model::Project& project, model::Strategy strategy) {
    return plan::make_plan(project, {.strategy = strategy}).lines[0];
}

void add_one_period(Tally& tally, const Map& map, const Bus& bus, bool gaps) {
    const auto project = project_of(map, bus, gaps ? model::Gaps::always : model::Gaps::never);
    Seconds least = 0;
    for (const int function : {1, 2, 3, 4}) {
        const auto values = of_function(map, function);
        if (values.empty()) continue;
        const auto rules = rules_of(map, function, bus, gaps);
        least += total(least_reads(values, rules), rules);
        for (std::size_t g = 0; g < std::size(kGaps); ++g)
            tally.gaps[g] += total(fixed_gap_reads(values, rules, kGaps[g]), rules);
    }
    const auto cost = [&](model::Strategy strategy) {
        return check(map, bus, gaps, project, planned(project, strategy));
    };
    const auto optimal = cost(model::Strategy::optimal);
    tally.compare(map, optimal, optimal.round, least);
    tally.classic += cost(model::Strategy::classic).round;
    tally.single += cost(model::Strategy::single).round;
}

void add_several_periods(Tally& tally, const Map& map, const Bus& bus) {
    const auto project = project_of(map, bus, model::Gaps::always);
    Rates least;
    for (const int function : {1, 2, 3, 4}) {
        const auto values = of_function(map, function);
        if (values.empty()) continue;
        const auto rates = least_rates(values, rules_of(map, function, bus, true));
        least.aligned += rates.aligned;
        least.per_class += rates.per_class;
    }
    const auto cost = [&](model::Strategy strategy) {
        return check(map, bus, true, project, planned(project, strategy));
    };
    const auto optimal = cost(model::Strategy::optimal);
    tally.compare(map, optimal, optimal.rate, least.aligned);
    tally.per_class += least.per_class;
    tally.classic += cost(model::Strategy::classic).rate;
    tally.single += cost(model::Strategy::single).rate;
}

/// The reference against exhaustive search.
bool reference_holds(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto pick = [&random](std::uint32_t least, std::uint32_t most) {
        return std::uniform_int_distribution<std::uint32_t>(least, most)(random);
    };
    for (int round = 0; round < 400; ++round) {
        Rules rules{{wire::Framing::rtu, kBauds[pick(0, 4)], kTurnarounds[pick(0, 2)]},
                    pick(0, 3) == 0 ? 1 : 3,
                    pick(8, 60),
                    pick(0, 1) == 0};
        std::vector<Value> values;
        for (std::uint32_t n = pick(1, 7); n > 0; --n)
            values.push_back({.function = rules.function,
                              .start = pick(0, 90),
                              .items = rules.function == 1 ? 1 : pick(1, 8)});
        const Seconds best = least_cost_by_trying(values, rules);
        if (std::abs(total(least_reads(values, rules), rules) - best) > 1e-12L * best) return false;
    }
    return true;
}

using Shrink = std::function<Map(const Map&)>;

/// Reduces the map: runs of values are removed as long as the ratio stays above `promised`.
template <class Add>
Map shrunk(Map map, long double promised, const Add& add) {
    for (std::size_t length = map.values.size() / 2; length > 0; length /= 2) {
        for (std::size_t at = 0; at + length <= map.values.size() && map.values.size() > length;) {
            Map smaller = map;
            const auto from = smaller.values.begin() + static_cast<std::ptrdiff_t>(at);
            smaller.values.erase(from, from + static_cast<std::ptrdiff_t>(length));
            Tally tally;
            add(tally, smaller);
            if (tally.worst > promised)
                map = std::move(smaller);
            else
                at += length;
        }
    }
    return map;
}

std::string map_text(const Map& map) {
    std::string text =
        map.most_registers ? fmt::format("at most {} registers:", *map.most_registers) : "values";
    for (const auto& value : map.values) {
        text += fmt::format(" fc{} {}+{}", value.function, value.start, value.items);
        if (value.period > 0ms) text += fmt::format(" @{}ms", value.period / 1ms);
    }
    return text;
}

const char* const kPolicies[] = {"gap 0", "gap 10", "gap 100", "whole"};

class Report {
public:
    Report(bool json, std::string maps) : as_json_(json) {
        json_ = {{"maps", maps}, {"tables", nlohmann::json::array()}};
        if (!as_json_) fmt::print("{}\n", maps);
    }

    void begin(const std::string& title, bool several, std::size_t policies) {
        end_table();
        policies_ = policies;
        several_ = several;
        json_["tables"].push_back({{"title", title}, {"rows", nlohmann::json::array()}});
        if (as_json_) return;
        fmt::print("\n{}\n{:>18}  {:>8} {:>8}  {:>8} {:>8}", title, "bus", "takt", "worst", "classic",
                   "single");
        if (several)
            fmt::print(" {:>10}", "per class");
        else
            for (std::size_t g = 0; g < policies; ++g) fmt::print(" {:>8}", kPolicies[g]);
        fmt::print("\n");
    }

    /// @param shrunk  prints a smaller map with nearly the same ratio
    void row(const std::string& bus, const Tally& tally, long double promised, const Shrink& shrunk) {
        const auto ratio = [&](Seconds cost) { return static_cast<double>(cost / tally.least); };
        nlohmann::json row{{"bus", bus},
                           {"takt", ratio(tally.takt)},
                           {"worst", static_cast<double>(tally.worst)},
                           {"worst_map", tally.worst_map.name},
                           {"classic", ratio(tally.classic)},
                           {"single", ratio(tally.single)},
                           {"mistakes", tally.mistakes}};
        if (!as_json_)
            fmt::print("{:>18}  {:8.4f} {:8.4f}  {:8.3f} {:8.3f}", bus, ratio(tally.takt),
                       static_cast<double>(tally.worst), ratio(tally.classic), ratio(tally.single));
        if (several_) {
            row["per_class"] = ratio(tally.per_class);
            if (!as_json_) fmt::print(" {:10.3f}", ratio(tally.per_class));
        } else {
            for (std::size_t g = 0; g < policies_; ++g) {
                row[kPolicies[g]] = ratio(tally.gaps[g]);
                if (!as_json_) fmt::print(" {:8.3f}", ratio(tally.gaps[g]));
            }
        }
        if (!as_json_) fmt::print("\n");
        json_["tables"].back()["rows"].push_back(row);
        if (tally.mistakes > 0)
            complain(fmt::format("{}: {} plans are wrong: {}", bus, tally.mistakes, tally.mistake));
        if (tally.worst <= promised || tally.worst <= worst_printed_) return;
        worst_printed_ = tally.worst;
        deviation_ =
            fmt::format("{}: {:.4f} of the least for {}, as with {}", bus, static_cast<double>(tally.worst),
                        tally.worst_map.name, map_text(shrunk(tally.worst_map)));
    }

    void complain(const std::string& text) {
        broken_ = true;
        complaints_.push_back(text);
    }

    int finish() {
        end_table();
        std::fflush(stdout);
        json_["complaints"] = complaints_;
        if (as_json_) fmt::print("{}\n", json_.dump());
        for (const auto& text : complaints_) fmt::print(stderr, "corpus: {}\n", text);
        return broken_ ? 1 : 0;
    }

private:
    /// Prints the worst map of each table.
    void end_table() {
        if (!deviation_.empty()) complain(deviation_);
        deviation_.clear();
        worst_printed_ = 0;
    }

    bool as_json_;
    bool several_ = false;
    std::size_t policies_ = 0;
    long double worst_printed_ = 0;
    std::string deviation_;
    bool broken_ = false;
    nlohmann::json json_;
    std::vector<std::string> complaints_;
};

template <class Add>
void add_row(Report& report, const std::string& bus, const std::vector<Map>& maps, long double promised,
             const Add& add) {
    Tally tally;
    for (const auto& map : maps) add(tally, map);
    report.row(bus, tally, promised, [&](const Map& map) { return shrunk(map, promised, add); });
}

/// Every bit rate and turnaround of RTU. @param add  adds a map on a bus to a tally
template <class Add>
void add_rows(Report& report, const std::vector<Map>& maps, long double promised, const Add& add) {
    for (const auto baud : kBauds)
        for (const auto turnaround : kTurnarounds) {
            const Bus bus{wire::Framing::rtu, baud, turnaround};
            add_row(report, fmt::format("{} bit/s {} ms", baud, turnaround / 1ms), maps, promised,
                    [&](Tally& tally, const Map& map) { add(tally, map, bus); });
        }
}

void one_period(Report& report, const std::vector<Map>& maps, bool gaps) {
    report.begin(fmt::format("One period, RTU 8E1, gaps: {} (bus time of a round / the least)",
                             gaps ? "always" : "never"),
                 false, gaps ? std::size(kGaps) : 1);
    add_rows(report, maps, kPromisedOnePeriod,
             [gaps](Tally& tally, const Map& map, const Bus& bus) { add_one_period(tally, map, bus, gaps); });
}

void other_framings(Report& report, const std::vector<Map>& maps) {
    report.begin("One period, ASCII 7E1 and TCP, gaps: always", false, std::size(kGaps));
    const std::pair<std::string, Bus> buses[] = {{"ASCII 9600 5 ms", {wire::Framing::ascii, 9600, 5ms}},
                                                 {"ASCII 115200 0 ms", {wire::Framing::ascii, 115200, 0ms}},
                                                 {"TCP 1 ms", {wire::Framing::tcp, 0, 1ms}},
                                                 {"TCP 50 ms", {wire::Framing::tcp, 0, 50ms}}};
    for (const auto& [name, bus] : buses)
        add_row(report, name, maps, kPromisedOnePeriod,
                [&bus = bus](Tally& tally, const Map& map) { add_one_period(tally, map, bus, true); });
}

void several_periods(Report& report, const std::string& title, const std::vector<Map>& maps) {
    report.begin(title, true, 0);
    add_rows(report, maps, kPromisedSeveral, add_several_periods);
}

/// Where the maps lie beside the project, they are found without being named.
std::string default_corpus(const char* program) {
    std::error_code failed;
    for (auto folder = std::filesystem::weakly_canonical(program, failed).parent_path();
         folder.has_relative_path(); folder = folder.parent_path()) {
        if (!std::filesystem::exists(folder / "CMakePresets.json", failed)) continue;
        const auto file = folder.parent_path() / "shared" / "corpus" / "devices.jsonl";
        return std::filesystem::exists(file, failed) ? file.string() : std::string();
    }
    return {};
}

Arguments arguments_of(int argc, char** argv) {
    Arguments arguments{.corpus = default_corpus(argv[0])};
    for (int i = 1; i < argc; ++i) {
        if (std::strcmp(argv[i], "--json") == 0)
            arguments.json = true;
        else if (std::strcmp(argv[i], "--corpus") == 0 && i + 1 < argc)
            arguments.corpus = argv[++i];
        else if (std::strcmp(argv[i], "--seed") == 0 && i + 1 < argc)
            arguments.seed = std::strtoull(argv[++i], nullptr, 10);
        else {
            fmt::print(stderr, "usage: takt_bench_corpus [--corpus FILE] [--seed N] [--json]\n");
            std::exit(2);
        }
    }
    return arguments;
}

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = arguments_of(argc, argv);
    constexpr std::size_t kMadeUp = 60;
    auto maps = made_up(kMadeUp, arguments.seed);
    std::string what = fmt::format("{} maps made up from seed {}", kMadeUp, arguments.seed);
    if (arguments.corpus.empty()) {
        what += "; no corpus of real maps was found (--corpus FILE)";
    } else {
        const auto real = load(arguments.corpus);
        if (real.empty()) {
            fmt::print(stderr, "corpus: {}: no register map can be read from it\n", arguments.corpus);
            return 3;
        }
        what = fmt::format("{} maps of {} and ", real.size(), arguments.corpus) + what;
        maps.insert(maps.begin(), real.begin(), real.end());
    }
    Report report(arguments.json, what);
    if (!reference_holds(arguments.seed))
        report.complain("the reference is not the least: do not believe it");
    const auto alike = with_periods(maps, {1s}, arguments.seed);
    one_period(report, alike, true);
    one_period(report, alike, false);
    other_framings(report, alike);
    std::vector<Map> own;
    std::ranges::copy_if(maps, std::back_inserter(own), &Map::has_periods);
    if (!own.empty())
        several_periods(
            report, fmt::format("The periods {} maps come with (load of the line / the least)", own.size()),
            own);
    several_periods(report,
                    "Periods of 100 ms, 1 s, 10 s drawn for each value (load of the line / the least)",
                    with_periods(maps, {100ms, 1s, 10s}, arguments.seed));
    return report.finish();
}
