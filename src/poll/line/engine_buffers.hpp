// The memory of the transaction engine of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "takt/bus/transaction_engine.hpp"

namespace takt::poll {

/// The memory of the engine of a line: as much as its framing and its transactions in flight need. The memory
/// of missing responses is allocated when the first one is missing.
class EngineBuffers final : public bus::ResponseMemory {
public:
    /// @param longest_pdu  of all requests and responses
    EngineBuffers(const bus::LineConfig& config, std::size_t longest_pdu, std::size_t units);
    [[nodiscard]] bus::TransactionStorage storage();
    [[nodiscard]] std::span<bus::OutstandingResponse> lend() override;

private:
    std::vector<bus::TransactionSlot> slots_;
    std::vector<std::uint8_t> bytes_;  // of the slots, for sending, for receiving
    std::size_t longest_pdu_;
    std::size_t sending_;
    std::size_t most_outstanding_;
    std::vector<bus::OutstandingResponse> outstanding_;
};

}  // namespace takt::poll
