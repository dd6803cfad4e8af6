#include "line_faults.hpp"

#include <utility>

#include "serial_faults.hpp"
#include "stream_faults.hpp"

namespace takt::sim {

std::function<std::unique_ptr<LineFaults>(const model::Line&, Devices&)> faults_of(FaultPlan plan,
                                                                                   FaultObserver* observer) {
    return [plan = std::move(plan), observer](const model::Line& line,
                                              Devices& devices) -> std::unique_ptr<LineFaults> {
        if (line.is_serial()) return std::make_unique<SerialFaults>(line, devices, plan, observer);
        return std::make_unique<StreamFaults>(line, devices, plan, observer);
    };
}

const FaultCounts& fault_counts(const SimulatedLine& line) {
    return static_cast<const FaultInjector*>(line.faults())->counts();
}

}  // namespace takt::sim
