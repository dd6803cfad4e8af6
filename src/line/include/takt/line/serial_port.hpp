// A serial port of Linux: a UART, a USB adapter or a pseudo-terminal.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "takt/line/byte_stream.hpp"
#include "takt/model/project.hpp"
#include "takt/wire/character.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::line {

struct SerialSettings {
    std::string path;
    wire::CharacterFormat format;  ///< any baud the port can do; 5..8 data bits
    model::Rs485 rs485 = model::Rs485::automatic;
    /// Ask the driver to hand on received bytes at once (USB adapters wait up to 16 ms, a 16550 for a pause
    /// of four characters).
    bool low_latency = true;
    bool read_only = false;  ///< opened for reading: the system refuses every write()
};

/// How soon received bytes are handed on.
struct SerialLatency {
    /// Of the request for ASYNC_LOW_LATENCY: 0, or errno (ENOTTY: the driver has no such setting, EOPNOTSUPP:
    /// it ignores the setting).
    int error = 0;
    /// The UART collects so many characters; fewer are handed on after a pause of four characters. Above 1:
    /// the port could not be set to 1.
    unsigned receive_trigger = 1;
    friend bool operator==(const SerialLatency&, const SerialLatency&) = default;
};

struct SerialCounters {
    /// With a parity or framing error, as far as the driver reports them.
    std::uint64_t faulty_characters = 0;
    std::uint64_t breaks = 0;
};

/// Whether a port is a pseudo-terminal: it has no character times, so a response may arrive before its
/// request would have been sent, and it never echoes. False if there is no such port.
[[nodiscard]] bool is_pseudo_terminal(const std::string& path);

/// An open port: locked against every other user, in raw mode.
///
/// The lock is TIOCEXCL and flock(): another program (or another takt, also as root) gets `busy`.
/// Destroying the port waits at most 0.3 s for written bytes, restores the original settings and unlocks it.
/// Only the echo of a real port stays off: with it the kernel would send what it receives before the next
/// program has set the port.
/// A pseudo-terminal keeps the bit rate but ignores parity and RS-485 settings. One owner, one thread.
class SerialPort final : public ByteStream {
public:
    /// @returns cannot_open (path, errno; ENOTTY: no serial port), busy (path), unsupported ("path baud=…",
    ///          "path parity=…" …) for what the port cannot do, out_of_range ("baud", "data_bits",
    ///          "stop_bits")
    [[nodiscard]] static Result<std::unique_ptr<SerialPort>> open(const SerialSettings& settings);
    ~SerialPort() override;
    SerialPort(const SerialPort&) = delete;
    SerialPort& operator=(const SerialPort&) = delete;

    [[nodiscard]] int fd() const override;
    [[nodiscard]] Result<std::size_t> read(std::span<std::uint8_t> buffer) override;
    [[nodiscard]] Result<std::size_t> write(Bytes bytes) override;

    /// As read(), with the value of faulty characters as received.
    /// @param characters  at most as many bytes are read. @returns how many were stored
    [[nodiscard]] Result<std::size_t> read_characters(std::span<wire::Character> characters);
    /// Changes the character format. Received bytes that were not read are dropped, and the counters begin at
    /// zero. @returns what open() returns for a format
    [[nodiscard]] Result<void> set_format(const wire::CharacterFormat& format);

    /// The RS-485 mode in effect: kernel, rts or none.
    [[nodiscard]] model::Rs485 rs485() const;
    /// RTS mode: switches the driver on or off; write() switches it on. No effect in other modes.
    void set_sending(bool on);
    /// Whether the last stop bit has left the transmitter; nothing if the port cannot report it.
    [[nodiscard]] std::optional<bool> transmitter_empty() const;
    /// Nothing: the settings do not ask for low latency, or the port is a pseudo-terminal.
    [[nodiscard]] std::optional<SerialLatency> latency() const;

    [[nodiscard]] SerialCounters counters() const;

private:
    struct Impl;
    explicit SerialPort(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

}  // namespace takt::line
