#include "takt/console/input_commands.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

namespace takt::console {

InputCommands::InputCommands(line::Loop& loop, int descriptor, Execute execute, const Texts& texts,
                             Reply reply)
    : descriptor_(descriptor),
      reader_(std::move(execute), texts),
      reply_(std::move(reply)),
      watch_(loop, descriptor, [this] { read(); }) {
    watch_.want_read();
}

void InputCommands::read() {
    std::array<char, 4096> buffer;
    const auto count = ::read(descriptor_, buffer.data(), buffer.size());
    if (count == 0) reader_.end(reply_);
    if (count == 0 || (count < 0 && errno != EINTR && errno != EAGAIN)) return;
    if (count > 0) reader_.feed({buffer.data(), static_cast<std::size_t>(count)}, reply_);
    watch_.want_read();
}

}  // namespace takt::console
