// The unit that a BlankSpec describes.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "takt/endpoint/blank_spec.hpp"
#include "takt/serve/server.hpp"
#include "takt/sim/devices.hpp"
#include "unit_functions.hpp"

namespace takt::endpoint {

/// Address ranges by wire::Area.
using RangesByArea = std::array<std::vector<serve::AddressRange>, 4>;

/// Sorted, without overlaps.
[[nodiscard]] RangesByArea by_area(const std::vector<BlankSpec::Range>& ranges);

/// All four areas, laid out by the spec, and every function. Does not move in memory.
class BlankUnit final : public serve::Responder {
public:
    /// @param spec  need not outlive it
    explicit BlankUnit(const BlankSpec& spec);
    BlankUnit(const BlankUnit&) = delete;
    BlankUnit& operator=(const BlankUnit&) = delete;

    [[nodiscard]] bool serves(UnitId unit) const override { return devices_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context,
                                       const wire::RequestView& request) override {
        return devices_.handle(context, request);
    }
    void on_line_event(serve::LineEvent event) override { devices_.on_line_event(event); }

    /// The one unit.
    [[nodiscard]] std::span<serve::Unit> units() { return devices_.units(); }

private:
    void lay_out(serve::Unit& unit);
    void identify();
    void fill_files();

    BlankSpec spec_;
    sim::Devices devices_;
    RangesByArea offered_;
    RangesByArea read_only_;
    std::array<std::vector<serve::ValueLimits>, 4> limits_;  // by wire::Area
    UnitFunctions functions_;
};

}  // namespace takt::endpoint
