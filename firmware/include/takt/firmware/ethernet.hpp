// What TcpDevice needs of a board besides board.hpp. A board without Ethernet has none of it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/base/engine.hpp"

namespace takt::firmware::board {

/// The longest frame without its checksum: header and 1500 bytes.
inline constexpr std::size_t kMaxEthernetFrame = 14 + 1500;

/// Starts the controller and enables its interrupt, which does nothing but wake the core. Called once.
/// @returns false: the controller does not answer
[[nodiscard]] bool open_ethernet();
[[nodiscard]] std::array<std::uint8_t, 6> ethernet_address();

/// Whether a cable with a peer is plugged in.
[[nodiscard]] bool ethernet_link();

/// Takes the oldest received frame. Damaged and longer frames are dropped.
/// @returns its bytes in `into`, without checksum; 0: there is none
[[nodiscard]] std::size_t receive_ethernet(std::span<std::uint8_t> into);
/// Sends a frame, or copies it to the controller. The controller adds the checksum.
/// @returns false: the controller has no space; nothing is sent
[[nodiscard]] bool send_ethernet(Bytes frame);

/// Whether a frame or a change of the link waits. Called with interrupts masked. Unless it does, the next one
/// raises the interrupt.
[[nodiscard]] bool ethernet_waits();

}  // namespace takt::firmware::board
