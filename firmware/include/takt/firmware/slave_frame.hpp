// The frames of a slave on a microcontroller: a request in, its response out; the storage of its banks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/serve/server.hpp"

namespace takt::firmware {

/// Answers one RTU frame as a server does (see serve::Server). Without heap, exceptions, RTTI and clock.
/// SerialDevice knows where a frame ends, and when the line is free. One caller at a time; not for interrupt
/// handlers of two priorities.
///
/// @param request   one frame, from the unit address to the CRC, any length
/// @param response  buffer for the response with its CRC, wire::kMaxRtuFrame bytes; may be that of the
/// request
/// @returns bytes of the response; 0: nothing is to be sent (a bad checksum, another unit's request, a
///          broadcast, listen-only mode, an answer that was left pending)
std::size_t respond_rtu(serve::Server& server, Bytes request, std::span<std::uint8_t> response);

/// The same of an ASCII frame.
/// @param request   its decoded bytes, from the unit address to the LRC, any length
/// @param response  buffer for the response with its LRC, not encoded; otherwise as above
std::size_t respond_ascii(serve::Server& server, Bytes request, std::span<std::uint8_t> response);

/// The storage of the four banks, addresses from 0 on.
/// @tparam Coils, DiscreteInputs, InputRegisters, HoldingRegisters  0: the area is empty
template <std::size_t Coils, std::size_t DiscreteInputs, std::size_t InputRegisters,
          std::size_t HoldingRegisters>
struct BankStorage {
    std::array<std::uint8_t, (Coils + 7) / 8> coils{};
    std::array<std::uint8_t, (DiscreteInputs + 7) / 8> discrete_inputs{};
    std::array<std::uint16_t, InputRegisters> input_registers{};
    std::array<std::uint16_t, HoldingRegisters> holding_registers{};

    /// Refers to this storage, which outlives it.
    [[nodiscard]] serve::Banks banks() {
        return {{.first = 0, .count = Coils, .packed = coils},
                {.first = 0, .count = DiscreteInputs, .packed = discrete_inputs},
                {.first = 0, .values = input_registers},
                {.first = 0, .values = holding_registers}};
    }
};

}  // namespace takt::firmware
