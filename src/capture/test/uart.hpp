// A serial line bit by bit: the signal that masters and devices send, with noise, and a UART that samples it
// at settings of its own.
#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <random>
#include <vector>

#include "takt/wire/character.hpp"
#include "takt/wire/frame.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::capture::test {

struct SignalOptions {
    wire::CharacterFormat format;
    wire::Framing framing = wire::Framing::rtu;
    double clock = 1;             ///< bit rate of the senders, of the nominal one
    double glitches_per_bit = 0;  ///< short inversions of the level
    double pause = 0;             ///< bit times between the characters of a frame, at most
    bool busy = false;            ///< exchanges follow each other in a few milliseconds
    unsigned seed = 1;
};

/// The level of a line with exchanges that never end; times in seconds from 0.
class Signal {
public:
    explicit Signal(const SignalOptions& options)
        : options_(options), rng_(options.seed), bit_(1 / (options.format.baud * options.clock)) {}

    /// @param t  must not run backwards by more than a few characters
    bool level(double t) {
        move_to(t);
        return (next_ + dropped_) % 2 == 0;
    }

    /// The next falling edge behind `t`.
    double falling_edge(double t) {
        move_to(t);
        const std::size_t falling = next_ + (next_ + dropped_) % 2;
        while (falling >= edges_.size()) exchange();
        return edges_[falling];
    }

    [[nodiscard]] std::uint64_t sent() const { return sent_; }  ///< frames

private:
    double uniform(double least, double most) { return std::uniform_real_distribution(least, most)(rng_); }
    std::uint8_t byte() { return static_cast<std::uint8_t>(rng_()); }

    // next_ becomes the index of the first edge behind `t`.
    void move_to(double t) {
        while (end_ <= t) exchange();
        while (next_ < edges_.size() && edges_[next_] <= t) ++next_;
        while (next_ > 0 && edges_[next_ - 1] > t) --next_;
        constexpr std::size_t kBehind = 1000;
        for (; next_ > kBehind; --next_, ++dropped_) edges_.pop_front();
    }

    void exchange() {
        const auto unit = static_cast<std::uint8_t>(1 + rng_() % 5);
        const auto count = static_cast<std::uint8_t>(1 + rng_() % 10);
        const auto start = static_cast<std::uint8_t>(rng_() % 200);
        send(unit, {3, 0, start, 0, count});
        end_ += uniform(4 * 11 * bit_, 4 * 11 * bit_ + 0.02);
        std::vector<std::uint8_t> response{3, static_cast<std::uint8_t>(2 * count)};
        for (int i = 0; i < count; ++i) {
            response.push_back(rng_() % 2 == 0 ? std::uint8_t{0} : byte());
            response.push_back(byte());
        }
        send(unit, response);
        end_ += options_.busy ? uniform(4 * 11 * bit_, 4 * 11 * bit_ + 0.005) : uniform(0.03, 0.2);
    }

    void send(std::uint8_t unit, const std::vector<std::uint8_t>& pdu) {
        ++sent_;
        const double begin = end_;
        const std::size_t first = edges_.size();
        for (const auto character : wire::encode_frame(options_.framing, UnitId{unit}, 0, pdu)) {
            send_character(character);
            end_ += uniform(0, options_.pause) * bit_;
        }
        add_glitches(begin, first);
    }

    void send_character(std::uint8_t value) {
        int ones = 0;
        send_bit(false);
        for (int bit = 0; bit < options_.format.data_bits; ++bit) {
            const bool one = (value >> bit & 1) != 0;
            ones += one ? 1 : 0;
            send_bit(one);
        }
        if (options_.format.parity != wire::Parity::none)
            send_bit((ones % 2 == 1) == (options_.format.parity == wire::Parity::even));
        for (int stop = 0; stop < options_.format.stop_bits; ++stop) send_bit(true);
    }

    void send_bit(bool level) {
        const bool now = (edges_.size() + dropped_) % 2 == 0;
        if (level != now) edges_.push_back(end_);
        end_ += bit_;
    }

    // Two edges with no other edge between them.
    void add_glitches(double begin, std::size_t first) {
        if (options_.glitches_per_bit == 0) return;
        std::exponential_distribution<double> distance(options_.glitches_per_bit / bit_);
        for (double at = begin + distance(rng_); at < end_; at += distance(rng_)) {
            const double length = uniform(0.1, 0.9) * bit_;
            const auto from = edges_.begin() + static_cast<std::ptrdiff_t>(first);
            const auto next = std::upper_bound(from, edges_.end(), at);
            if (next != edges_.end() && *next <= at + length) continue;
            const auto placed = edges_.insert(next, at);
            edges_.insert(placed + 1, at + length);
        }
    }

    SignalOptions options_;
    std::mt19937 rng_;
    double bit_;
    double end_ = 0.1;
    std::deque<double> edges_;  // the level changes there; it is high at first
    std::size_t dropped_ = 0;
    std::size_t next_ = 0;
    std::uint64_t sent_ = 0;
};

/// A UART: each bit is sampled once, in its middle.
class Uart {
public:
    /// @param resynchronises  a stop bit that is zero counts as the next start bit, as in a 16550; else the
    ///                        next falling edge begins a character
    Uart(Signal& signal, double start, bool resynchronises)
        : signal_(signal), t_(start), resynchronises_(resynchronises) {}

    struct Received {
        double time = 0;
        wire::Character character;
    };

    Received receive(const wire::CharacterFormat& format) {
        const double bit = 1.0 / format.baud;
        double start = start_bit(bit);
        unsigned value = 0;
        int ones = 0;
        double at = start + 1.5 * bit;
        for (int i = 0; i < format.data_bits; ++i, at += bit)
            if (signal_.level(at)) value |= 1U << i, ++ones;
        bool faulty = false;
        bool any = value != 0;
        if (format.parity != wire::Parity::none) {
            const bool parity = signal_.level(at);
            faulty = (ones + (parity ? 1 : 0)) % 2 != (format.parity == wire::Parity::even ? 0 : 1);
            any = any || parity;
            at += bit;
        }
        const bool stop = signal_.level(at);
        t_ = at;
        next_start_.reset();
        if (!stop && !any) {
            while (!signal_.level(t_)) t_ += bit / 8;  // a break: until the line is idle
        } else if (!stop && resynchronises_) {
            next_start_ = at - bit / 2;
        }
        return {at, {static_cast<std::uint8_t>(value), faulty || !stop}};
    }

private:
    double start_bit(double bit) {
        if (next_start_) return *next_start_;
        for (;;) {
            const double start = signal_.falling_edge(t_);
            if (!signal_.level(start + bit / 2)) return start;
            t_ = start + bit / 2;
        }
    }

    Signal& signal_;
    double t_;
    bool resynchronises_;
    std::optional<double> next_start_;
};

}  // namespace takt::capture::test
