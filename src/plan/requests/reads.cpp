#include "requests/reads.hpp"

#include <algorithm>
#include <utility>

#include "requests/grouping.hpp"

namespace takt::plan {
namespace {

using model::Variable;

constexpr std::uint32_t kEnd = 65536;

// Function, start, size and bit in one number, in this order of weight: the sort key of reads.
struct SortedRead {
    std::uint64_t key = 0;
    std::uint32_t variable = 0;
};

Span span_of(const Variable& v) {
    const std::uint32_t start = v.start();
    return {start, std::min(start + std::max<std::uint32_t>(v.items(), 1), kEnd)};
}

SortedRead sort_key_of(const Variable& v, std::size_t index) {
    const Span items = span_of(v);
    const bool bit_of_register = v.bit && !wire::is_bit_area(v.area);
    return {std::uint64_t{static_cast<std::uint8_t>(*v.read)} << 48 | std::uint64_t{items.start} << 32 |
                std::uint64_t{items.size()} << 8 | (bit_of_register ? *v.bit : 0U),
            static_cast<std::uint32_t>(index)};
}

wire::Function function_of(const SortedRead& read) {
    return static_cast<wire::Function>(read.key >> 48);
}

Span span_of(const SortedRead& read) {
    const auto start = static_cast<std::uint32_t>(read.key >> 32 & 0xFFFF);
    return {start, start + static_cast<std::uint32_t>(read.key >> 8 & 0xFFFFFF)};
}

std::vector<SortedRead> sorted_reads(const model::Device& device) {
    std::vector<SortedRead> sorted;
    sorted.reserve(device.variables.size());
    for (std::size_t i = 0; i < device.variables.size(); ++i)
        if (is_read(device.variables[i])) sorted.push_back(sort_key_of(device.variables[i], i));
    const auto before = [&device](const SortedRead& a, const SortedRead& b) {
        if (a.key != b.key) return a.key < b.key;
        return device.variables[a.variable].name < device.variables[b.variable].name;
    };
    if (!std::is_sorted(sorted.begin(), sorted.end(), before))
        std::sort(sorted.begin(), sorted.end(), before);
    return sorted;
}

bool by_start(const Span& a, const Span& b) {
    return std::pair(a.start, a.end) < std::pair(b.start, b.end);
}

std::vector<Span> spans_of(const std::vector<model::ItemRange>& ranges) {
    std::vector<Span> spans;
    for (const auto& [first, last] : ranges) spans.push_back({first, std::uint32_t{last} + 1});
    return spans;
}

// `runs` without `holes`; both ascending.
std::vector<Span> without(const std::vector<Span>& runs, const std::vector<Span>& holes) {
    std::vector<Span> left;
    auto hole = holes.begin();
    for (Span run : runs) {
        while (hole != holes.end() && hole->end <= run.start) ++hole;
        for (auto at = hole; at != holes.end() && at->start < run.end; ++at) {
            if (at->start > run.start) left.push_back({run.start, at->start});
            run.start = std::max(run.start, std::min(at->end, run.end));
        }
        if (run.start < run.end) left.push_back(run);
    }
    return left;
}

std::vector<Span> readable_runs(const model::Device& device, const FunctionReads& reads) {
    std::vector<Span> used = united(reads.spans);
    if (device.gaps == model::Gaps::never) return used;
    const auto area = static_cast<std::size_t>(area_of(reads.function));
    const auto& allowed = device.readable[area];
    auto open = without(allowed.empty() ? std::vector<Span>{{0, kEnd}} : spans_of(allowed),
                        spans_of(device.no_read[area]));
    if (device.gaps == model::Gaps::learn) {
        std::vector<Span> refused;
        for (const auto& [items, code, since, checked] : device.learnt.refused[area])
            refused.push_back({items.first, std::uint32_t{items.last} + 1});
        open = without(open, refused);
    }
    std::vector<Span> all;
    std::merge(used.begin(), used.end(), open.begin(), open.end(), std::back_inserter(all), by_start);
    return united(all);
}

// The pieces of long values come where they begin: sorted again.
void split_long_reads(FunctionReads& reads, std::uint32_t limit) {
    std::vector<std::pair<Span, ReadItem>> pieces;
    for (std::size_t i = 0; i < reads.spans.size(); ++i) {
        Span left = reads.spans[i];
        for (; left.size() > limit; left.start += limit)
            pieces.push_back({{left.start, left.start + limit}, reads.items[i]});
        pieces.push_back({left, reads.items[i]});
    }
    std::stable_sort(pieces.begin(), pieces.end(),
                     [](const auto& a, const auto& b) { return by_start(a.first, b.first); });
    reads.spans.clear();
    reads.items.clear();
    for (const auto& [span, item] : pieces) {
        reads.spans.push_back(span);
        reads.items.push_back(item);
    }
}

ReadItem item_of(const Variable& v, std::size_t index) {
    return {index, v.period, due_within(v), v.read_trigger, v.status};
}

FunctionReads reads_at(const model::Project& project, const model::Line& line, const model::Device& device,
                       std::span<const SortedRead> sorted) {
    const wire::Function function = function_of(sorted.front());
    FunctionReads reads{function,
                        ItemLimit(project, line, device, function, model::Strategy::optimal),
                        read_cost(line, device, function),
                        {},
                        {},
                        {}};
    reads.spans.reserve(sorted.size());
    reads.items.reserve(sorted.size());
    bool long_ones = false;
    const std::uint32_t limit = reads.rules().limit;
    for (const SortedRead& read : sorted) {
        reads.spans.push_back(span_of(read));
        reads.items.push_back(item_of(device.variables[read.variable], read.variable));
        long_ones = long_ones || reads.spans.back().size() > limit;
    }
    reads.readable = readable_runs(device, reads);
    if (long_ones) split_long_reads(reads, limit);
    return reads;
}

}  // namespace

CoverRules FunctionReads::rules() const {
    return {cost, std::max<std::uint32_t>(static_cast<std::uint32_t>(limit.items()), 1), readable};
}

std::vector<FunctionReads> reads_of(const model::Project& project, const model::Line& line,
                                    const model::Device& device) {
    const std::vector<SortedRead> sorted = sorted_reads(device);
    std::vector<FunctionReads> all;
    for (auto from = sorted.begin(); from != sorted.end();) {
        const auto to = std::find_if(
            from, sorted.end(), [&](const SortedRead& p) { return function_of(p) != function_of(*from); });
        all.push_back(reads_at(project, line, device, {from, to}));
        from = to;
    }
    return all;
}

}  // namespace takt::plan
