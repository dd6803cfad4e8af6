// The bit rate, the character format and the framing of a line, found by listening.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "takt/capture/frame_finder.hpp"
#include "takt/wire/character.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::capture {

/// How a line is sent.
struct LineSetting {
    wire::CharacterFormat format;
    wire::Framing framing = wire::Framing::rtu;
    friend bool operator==(const LineSetting&, const LineSetting&) = default;
};

/// Tries settings of a port until frames with good checksums are received.
///
/// Each bit rate is read with characters of eleven bits (8E1), then of ten (8N1). The value of a character
/// does not depend on its parity, so frames with good checksums show that the bit rate is right. The
/// characters that the UART then marks as faulty show the parity:
///
/// | read as | the line is | marked characters |
/// | --- | --- | --- |
/// | 8E1 | 8E1 | none |
/// | 8E1 | 8N2 | those with an even number of ones: the first stop bit is taken for the parity |
/// | 8E1 | 8O1, or 8N1 without pauses | all; 8O1 is read next |
/// | 8N1 | 8N1 | none |
///
/// An 8N1 line with a pause after each character reads as 8N2; both formats receive it. ASCII with seven data
/// bits is read as 8N1: the eighth bit is its parity, or always one (7N2).
///
/// A setting is given up after kMostBursts bursts of characters, or kPatience characters, without a good
/// frame. When all settings were tried, the search begins again with twice this patience. Silence costs
/// nothing and proves nothing. Pure; allocates at construction and within a bound. One owner, one thread.
class SettingSearch {
public:
    /// The most usual bit rates first.
    static constexpr std::array<std::uint32_t, 8> kBauds{9600, 19200, 115200, 38400, 57600, 4800, 2400, 1200};
    static constexpr std::size_t kFrames = 2;  ///< with good checksums, before a setting is judged
    static constexpr std::size_t kPatience = 600;
    static constexpr std::size_t kMostBursts = 4;

    /// @param bauds  at least one
    explicit SettingSearch(std::span<const std::uint32_t> bauds = kBauds);
    /// Only the framing is searched: a pseudo-terminal has neither bit rate nor parity.
    explicit SettingSearch(const wire::CharacterFormat& format);
    ~SettingSearch();
    SettingSearch(const SettingSearch&) = delete;
    SettingSearch& operator=(const SettingSearch&) = delete;

    /// The port must be set so. It changes in on_characters() only.
    [[nodiscard]] const wire::CharacterFormat& format() const { return format_; }

    /// Characters were received with that setting, the last at `t`. A break counts as a faulty zero.
    void on_characters(Instant t, std::span<const wire::Character> characters);

    [[nodiscard]] const std::optional<LineSetting>& found() const { return found_; }
    /// Characters received with all settings.
    [[nodiscard]] std::uint64_t characters() const { return all_characters_; }
    /// Settings tried, the current one among them.
    [[nodiscard]] std::size_t tried() const { return tried_; }

private:
    class Reception;
    enum class Step : std::uint8_t { even, odd, none };  // the parity that the port checks
    enum class Next : std::uint8_t { wait, found, odd, none, baud };

    void begin_step(Step step);
    void count_burst(Instant t, std::size_t characters);
    [[nodiscard]] Next judge(const Reception& reception, wire::CharacterFormat& format) const;
    [[nodiscard]] Next judge_parity(const Reception& reception, wire::CharacterFormat& format) const;
    void proceed(Next next);
    [[nodiscard]] bool exhausted() const;

    std::vector<std::uint32_t> bauds_;
    bool fixed_ = false;
    std::size_t baud_ = 0;  // index
    Step step_ = Step::even;
    std::size_t patience_ = 1;
    wire::CharacterFormat format_;
    std::vector<std::unique_ptr<Reception>> receptions_;  // RTU, ASCII
    std::optional<LineSetting> found_;
    std::uint64_t all_characters_ = 0;
    std::size_t tried_ = 0;
    std::size_t characters_ = 0;  // of this setting
    std::size_t bursts_ = 0;
    Instant last_;
};

}  // namespace takt::capture
