// One simulated slave.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/serve/server.hpp"
#include "takt/sim/device_observer.hpp"
#include "takt/sim/fill.hpp"
#include "takt/sim/pattern.hpp"
#include "takt/sim/value_source.hpp"
#include "takt/value/codec.hpp"
#include "takt/wire/function.hpp"

namespace takt::sim {

/// The behaviour of a device. It may change at any time between calls of the engines.
struct Behaviour {
    /// Existing addresses that are refused.
    struct Refusal {
        wire::Area area = wire::Area::holding_register;
        serve::AddressRange addresses;
        wire::ExceptionCode code = wire::ExceptionCode::illegal_data_address;
    };

    Duration turnaround{};  ///< from the end of a request to the first character of its answer; the line's
                            ///< t3.5 at least
    bool dead = false;      ///< answers nothing, does nothing
    std::optional<wire::ExceptionCode> refuses_all;
    std::vector<Refusal> refusals;
};

/// Banks with moving values. Written variables keep their written value.
/// Not movable in memory: its unit() refers to it.
class Device final : public serve::UnitHooks {
public:
    /// A device of a project. Only the addresses of its variables exist, used or not; with gaps: always also
    /// the readable ones between them.
    /// @param moving  values follow their patterns; else all are 0 until written
    explicit Device(const model::Device& device, bool moving = true);

    /// All four areas of 65536 each.
    Device(UnitId unit, Fill fill);

    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    Behaviour behaviour;

    /// Takes the values from `source`, which outlives it, instead of the patterns; nullptr: the patterns
    /// again.
    void set_source(const ValueSource* source) { source_ = source; }

    /// Takes the values of variables from `model`, which outlives it, and reports writes of numbers and bools
    /// to it; nullptr: the patterns again.
    void set_model(PlantModel* model) { model_ = model; }

    /// For a server; refers to this device.
    [[nodiscard]] serve::Unit unit();
    [[nodiscard]] UnitId address() const { return address_; }
    [[nodiscard]] const std::string& name() const { return name_; }

    /// At most one, outlives the device; nullptr: none.
    void set_observer(DeviceObserver* observer) { observer_ = observer; }
    [[nodiscard]] DeviceObserver* observer() const { return observer_; }

    /// Sets items (bits: 0 and 1) from outside. Patterns no longer change them.
    /// @returns false, without a change, if some of them do not exist
    bool change(Instant t, wire::Area area, std::uint16_t start, std::span<const std::uint16_t> values);

    /// The items as a request would read them at that time; nothing if some of them do not exist.
    [[nodiscard]] std::optional<std::vector<std::uint16_t>> content(Instant t, wire::Area area,
                                                                    std::uint16_t start, std::uint16_t count);

    /// Restores the initial state: written and changed items are 0 or follow their patterns again; a blank
    /// device is filled again.
    void forget(Instant t);

    // UnitHooks
    std::optional<wire::ExceptionCode> before(const serve::Context& context,
                                              const serve::Access& access) override;
    void written(const serve::Context& context, const serve::Access& access) override;

private:
    struct Variable {
        std::uint16_t start = 0;
        std::uint16_t count = 1;
        Pattern pattern;
        DataType type;
        ByteOrder order;
        std::optional<std::uint8_t> bit;  // of a bool in a register
        bool held = false;                // was written
        std::string_view name;
        double scale;  // of the values of a model
        double offset;
    };
    struct AreaData {
        std::vector<Variable> variables;  // by start
        std::vector<serve::AddressRange> offered;
        std::vector<std::uint16_t> registers;
        std::vector<std::uint8_t> bits;
        std::uint32_t count = 0;
        std::uint16_t longest = 1;  // of the variables
        std::vector<bool> held;     // items that were written, by their distance from the first one
    };

    void lay_out(const model::Device& device, wire::Area area);
    void fill(Fill fill);
    [[nodiscard]] std::span<Variable> touching(wire::Area area, std::uint16_t start, std::uint16_t count);
    void refresh(wire::Area area, const Variable& variable, Instant t);
    [[nodiscard]] static value::Layout layout_of(const Variable& variable);
    [[nodiscard]] value::Value now(const Variable& variable, value::Layout& layout, Instant t) const;
    void tell_model(wire::Area area, const Variable& variable, Instant t);
    void follow_source(const serve::Access& access, Instant t);
    [[nodiscard]] std::span<const std::uint16_t> items(wire::Area area, std::uint16_t start,
                                                       std::uint16_t count);
    void hold(wire::Area area, std::uint16_t start, std::uint16_t count);
    void tell_change(Instant t, wire::Area area, std::uint16_t start, std::uint16_t count);
    [[nodiscard]] AreaData& of(wire::Area area) { return areas_[static_cast<std::size_t>(area)]; }
    [[nodiscard]] serve::BitBank bit_bank(wire::Area area);
    [[nodiscard]] serve::RegisterBank register_bank(wire::Area area);

    std::string name_;
    UnitId address_;
    DeviceObserver* observer_ = nullptr;
    bool moving_ = false;
    Fill fill_ = Fill::zero;
    std::vector<std::uint16_t> reported_;  // values on their way to the observer
    std::vector<std::string> names_;       // referred to by the patterns
    std::array<AreaData, 4> areas_;
    const ValueSource* source_ = nullptr;
    PlantModel* model_ = nullptr;
};

}  // namespace takt::sim
