// Big-endian words in PDUs.
#pragma once

#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/serve/answer.hpp"

namespace takt::serve {

/// @param at  at + 1 < bytes.size()
inline std::uint16_t word(Bytes bytes, std::size_t at) {
    return static_cast<std::uint16_t>(bytes[at] << 8 | bytes[at + 1]);
}

inline void put_word(wire::Pdu& pdu, unsigned value) {
    pdu.push_back(static_cast<std::uint8_t>(value >> 8));
    pdu.push_back(static_cast<std::uint8_t>(value));
}

/// Replaces the content by an exception.
inline void refuse(Answer& answer, const wire::RequestView& request, wire::ExceptionCode code) {
    answer.pdu.clear();
    answer.pdu.push_back(wire::exception_function(request.pdu()[0]));
    answer.pdu.push_back(static_cast<std::uint8_t>(code));
}

}  // namespace takt::serve
