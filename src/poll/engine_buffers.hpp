// The memory of the transaction engine of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "takt/bus/transaction_engine.hpp"

namespace takt::poll {

/// The memory of the engine of a line: as much as its framing and its transactions in flight need.
class EngineBuffers {
public:
    /// @param longest_pdu  of all requests and responses
    EngineBuffers(const bus::LineConfig& config, std::size_t longest_pdu, std::size_t units);
    [[nodiscard]] bus::TransactionStorage storage();

private:
    std::vector<bus::TransactionSlot> slots_;
    std::vector<std::uint8_t> bytes_;  // of the slots, for sending, for receiving
    std::size_t longest_pdu_;
    std::size_t sending_;
    std::vector<bus::OutstandingResponse> outstanding_;
};

}  // namespace takt::poll
