// Carries out a FaultPlan on one simulated line.
#pragma once

#include <cstdint>
#include <optional>

#include "takt/model/project.hpp"
#include "takt/sim/devices.hpp"
#include "takt/sim/faults.hpp"

namespace takt::sim {

/// Stands between the line's engines and its devices. Made and driven by SimulatedLine.
class FaultInjector final : public serve::Responder {
public:
    /// @param line     need not outlive it
    /// @param devices  outlive it, in the order of the line
    FaultInjector(const model::Line& line, Devices& devices, const FaultPlan& plan, FaultObserver* observer);

    [[nodiscard]] const FaultCounts& counts() const { return counts_; }

    [[nodiscard]] bool serves(UnitId unit) const override { return devices_.serves(unit); }
    [[nodiscard]] serve::Answer handle(const serve::Context& context, Bytes pdu) override;

private:
    [[nodiscard]] std::optional<std::size_t> index_of(UnitId unit) const;
    [[nodiscard]] const FaultRates& rates_of(std::size_t device) const;
    void count(Instant t, FaultKind kind, std::optional<std::size_t> device);

    Devices& devices_;
    FaultPlan plan_;
    FaultObserver* observer_;
    Random random_;
    FaultCounts counts_;
};

}  // namespace takt::sim
