// Single items are tested at likely addresses, then on a grid that becomes finer. From an item that exists
// the run grows both ways by reads as long as the device takes. A read that fails is bisected: a read from
// the known edge succeeds up to the first absent item, so the longest good read ends there. If the item
// behind it exists alone and the longer read fails again, the read was too long, and the limit of all further
// reads is lowered.
#include "takt/bus/range_probe.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <map>

namespace takt::bus {
namespace {

constexpr std::int64_t kHead = 16;  // first addresses of the search
// Register maps begin at low addresses and at round numbers, often one or two items behind them.
constexpr std::int64_t kDenseEnd = 256;
constexpr std::int64_t kLowEnd = 1024;
constexpr std::int64_t kLowStep = 8;
constexpr std::array<std::int64_t, 2> kVeryRound{1000, 0x1000};
constexpr std::int64_t kBehindRound = 3;
constexpr std::int64_t kRound = 100;
constexpr std::int64_t kAround = 64;  // greatest distance from the end of a run
// Refused items whose surroundings are searched.
constexpr std::size_t kMostRefusals = 64;

// The search of an area ends after so many equal responses from its beginning. Silence costs a time-out each.
constexpr std::size_t kMostFirstRefusals = 24;
constexpr std::size_t kMostFirstSilences = 8;

enum class Known : std::uint8_t { nothing, present, absent };

bool is_refusal_of_item(ProbeReply reply) {
    return reply == ProbeReply::bad_value || reply == ProbeReply::failure;
}

void append_item(std::vector<model::ItemRange>& ranges, std::uint16_t item) {
    if (!ranges.empty() && ranges.back().last + 1 == item)
        ranges.back().last = item;
    else
        ranges.push_back({item, item});
}

std::vector<std::int64_t> likely_addresses(std::int64_t first, std::int64_t last) {
    std::vector<std::int64_t> likely;
    const auto add = [&](std::int64_t from, std::int64_t to, std::int64_t step) {
        for (std::int64_t a = (std::max(from, first) + step - 1) / step * step; a <= std::min(to, last);
             a += step)
            likely.push_back(a);
    };
    add(first, first + kHead - 1, 1);
    add(0, kDenseEnd - 1, 1);
    add(kDenseEnd, kLowEnd - 1, kLowStep);
    for (const auto round : kVeryRound)
        for (std::int64_t a = first / round * round; a <= last; a += round) add(a, a + kBehindRound, 1);
    add(0, last, kRound);
    return likely;
}

class Search {
public:
    Search(const ProbeConfig& config, const ProbeOracle& oracle)
        : config_(config),
          oracle_(oracle),
          known_(std::size_t{config.last} - config.first + 1, Known::nothing),
          limit_(std::max<std::uint16_t>(config.most, 1)) {}

    ProbeResult run() {
        for (const auto a : likely_addresses(first(), last())) {
            if (ended_) break;
            search_around(a);
        }
        search_grid();
        return result();
    }

private:
    [[nodiscard]] std::int64_t first() const { return config_.first; }
    [[nodiscard]] std::int64_t last() const { return config_.last; }
    [[nodiscard]] bool inside(std::int64_t a) const { return a >= first() && a <= last(); }
    Known& known(std::int64_t a) { return known_[static_cast<std::size_t>(a - first())]; }

    void end(ProbeEnd how) {
        if (!ended_) result_.end = how;
        ended_ = true;
    }

    ProbeReply question(std::int64_t start, std::int64_t quantity) {
        if (!ended_ && result_.requests >= config_.max_requests) end(ProbeEnd::out_of_requests);
        if (ended_) return ProbeReply::stop;
        ++result_.requests;
        const auto reply = oracle_({static_cast<std::uint16_t>(start), static_cast<std::uint16_t>(quantity)});
        if (reply == ProbeReply::stop) end(ProbeEnd::stopped);
        return reply;
    }

    // True when all the items were read.
    bool ask(std::int64_t start, std::int64_t quantity) {
        return quantity == 1 ? ask_item(start) : asked(question(start, quantity), start, quantity);
    }

    // The same of one item. A refusal counts: the item is absent, or exists and is refused.
    bool ask_item(std::int64_t a) {
        const auto reply = question(a, 1);
        if (asked(reply, a, 1)) return true;
        if (ended_) return false;
        known(a) = Known::absent;
        if (is_refusal_of_item(reply)) {
            refused_.emplace(a, reply);
            if (refused_.size() <= kMostRefusals) refused_edges_.push_back(a);
        } else {
            absent_seen_ = true;
        }
        return false;
    }

    bool asked(ProbeReply reply, std::int64_t start, std::int64_t quantity) {
        if (reply == ProbeReply::values) {
            std::fill_n(known_.begin() + (start - first()), quantity, Known::present);
            result_.longest = std::max(result_.longest, static_cast<std::uint16_t>(quantity));
            present_ = start;
            return true;
        }
        if (!ended_) interpret_failure(reply);
        return false;
    }

    void interpret_failure(ProbeReply reply) {
        if (present_ < 0) {
            if (result_.requests == 1) first_reply_ = reply;
            uniform_ = uniform_ && reply == first_reply_;
            if (!uniform_) return;
            if (reply == ProbeReply::no_function && result_.requests >= kMostFirstRefusals)
                end(ProbeEnd::no_function);
            if (reply == ProbeReply::silent && result_.requests >= kMostFirstSilences)
                end(ProbeEnd::no_answer);
            return;
        }
        if (reply != ProbeReply::silent) return;
        // The device refuses by silence, or it is gone. An item that was read before decides it.
        if (question(present_, 1) != ProbeReply::values) end(ProbeEnd::fell_silent);
    }

    // From coarse to fine, so that a search that is cut short has covered the whole range.
    void search_grid() {
        std::int64_t stride = config_.step;
        while (stride * 2 <= last() - first()) stride *= 2;
        for (; stride >= config_.step && !ended_; stride /= 2)
            for (std::int64_t a = first(); a <= last() && !ended_; a += stride) search_around(a);
    }

    // A short run often lies near another run, or near items that are refused.
    void search_around(std::int64_t a) {
        visit(a);
        add_refused_edges();
        while (!edges_.empty() && !ended_) {
            const auto [edge, direction] = edges_.back();
            edges_.pop_back();
            for (std::int64_t distance = 1; distance <= kAround; distance *= 2)
                visit(edge + direction * distance);
            add_refused_edges();
        }
    }

    // Before another refusal was seen, exceptions 3 and 4 may be the device's word for an absent item.
    void add_refused_edges() {
        if (!absent_seen_) return;
        for (const auto a : refused_edges_) {
            edges_.push_back({a, +1});
            edges_.push_back({a, -1});
        }
        refused_edges_.clear();
    }

    void visit(std::int64_t a) {
        if (ended_ || !inside(a) || known(a) != Known::nothing) return;
        if (!ask_item(a)) return;
        grow(a, +1);
        grow(a, -1);
        try_longer_read(a);
    }

    // A run that is longer than all reads so far, because it was read in parts, shows a longer read.
    void try_longer_read(std::int64_t a) {
        std::int64_t start = a;
        std::int64_t end = a + 1;
        while (inside(start - 1) && known(start - 1) == Known::present) --start;
        while (inside(end) && known(end) == Known::present) ++end;
        std::int64_t good = result_.longest;
        std::int64_t bad = std::min(end - start, limit_);
        if (ended_ || bad <= good || ask(start, bad)) return;
        while (bad - good > 1 && !ended_) {
            const std::int64_t middle = (good + bad) / 2;
            (ask(start, middle) ? good : bad) = middle;
        }
        confirm_limit(start, good, bad);
    }

    // Every item exists, so the read of `bad` items was too long, unless the refusal does not repeat.
    void confirm_limit(std::int64_t start, std::int64_t good, std::int64_t bad) {
        if (ended_ || ask(start, bad) || ended_) return;
        limit_ = good;
        result_.limited = true;
    }

    // Extends a run from an item that exists to its end.
    void grow(std::int64_t from, std::int64_t direction) {
        std::int64_t a = from + direction;
        while (!ended_ && inside(a) && known(a) != Known::absent) {
            if (known(a) == Known::present)
                a += direction;
            else
                a += direction * read_on(a, direction);
        }
        if (inside(a)) edges_.push_back({a, direction});
    }

    // Returns the number of items read from `a` on; 0: there is no item at `a`.
    std::int64_t read_on(std::int64_t a, std::int64_t direction) {
        const std::int64_t most = unknown_items(a, direction);
        if (read(a, most, direction)) return most;
        std::int64_t good = 0;
        std::int64_t bad = most;
        while (bad - good > 1 && !ended_) {
            const std::int64_t middle = (good + bad) / 2;
            (read(a, middle, direction) ? good : bad) = middle;
        }
        if (ended_) return good;
        const std::int64_t suspect = a + direction * good;
        if (!ask_item(suspect)) return good;
        if (good > 0) confirm_limit(first_of(a, bad, direction), good, bad);
        return good + 1;
    }

    bool read(std::int64_t a, std::int64_t quantity, std::int64_t direction) {
        return ask(first_of(a, quantity, direction), quantity);
    }

    static std::int64_t first_of(std::int64_t a, std::int64_t quantity, std::int64_t direction) {
        return direction > 0 ? a : a - quantity + 1;
    }

    // Unknown items from `a` on, at most as many as a read takes.
    std::int64_t unknown_items(std::int64_t a, std::int64_t direction) {
        std::int64_t count = 1;
        while (count < limit_ && inside(a + direction * count) &&
               known(a + direction * count) == Known::nothing)
            ++count;
        return count;
    }

    ProbeResult result() {
        for (std::int64_t a = first(); a <= last(); ++a) {
            const auto item = static_cast<std::uint16_t>(a);
            if (known(a) == Known::present) append_item(result_.readable, item);
            if (known(a) != Known::nothing) append_item(result_.tested, item);
            const bool on_grid = (a - first()) % config_.step == 0;
            if (on_grid && known(a) == Known::nothing && result_.next == 65536)
                result_.next = static_cast<std::uint32_t>(a);
        }
        if (result_.end == ProbeEnd::complete) result_.next = 65536;
        if (absent_seen_) list_refused();
        result_.one_refusal = !absent_seen_ && !refused_.empty();
        return std::move(result_);
    }

    void list_refused() {
        auto& list = result_.refused;
        for (const auto& [address, reply] : refused_) {
            if (known(address) == Known::present) continue;  // the refusal did not repeat
            const auto item = static_cast<std::uint16_t>(address);
            if (!list.empty() && list.back().reply == reply && list.back().range.last + 1 == item)
                list.back().range.last = item;
            else
                list.push_back({{item, item}, reply});
        }
    }

    const ProbeConfig& config_;
    const ProbeOracle& oracle_;
    std::vector<Known> known_;
    std::int64_t limit_;
    std::int64_t present_ = -1;  // the start of the last successful read
    bool uniform_ = true;        // all responses so far were equal, and none had values
    ProbeReply first_reply_ = ProbeReply::values;
    struct Edge {
        std::int64_t address;  // the first item beyond a run
        std::int64_t direction;
    };
    std::vector<Edge> edges_;                     // whose surroundings are not searched yet
    std::map<std::int64_t, ProbeReply> refused_;  // single items, by exception 3 or 4
    std::vector<std::int64_t> refused_edges_;     // of them, not yet in `edges_`
    bool absent_seen_ = false;                    // a single item was refused in another way
    bool ended_ = false;
    ProbeResult result_;
};

std::size_t bisection(std::size_t length) {
    return static_cast<std::size_t>(std::bit_width(length));
}

}  // namespace

std::size_t most_probe_requests(const ProbeConfig& config, std::size_t readable, std::size_t runs,
                                std::uint16_t limit) {
    const std::size_t addresses = std::size_t{config.last} - config.first + 1;
    const std::size_t search = bisection(config.most);
    const std::size_t around = config.step > 1 ? bisection(kAround) : 0;
    const std::size_t likely = config.step > 1 ? likely_addresses(config.first, config.last).size() : 0;
    const std::size_t full_reads = readable / std::max<std::size_t>(limit, 1);
    return addresses / config.step + 1 + likely + full_reads + runs * (2 * (search + around + 3) + 2) +
           2 * (search + 2);
}

ProbeResult probe_ranges(const ProbeConfig& config, const ProbeOracle& oracle) {
    return Search(config, oracle).run();
}

}  // namespace takt::bus
