// Single items are tested on a grid that becomes finer. From an item that exists the run grows both ways by
// reads as long as the device takes. A read that fails is bisected: a read from the known edge succeeds up to
// the first absent item, so the longest good read ends there. If the item behind it exists alone and
// the longer read fails again, the read was too long, and the limit of all further reads is lowered.
#include "takt/discover/range_probe.hpp"

#include <algorithm>
#include <bit>

namespace takt::discover {
namespace {

constexpr std::uint32_t kHead = 16;    // first addresses, which are always read
constexpr std::uint32_t kRound = 100;  // runs often begin at its multiples

// The search of an area ends after so many equal responses from its beginning. Silence costs a time-out each.
constexpr std::size_t kMostFirstRefusals = 24;
constexpr std::size_t kMostFirstSilences = 8;

enum class Known : std::uint8_t { nothing, present, absent };

class Search {
public:
    Search(const ProbeConfig& config, const ProbeOracle& oracle)
        : config_(config),
          oracle_(oracle),
          known_(std::size_t{config.last} - config.first + 1, Known::nothing),
          limit_(std::max<std::uint16_t>(config.most, 1)) {}

    ProbeResult run() {
        for (std::int64_t a = first(); a < first() + kHead; ++a) search_around(a);
        search_grid();
        if (config_.step > 1)
            for (std::int64_t a = (first() + kRound - 1) / kRound * kRound; a <= last(); a += kRound)
                search_around(a);
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
        const auto reply = question(start, quantity);
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

    // A run shorter than the step often lies near another run.
    void search_around(std::int64_t a) {
        visit(a);
        while (!edges_.empty() && !ended_) {
            const auto [edge, direction] = edges_.back();
            edges_.pop_back();
            for (std::int64_t distance = 1; distance < config_.step; distance *= 2)
                visit(edge + direction * distance);
        }
    }

    void visit(std::int64_t a) {
        if (ended_ || !inside(a) || known(a) != Known::nothing) return;
        if (!ask(a, 1)) {
            if (!ended_) known(a) = Known::absent;
            return;
        }
        grow(a, +1);
        grow(a, -1);
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
        if (!ask(suspect, 1)) {
            if (!ended_) known(suspect) = Known::absent;
            return good;
        }
        // Every item exists, so the read was too long, unless the refusal does not repeat.
        if (good > 0 && !read(a, bad, direction) && !ended_) {
            limit_ = good;
            result_.limited = true;
        }
        return good + 1;
    }

    bool read(std::int64_t a, std::int64_t quantity, std::int64_t direction) {
        return ask(direction > 0 ? a : a - quantity + 1, quantity);
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
            if (known(a) == Known::present) {
                const auto item = static_cast<std::uint16_t>(a);
                auto& ranges = result_.readable;
                if (!ranges.empty() && ranges.back().last + 1 == a)
                    ranges.back().last = item;
                else
                    ranges.push_back({item, item});
            }
            const bool on_grid = (a - first()) % config_.step == 0;
            if (on_grid && known(a) == Known::nothing && result_.next == 65536)
                result_.next = static_cast<std::uint32_t>(a);
        }
        if (result_.end == ProbeEnd::complete) result_.next = 65536;
        return std::move(result_);
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
    std::vector<Edge> edges_;  // whose surroundings are not searched yet
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
    const std::size_t around = bisection(config.step);
    const std::size_t likely = config.step > 1 ? kHead + addresses / kRound + 1 : 0;
    const std::size_t full_reads = readable / std::max<std::size_t>(limit, 1);
    return addresses / config.step + 1 + likely + full_reads + runs * (2 * (search + around + 3) + 1) +
           search + 2;
}

ProbeResult probe_ranges(const ProbeConfig& config, const ProbeOracle& oracle) {
    return Search(config, oracle).run();
}

}  // namespace takt::discover
