#include "takt/console/tap_source.hpp"

namespace takt::console {

TapSource tap_source(const std::shared_ptr<host::Session>& session) {
    return {.next = [session] { return session->next_traffic(); },
            .missed = [session] { return session->missed_traffic(); },
            .line_of = [session](const auto& record) { return session->line_of(record); }};
}

TapSource tap_source(const host::TrafficTap& tap) {
    const auto reader = std::make_shared<host::TrafficTap::Reader>(tap.reader());
    return {.next = [reader] { return reader->next(); },
            .missed = [reader] { return reader->missed(); },
            .line_of = [reader](const auto& record) { return reader->line_of(record); }};
}

}  // namespace takt::console
