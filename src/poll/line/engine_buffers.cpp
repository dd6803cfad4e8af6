#include "line/engine_buffers.hpp"

#include <algorithm>

#include "takt/wire/pdu.hpp"

namespace takt::poll {

EngineBuffers::EngineBuffers(const bus::LineConfig& config, std::size_t longest_pdu, std::size_t units)
    : slots_(config.framing == wire::Framing::tcp
                 ? std::clamp<std::size_t>(config.in_flight, 1, bus::kMaxInFlight)
                 : 1),
      longest_pdu_(config.framing == wire::Framing::tcp ? longest_pdu : wire::kMaxPdu),
      sending_(bus::TransactionStorage::sending_size(config.framing, longest_pdu_)) {
    bytes_.resize(slots_.size() * longest_pdu_ + sending_ +
                  bus::TransactionStorage::receiving_size(config.framing, longest_pdu_));
    // Over TCP they only measure delays; on a serial line several of each unit may be outstanding.
    constexpr std::size_t kFew = 8;
    constexpr std::size_t kOfUnit = 4;
    most_outstanding_ = config.framing == wire::Framing::tcp ? kFew : kFew + kOfUnit * units;
}

bus::TransactionStorage EngineBuffers::storage() {
    const std::span bytes(bytes_);
    const std::size_t pdus = slots_.size() * longest_pdu_;
    return {.slots = slots_,
            .pdus = bytes.first(pdus),
            .sending = bytes.subspan(pdus, sending_),
            .receiving = bytes.subspan(pdus + sending_),
            .outstanding = {},
            .longest_pdu = longest_pdu_,
            .on_demand = this};
}

std::span<bus::OutstandingResponse> EngineBuffers::lend() {
    outstanding_.resize(most_outstanding_);
    return outstanding_;
}

}  // namespace takt::poll
