#include "serial/receive_trigger.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <system_error>

#include "takt/os/descriptor.hpp"

namespace takt::line {
namespace {

constexpr std::size_t kMostDigits = 16;

}  // namespace

ReceiveTrigger::ReceiveTrigger(const std::string& port, const std::string& tty) {
    std::error_code unknown;
    auto device = std::filesystem::canonical(port, unknown);
    if (unknown) device = port;
    attribute_ = tty + '/' + device.filename().string() + "/rx_trig_bytes";
}

std::optional<unsigned> ReceiveTrigger::characters() const {
    const os::Descriptor file(::open(attribute_.c_str(), O_RDONLY | O_CLOEXEC));
    std::array<char, kMostDigits> text{};
    const auto count = file ? ::read(file.get(), text.data(), text.size()) : -1;
    unsigned number = 0;
    const auto parsed = std::from_chars(text.data(), text.data() + std::max<ssize_t>(count, 0), number);
    return parsed.ec == std::errc() ? std::optional(number) : std::nullopt;
}

int ReceiveTrigger::set(unsigned characters) const {
    const os::Descriptor file(::open(attribute_.c_str(), O_WRONLY | O_CLOEXEC));
    if (!file) return errno;
    const auto text = std::to_string(characters);
    return ::write(file.get(), text.data(), text.size()) < 0 ? errno : 0;
}

bool ReceiveTrigger::is_writable() const {
    return ::access(attribute_.c_str(), W_OK) == 0;
}

}  // namespace takt::line
