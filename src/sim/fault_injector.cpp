#include "takt/sim/fault_injector.hpp"

namespace takt::sim {

FaultInjector::FaultInjector(const model::Line&, Devices& devices, const FaultPlan& plan,
                             FaultObserver* observer)
    : devices_(devices), plan_(plan), observer_(observer), random_(plan.seed) {}

std::optional<std::size_t> FaultInjector::index_of(UnitId unit) const {
    for (std::size_t i = 0; i < devices_.size(); ++i)
        if (devices_[i].address() == unit) return i;
    return {};
}

const FaultRates& FaultInjector::rates_of(std::size_t device) const {
    return device < plan_.devices.size() ? plan_.devices[device] : plan_.rates;
}

void FaultInjector::count(Instant t, FaultKind kind, std::optional<std::size_t> device) {
    ++counts_.injected[static_cast<std::size_t>(kind)];
    if (observer_) observer_->on_fault({t, kind, device, {}});
}

serve::Answer FaultInjector::handle(const serve::Context& context, Bytes pdu) {
    const auto device = index_of(context.unit);
    if (context.broadcast || !device || context.time >= plan_.quiet_from)
        return devices_.handle(context, pdu);
    ++counts_.exchanges;
    const auto per_million = [&](FaultKind kind) {
        return rates_of(*device).per_million[static_cast<std::size_t>(kind)];
    };
    if (random_.chance(per_million(FaultKind::lost_request))) {
        count(context.time, FaultKind::lost_request, device);
        return {};
    }
    serve::Answer answer = devices_.handle(context, pdu);
    if (*device < plan_.turnarounds.size() && plan_.turnarounds[*device])
        answer.delay = plan_.turnarounds[*device]->draw(random_);
    if (random_.chance(per_million(FaultKind::lost_response))) {
        count(context.time, FaultKind::lost_response, device);
        return {};
    }
    return answer;
}

}  // namespace takt::sim
