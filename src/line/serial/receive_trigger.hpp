// How many characters a UART collects before it hands them on.
#pragma once

#include <optional>
#include <string>

#include "takt/base/time.hpp"
#include "takt/wire/character.hpp"

namespace takt::line {

/// The attribute `rx_trig_bytes` of the kernel's 8250 driver (Documentation/ABI/testing/sysfs-tty). Fewer
/// characters than the trigger are handed on after a pause of four characters.
class ReceiveTrigger {
public:
    /// @param port  also a link to the port
    /// @param tty   the folder with the attributes of the ports
    explicit ReceiveTrigger(const std::string& port, const std::string& tty = "/sys/class/tty");

    /// @returns nothing: the driver has no such attribute
    [[nodiscard]] std::optional<unsigned> characters() const;
    /// The driver may choose the next smaller number. @returns 0, or errno
    [[nodiscard]] int set(unsigned characters) const;
    /// Whether set() is allowed to this process.
    [[nodiscard]] bool is_writable() const;

private:
    std::string attribute_;
};

}  // namespace takt::line
