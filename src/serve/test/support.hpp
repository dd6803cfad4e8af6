// Shared by the tests of this module: frames as hex strings, a unit with storage of its own.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hex.hpp"
#include "takt/base/engine.hpp"
#include "takt/serve/server.hpp"
#include "takt/wire/frame.hpp"

namespace takt::serve {

inline std::vector<std::uint8_t> bytes(std::string_view hex) {
    return test::from_hex(hex);
}
inline std::string hex(Bytes data) {
    return test::to_hex(data);
}

inline std::string frame(wire::Framing framing, std::uint8_t unit, std::string_view pdu,
                         std::uint16_t transaction = 0) {
    return hex(wire::encode_frame(framing, UnitId{unit}, transaction, bytes(pdu)).span());
}
inline std::string rtu(std::uint8_t unit, std::string_view pdu) {
    return frame(wire::Framing::rtu, unit, pdu);
}
inline std::string tcp(std::uint16_t transaction, std::uint8_t unit, std::string_view pdu) {
    return frame(wire::Framing::tcp, unit, pdu, transaction);
}

/// All four areas from address 0: coils and discrete inputs off, input registers holding 1000 + address,
/// holding registers holding their address.
struct Storage {
    explicit Storage(std::size_t size = 1024)
        : coils((size + 7) / 8), discrete((size + 7) / 8), input(size), holding(size) {
        for (std::size_t i = 0; i < size; ++i) {
            input[i] = static_cast<std::uint16_t>(1000 + i);
            holding[i] = static_cast<std::uint16_t>(i);
        }
    }
    Banks banks() {
        const auto count = static_cast<std::uint32_t>(input.size());
        return {{0, count, coils, {}, {}},
                {0, count, discrete, {}, {}},
                {0, input, {}, {}},
                {0, holding, {}, {}}};
    }
    friend bool operator==(const Storage&, const Storage&) = default;

    std::vector<std::uint8_t> coils, discrete;
    std::vector<std::uint16_t> input, holding;
};

}  // namespace takt::serve
