#include "report.hpp"

#include <fmt/format.h>

#include <cstdio>

namespace bench {
namespace {

std::string cell(const std::optional<double>& figure, int digits) {
    return figure ? fmt::format("{:.{}f}", *figure, digits) : "-";
}

void print_row(const Row& row) {
    std::string line = fmt::format("{:<26}{:<12}", row.name, row.unit);
    for (const auto& figure : row.figures) line += fmt::format("{:>12}", cell(figure, 1));
    line += fmt::format("{:>11}{:>16}", cell(row.ratio(Kind::echo), 2), cell(row.ratio(Kind::libmodbus), 2));
    for (std::size_t i = 0; i < kKinds.size(); ++i) {
        if (row.unanswered[i] > 0)
            line += fmt::format("  {}: {} unanswered", name(kKinds[i]), row.unanswered[i]);
        if (row.wrong[i] > 0) line += fmt::format("  {}: {} wrong", name(kKinds[i]), row.wrong[i]);
    }
    fmt::print("{}\n", line);
    std::fflush(stdout);
}

void print_json(const Row& row) {
    fmt::print("{{\"name\":\"{}\",\"unit\":\"{}\"", row.name, row.unit);
    for (std::size_t i = 0; i < kKinds.size(); ++i)
        if (row.figures[i])
            fmt::print(",\"{}\":{{\"figure\":{:.2f},\"unanswered\":{},\"wrong\":{}}}", name(kKinds[i]),
                       *row.figures[i], row.unanswered[i], row.wrong[i]);
    fmt::print("}}");
}

}  // namespace

std::optional<double> Row::ratio(Kind other) const {
    const auto& own = figures[static_cast<std::size_t>(Kind::takt)];
    const auto& theirs = figures[static_cast<std::size_t>(other)];
    if (!own || !theirs || *theirs == 0) return {};
    return *own / *theirs;
}

Report::Report(bool json) : json_(json) {
    if (json_)
        fmt::print("{{\"slave\":[");
    else
        fmt::print("{:<38}{:>12}{:>12}{:>12}{:>11}{:>16}\n", "", "takt", "echo", "libmodbus", "takt/echo",
                   "takt/libmodbus");
}

void Report::add(const Row& row) {
    const auto own = static_cast<std::size_t>(Kind::takt);
    failed_ = failed_ || row.wrong[own] > 0 || row.unanswered[own] > 0;
    if (!json_) return print_row(row);
    if (!first_) fmt::print(",");
    first_ = false;
    print_json(row);
}

int Report::end() {
    if (json_) fmt::print("]}}\n");
    if (failed_) std::fprintf(stderr, "a good client got no answer, or a wrong one\n");
    return failed_ ? 1 : 0;
}

}  // namespace bench
