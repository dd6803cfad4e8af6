#include "takt/console/keyboard.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

namespace takt::console {
namespace {

constexpr tcflag_t kLineMode = ICANON | ECHO;

}  // namespace

Keyboard::Keyboard(line::Loop& loop, int descriptor, std::function<void(const Key&)> on_key)
    : descriptor_(descriptor), on_key_(std::move(on_key)), watch_(loop, descriptor, [this] { read(); }) {
    renew();
}

Keyboard::~Keyboard() {
    if (before_ && in_foreground()) ::tcsetattr(descriptor_, TCSANOW, &*before_);
}

// In the background tcsetattr() would stop the program.
bool Keyboard::in_foreground() const {
    return ::tcgetpgrp(descriptor_) == ::getpgrp();
}

// A shell that continues the program may have restored its own settings.
void Keyboard::renew() {
    if (!in_foreground()) return;
    watch_.want_read();
    termios now{};
    if (::tcgetattr(descriptor_, &now) != 0 || (now.c_lflag & kLineMode) == 0) return;
    if (!before_) before_ = now;
    now.c_lflag &= ~kLineMode;
    now.c_cc[VMIN] = 1;
    now.c_cc[VTIME] = 0;
    ::tcsetattr(descriptor_, TCSANOW, &now);
}

// In the background read() would stop the program too; renew() goes on.
void Keyboard::read() {
    if (!in_foreground()) return;
    std::array<char, 256> buffer;
    const auto count = ::read(descriptor_, buffer.data(), buffer.size());
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) return;
    if (count > 0) reader_.feed({buffer.data(), static_cast<std::size_t>(count)}, on_key_);
    watch_.want_read();
}

}  // namespace takt::console
