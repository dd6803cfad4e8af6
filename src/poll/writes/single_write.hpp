// The write of one variable without its group.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "line/transfer.hpp"
#include "takt/bus/health.hpp"
#include "takt/model/project.hpp"
#include "takt/wire/prepared_request.hpp"
#include "writes/read_back.hpp"

namespace takt::poll {

/// How one variable is written alone, and its retries.
struct SingleWrite {
    wire::PreparedRequest request;  ///< of a read-modify-write: its read
    RegisterBits bits;              ///< of a bit of a register
    wire::Function function = wire::Function::write_multiple_registers;
    bool modifies = false;                 ///< a read-modify-write
    std::unique_ptr<ReadBack> verify;      ///< if the variable has `verify`
    std::optional<std::size_t> bucket_of;  ///< the group whose bucket it passes; nothing: that of the line
    bool admitted = false;                 ///< by that bucket, or started with the admission of the line
    std::uint16_t failures = 0;
    bus::Backoff busy = bus::busy_backoff();
    Instant not_before = Instant::min();
};

/// A bit of a register is written with 0x16 or by read-modify-write, as the device supports.
/// @returns unsupported (subject: name) if the device supports neither; what making the request returns
[[nodiscard]] Result<SingleWrite> single_write_of(const model::Device& device,
                                                  const model::Variable& variable, const Written& written);

/// The write that follows the read of a read-modify-write.
/// @param old  the register as read
[[nodiscard]] wire::Request second_step(const SingleWrite& write, const model::Variable& variable,
                                        std::uint16_t old);

}  // namespace takt::poll
