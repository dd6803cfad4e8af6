// The blank device of `takt serve` as its options describe it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/app/commands.hpp"
#include "takt/sim/devices.hpp"
#include "unit_functions.hpp"

namespace takt::app {

/// Values of the options, as they are typed; nothing: they cannot be read so. Numbers are decimal or 0x.
std::optional<BlankLayout::Range> parse_item_range(std::string_view text);    ///< "holding:0..99", "coils:7"
std::optional<BlankLayout::Limit> parse_value_limits(std::string_view text);  ///< "holding:0..9=-5..100"
std::optional<BlankLayout::File> parse_file_records(std::string_view text);   ///< "4:100": number, records
std::optional<BlankLayout::Fifo> parse_fifo(std::string_view text);           ///< "1246:440,4740"
std::optional<BlankLayout::Object> parse_object(std::string_view text);       ///< "0x80=text"

/// All four areas, laid out as asked for, and every function. Does not move in memory.
class BlankDevice {
public:
    /// @param options  need not outlive it
    explicit BlankDevice(const ServeOptions& options);
    BlankDevice(const BlankDevice&) = delete;
    BlankDevice& operator=(const BlankDevice&) = delete;

    [[nodiscard]] sim::Devices& devices() { return devices_; }
    /// What answers for it.
    [[nodiscard]] serve::Unit& unit() { return *devices_.unit(devices_[0].address()); }
    /// What of it is to be kept, by wire::Area.
    [[nodiscard]] std::array<std::vector<serve::AddressRange>, 4> retained() const;

private:
    void lay_out(serve::Unit& unit);
    void identify();
    void fill_files(sim::Fill fill);

    BlankLayout layout_;
    sim::Devices devices_;
    std::array<std::vector<serve::AddressRange>, 4> offered_;    // by wire::Area
    std::array<std::vector<serve::AddressRange>, 4> read_only_;  // likewise
    std::array<std::vector<serve::ValueLimits>, 4> limits_;      // likewise
    UnitFunctions functions_;
};

}  // namespace takt::app
