// Queues of registers: function 24 (MODBUS Application Protocol V1.1b3, section 6.18).
#pragma once

#include <cstdint>
#include <span>

#include "takt/serve/server.hpp"

namespace takt::serve {

struct Fifo {
    std::uint16_t address = 0;              ///< the pointer register that names the queue
    std::span<const std::uint16_t> values;  ///< oldest first; owned and removed by the caller
};

/// Answers function 24 from queues. Reading removes nothing. An address without a queue is exception 2; a
/// queue of more than 31 values is exception 3.
class Fifos final : public Extension {
public:
    static constexpr std::size_t kMostValues = 31;

    /// @param fifos  live as long as the extension; may change between calls
    explicit Fifos(std::span<const Fifo> fifos) : fifos_(fifos) {}

    bool handle(Unit& unit, const Context& context, const wire::RequestView& request,
                Answer& answer) override;

private:
    std::span<const Fifo> fifos_;
};

}  // namespace takt::serve
