#include "takt/capture/setting_search.hpp"

#include <bit>
#include <deque>

namespace takt::capture {

/// How many of some characters have a property.
struct CharacterShare {
    std::size_t hits = 0;
    std::size_t all = 0;
    void count(bool hit) {
        hits += hit ? 1 : 0;
        ++all;
    }
    // A tenth is left to noise. Four characters show nothing yet of a property that half of all have.
    [[nodiscard]] bool known() const { return all >= 4; }
    [[nodiscard]] bool rarely() const { return hits * 10 <= all; }
    [[nodiscard]] bool mostly() const { return hits * 10 >= all * 9; }
};

namespace {

constexpr Duration kBurstPause = std::chrono::milliseconds(25);
constexpr std::size_t kLeastOfBursts = 24;  // characters in kMostBursts bursts
constexpr std::size_t kMostFrames = 8;      // a setting whose marks fit no format is given up
constexpr std::uint8_t kSevenBits = 0x7F;

}  // namespace

/// The characters of the current setting, cut into frames of one framing.
class SettingSearch::Reception final : private LineSink {
public:
    Reception(wire::Framing framing, Duration character)
        : framing_(framing),
          finder_({.framing = framing, .character = character, .pause = pause(framing), .known_only = true},
                  *this) {}

    void push(Instant t, std::span<const wire::Character> characters) {
        for (const auto& character : characters) {
            pending_.push_back(character);
            const auto value = framing_ == wire::Framing::ascii
                                   ? static_cast<std::uint8_t>(character.value & kSevenBits)
                                   : character.value;
            finder_.push(t, {&value, 1});
        }
    }

    [[nodiscard]] wire::Framing framing() const { return framing_; }
    [[nodiscard]] std::size_t frames() const { return frames_; }
    // Of the characters in good frames: marked ones among those with an even and an odd number of ones.
    CharacterShare marked_even, marked_odd;
    CharacterShare high, even;  // with the eighth bit set; with an even number of ones among eight bits

private:
    static Duration pause(wire::Framing framing) {
        return framing == wire::Framing::ascii ? Duration(std::chrono::seconds(1))
                                               : FrameFinderConfig{}.pause;
    }

    // The finder reports all characters in their order, so those of a frame are the next ones.
    void on_frame(const LineFrame& frame) override {
        ++frames_;
        for (std::size_t i = 0; i < frame.raw.size(); ++i) {
            const auto character = pending_[i];
            const bool is_even = std::popcount(character.value) % 2 == 0;
            (is_even ? marked_even : marked_odd).count(character.faulty);
            high.count(character.value > kSevenBits);
            even.count(is_even);
        }
        drop(frame.raw.size());
    }
    void on_damaged(const DamagedBytes& damaged) override { drop(damaged.bytes.size()); }
    void drop(std::size_t count) {
        pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(count));
    }

    wire::Framing framing_;
    FrameFinder finder_;
    std::deque<wire::Character> pending_;  // not yet reported by the finder
    std::size_t frames_ = 0;
};

SettingSearch::SettingSearch(std::span<const std::uint32_t> bauds) : bauds_(bauds.begin(), bauds.end()) {
    begin_step(Step::even);
}

SettingSearch::SettingSearch(const wire::CharacterFormat& format) : fixed_(true), format_(format) {
    begin_step(Step::none);
}

SettingSearch::~SettingSearch() = default;

void SettingSearch::begin_step(Step step) {
    step_ = step;
    if (!fixed_) {
        const auto parity = step == Step::even  ? wire::Parity::even
                            : step == Step::odd ? wire::Parity::odd
                                                : wire::Parity::none;
        format_ = {.baud = bauds_[baud_], .data_bits = 8, .parity = parity, .stop_bits = 1};
    }
    receptions_.clear();
    const auto character = fixed_ ? Duration::zero() : wire::transmission_time(format_, 1);
    for (const auto framing : {wire::Framing::rtu, wire::Framing::ascii})
        receptions_.push_back(std::make_unique<Reception>(framing, character));
    characters_ = bursts_ = 0;
    ++tried_;
}

void SettingSearch::count_burst(Instant t, std::size_t characters) {
    const auto length = static_cast<Duration::rep>(characters) * wire::transmission_time(format_, 1);
    if (characters_ > 0 && t - last_ > kBurstPause + length) ++bursts_;
    last_ = t;
    characters_ += characters;
    all_characters_ += characters;
}

void SettingSearch::on_characters(Instant t, std::span<const wire::Character> characters) {
    if (found_ || characters.empty()) return;
    count_burst(t, characters.size());
    auto next = Next::wait;
    for (const auto& reception : receptions_) {
        reception->push(t, characters);
        if (next != Next::wait || reception->frames() < kFrames) continue;
        auto format = format_;
        next = judge(*reception, format);
        if (next == Next::found) found_ = {format, reception->framing()};
    }
    if (next == Next::wait && exhausted()) next = step_ == Step::none ? Next::baud : Next::none;
    proceed(next);
}

bool SettingSearch::exhausted() const {
    if (fixed_) return false;
    std::size_t patience = patience_;
    for (const auto& reception : receptions_) patience += reception->frames();
    return characters_ >= patience * kPatience ||
           (bursts_ >= patience * kMostBursts && characters_ >= patience * kLeastOfBursts);
}

void SettingSearch::proceed(Next next) {
    if (next == Next::odd) return begin_step(Step::odd);
    if (next == Next::none) return begin_step(Step::none);
    if (next != Next::baud) return;
    if (++baud_ == bauds_.size()) {
        baud_ = 0;
        patience_ *= 2;
    }
    begin_step(Step::even);
}

// Seven data bits: the eighth one is the parity.
SettingSearch::Next SettingSearch::judge(const Reception& reception, wire::CharacterFormat& format) const {
    if (fixed_) return Next::found;
    if (reception.framing() == wire::Framing::rtu || reception.high.hits == 0)
        return judge_parity(reception, format);
    if (step_ != Step::none) return Next::none;
    format.data_bits = 7;
    if (reception.high.mostly()) {
        format.stop_bits = 2;
        return Next::found;
    }
    if (!reception.even.mostly() && !reception.even.rarely()) return Next::baud;
    format.parity = reception.even.mostly() ? wire::Parity::even : wire::Parity::odd;
    return Next::found;
}

SettingSearch::Next SettingSearch::judge_parity(const Reception& reception,
                                                wire::CharacterFormat& format) const {
    const auto& even = reception.marked_even;
    const auto& odd = reception.marked_odd;
    if ((!even.known() || !odd.known()) && reception.frames() < kMostFrames) return Next::wait;
    if (even.rarely() && odd.rarely()) return Next::found;
    switch (step_) {
        case Step::even:
            if (!even.mostly()) return Next::none;
            if (!odd.rarely()) return Next::odd;
            format.parity = wire::Parity::none;
            format.stop_bits = 2;
            return Next::found;
        case Step::odd: return Next::none;
        case Step::none: break;
    }
    return Next::baud;
}

}  // namespace takt::capture
