// The blank device of `takt serve`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/numbers.hpp"
#include "takt/serve/bank.hpp"
#include "takt/sim/device.hpp"
#include "takt/wire/function.hpp"

namespace takt::endpoint {

/// One unit with all four areas and every function.
struct BlankSpec {
    struct Range {
        wire::Area area = wire::Area::holding_register;
        serve::AddressRange addresses;
    };
    struct Limit {
        serve::AddressRange addresses;  ///< holding registers
        std::int32_t least = 0;
        std::int32_t greatest = 65535;
    };
    struct File {
        std::uint16_t number = 1;
        std::uint16_t records = 1;
    };
    struct Fifo {
        std::uint16_t address = 0;
        std::vector<std::uint16_t> values;
    };
    struct Object {
        std::uint8_t id = 0;
        std::string text;
    };

    UnitId unit{1};
    sim::Fill fill = sim::Fill::zero;
    std::vector<Range> ranges;  ///< of an area with ranges, only these exist
    std::vector<Range> read_only;
    std::vector<Range> retain;
    std::vector<Limit> limits;
    bool overlay = false;         ///< the coils are the bits of the holding registers
    std::vector<Object> objects;  ///< of identification; of equal ids the first counts
    std::string server_id = "takt";
    std::vector<File> files;
    std::vector<Fifo> fifos;
    bool may_restart = false;
    bool may_listen_only = false;
    std::optional<std::uint16_t> status_coils;
};

}  // namespace takt::endpoint
