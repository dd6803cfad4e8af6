#include "takt/host/traffic_tap.hpp"

#include <utility>

#include "engine/host_link.hpp"
#include "engine/traffic_publisher.hpp"
#include "sessions/record_codec.hpp"

namespace takt::host {

TrafficTap::TrafficTap() : link_(std::make_shared<HostLink>()) {
    link_->taps = 1;
}

TrafficTap::~TrafficTap() = default;

line::TrafficFactory TrafficTap::factory() {
    return [link = link_.get()](const model::Line& line) -> std::shared_ptr<wire::TrafficObserver> {
        const TrafficSource source{TrafficSource::Kind::endpoint, link->add_endpoint_line(line)};
        return std::make_shared<TrafficPublisher>(*link, source, 0);
    };
}

TrafficTap::Reader::Reader(std::shared_ptr<const HostLink> link)
    : link_(std::move(link)), cursor_(link_->traffic.begin()) {}

std::optional<TrafficRecord> TrafficTap::Reader::next() {
    if (!link_->traffic.read(cursor_, record_)) return std::nullopt;
    return decode_traffic(record_);
}

std::optional<model::Line> TrafficTap::Reader::line_of(const TrafficRecord& record) const {
    return link_->line_of(record.source, record.generation);
}

}  // namespace takt::host
