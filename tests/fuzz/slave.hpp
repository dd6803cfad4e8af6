// The device of the slave targets: two units with small areas, and the final request of every input. After
// any bytes, a valid request behind a pause is answered.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "script.hpp"
#include "takt/serve/server.hpp"

namespace takt::fuzz {

inline constexpr std::uint16_t kItems = 40;
inline constexpr std::uint16_t kFirst = 3;  // the areas do not begin at 0

struct Areas {
    std::array<std::uint8_t, (kItems + 7) / 8> coils{};
    std::array<std::uint8_t, (kItems + 7) / 8> inputs{};
    std::array<std::uint16_t, kItems> input_registers{};
    std::array<std::uint16_t, kItems> holding_registers{};

    serve::Banks banks() {
        return {{kFirst, kItems, coils, {}, {}},
                {kFirst, kItems, inputs, {}, {}},
                {kFirst, input_registers, {}, {}},
                {kFirst, holding_registers, {}, {}}};
    }
};

struct Plant {
    Plant() {
        for (std::size_t i = 0; i < units.size(); ++i) {
            units[i].id = UnitId{static_cast<std::uint8_t>(i + 1)};
            units[i].banks = areas[i].banks();
        }
    }
    /// The answer of unit 1 to kQuestion.
    [[nodiscard]] std::vector<std::uint8_t> right_answer() const {
        std::vector<std::uint8_t> pdu{0x03, 4};
        for (std::size_t i = 0; i < 2; ++i) {
            pdu.push_back(static_cast<std::uint8_t>(areas[0].holding_registers[i] >> 8));
            pdu.push_back(static_cast<std::uint8_t>(areas[0].holding_registers[i]));
        }
        return pdu;
    }

    std::array<Areas, 2> areas;
    std::array<serve::Unit, 2> units;
    serve::Server server{units};
};

inline constexpr std::array<std::uint8_t, 5> kQuestion{0x03, 0, kFirst, 0, 2};
inline constexpr std::uint16_t kQuestionId = 0x5AA5;

}  // namespace takt::fuzz
