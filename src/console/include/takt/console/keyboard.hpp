// The keyboard of a terminal, for a live display.
#pragma once

#include <termios.h>

#include <functional>
#include <optional>

#include "takt/console/keys.hpp"
#include "takt/line/loop.hpp"

namespace takt::console {

/// Reads keys at once and without an echo while it lives; then the terminal is as before. Ctrl-C stays a
/// signal. A program in the background leaves the terminal alone. The loop's thread only.
class Keyboard {
public:
    /// @param descriptor  a terminal, which outlives it
    Keyboard(line::Loop& loop, int descriptor, std::function<void(const Key&)> on_key);
    ~Keyboard();
    Keyboard(const Keyboard&) = delete;
    Keyboard& operator=(const Keyboard&) = delete;

    /// Takes the terminal again after the program was in the background. To be called repeatedly.
    void renew();

private:
    void read();
    [[nodiscard]] bool in_foreground() const;

    int descriptor_;
    std::function<void(const Key&)> on_key_;
    KeyReader reader_;
    std::optional<termios> before_;  // the settings that the destructor restores
    line::Watch watch_;
};

}  // namespace takt::console
