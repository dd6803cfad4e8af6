#include "takt/plan/read_alternatives.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "requests/cover.hpp"
#include "requests/reads.hpp"
#include "takt/wire/function.hpp"

namespace takt::plan {
namespace {

constexpr std::size_t kMostWiderReads = 3;
constexpr std::size_t kMostPartReads = 3;
constexpr std::size_t kMostOtherReads = 2;
static_assert(kMostWiderReads + kMostPartReads + kMostOtherReads <= ReadAlternatives::capacity());

// The read half of 0x17 is sent alone as 0x03.
wire::Function read_of(const Request& request) {
    return *request.read == wire::Function::read_write_multiple_registers
               ? wire::Function::read_holding_registers
               : *request.read;
}

Span span_of_request(const Request& request) {
    return {request.start, std::uint32_t{request.start} + request.quantity};
}

/// Collects reads whose responses differ from that of the request and from each other.
class Collection {
public:
    explicit Collection(const Request& request) : request_(request) {}

    [[nodiscard]] bool is_new(wire::Function read, std::uint32_t quantity) const {
        const auto same = [&](wire::Function other, std::uint32_t other_quantity) {
            return other == read && length(other, other_quantity) == length(read, quantity);
        };
        return !same(read_of(request_), request_.quantity) &&
               std::ranges::none_of(found_, [&](const auto& a) { return same(a.read, a.quantity); });
    }

    void add(ReadAlternative::Kind kind, std::size_t most, wire::Function read, Span items) {
        const auto of_kind = std::ranges::count(found_, kind, &ReadAlternative::kind);
        if (items.size() == 0 || static_cast<std::size_t>(of_kind) >= most || !is_new(read, items.size()))
            return;
        found_.push_back({.kind = kind,
                          .read = read,
                          .start = static_cast<std::uint16_t>(items.start),
                          .quantity = static_cast<std::uint16_t>(items.size())});
    }

    [[nodiscard]] const ReadAlternatives& all() const { return found_; }

private:
    static std::size_t length(wire::Function read, std::uint32_t quantity) {
        return wire::response_pdu_length(read, quantity);
    }

    const Request& request_;
    ReadAlternatives found_;
};

// `more` items behind the request, else before it, else on both sides.
Span widened(Span items, std::uint32_t more, Span run) {
    const std::uint32_t behind = std::min(more, run.end - items.end);
    const std::uint32_t before = std::min(more - behind, items.start - run.start);
    return {items.start - before, items.end + behind};
}

// Whole variables first: their values count. A device may refuse a part of a value.
void add_parts(Collection& found, const Request& request, const model::Device& device, bool of_values) {
    const Span items = span_of_request(request);
    std::uint32_t first_end = items.end;
    std::uint32_t last_start = items.start;
    for (const auto v : request.variables) {
        const auto& variable = device.variables[v];
        const std::uint32_t end = std::uint32_t{variable.start()} + variable.items();
        if (end > items.start) first_end = std::min(first_end, end);
        last_start = std::max(last_start, std::uint32_t{variable.start()});
    }
    const auto part = [&](std::uint32_t end) {
        if (end > items.start && end < items.end)
            found.add(ReadAlternative::Kind::part, kMostPartReads, read_of(request), {items.start, end});
    };
    part(first_end);
    part(last_start);
    if (!of_values) return;
    part(items.end - 1);
    part(items.start + 1);
}

std::vector<ReadAlternative> polled_reads(const model::Line& line, const model::Device& device,
                                          std::span<const Request> requests) {
    std::set<std::pair<wire::Function, std::size_t>> known;  // of the response
    std::vector<ReadAlternative> reads;
    for (const auto& request : requests) {
        if (&line.devices[request.device] != &device || !request.read || !request.period) continue;
        const auto read = read_of(request);
        if (known.emplace(read, wire::response_pdu_length(read, request.quantity)).second)
            reads.push_back({.kind = ReadAlternative::Kind::another,
                             .read = read,
                             .start = request.start,
                             .quantity = request.quantity});
    }
    return reads;
}

}  // namespace

AlternativeReads::AlternativeReads(const model::Project& project, const model::Line& line,
                                   const model::Device& device, std::span<const Request> requests)
    : others_(polled_reads(line, device, requests)),
      device_(&device),
      parts_only_(project.profile == model::Profile::owen_kc1) {
    for (const auto& reads : reads_of(project, line, device)) {
        const ItemLimit limit(project, line, device, reads.function, device.strategy);
        auto& readable = readable_.emplace_back(Readable{.read = reads.function, .limit = limit.items()});
        const auto& runs = device.gaps == model::Gaps::always ? reads.readable : united(reads.spans);
        for (const Span& run : runs) readable.runs.emplace_back(run.start, run.end);
    }
}

ReadAlternatives AlternativeReads::of(const Request& request) const {
    Collection found(request);
    const Span items = span_of_request(request);
    const auto readable = std::ranges::find(readable_, *request.read, &Readable::read);
    if (!parts_only_ && readable != readable_.end()) {
        const auto around = std::ranges::find_if(readable->runs, [&](const auto& run) {
            return run.first <= items.start && items.end <= run.second;
        });
        // A byte of the response has eight bits.
        const std::uint32_t most = wire::counts_bits(*request.read) ? 8 * kMostWiderReads : kMostWiderReads;
        for (std::uint32_t more = 1; around != readable->runs.end() && more <= most; ++more) {
            const Span wider = widened(items, more, {around->first, around->second});
            if (wider.size() == items.size() + more && wider.size() <= readable->limit)
                found.add(ReadAlternative::Kind::wider, kMostWiderReads, read_of(request), wider);
        }
    }
    add_parts(found, request, *device_, !parts_only_);
    if (!parts_only_)
        for (const auto& other : others_)
            found.add(other.kind, kMostOtherReads, other.read,
                      {other.start, std::uint32_t{other.start} + other.quantity});
    return found.all();
}

}  // namespace takt::plan
