// The work of an output that cannot begin: its samples wait in the journal.
#pragma once

#include <string>
#include <utility>

#include "takt/publish/output_work.hpp"

namespace takt::publish {

class UnusableWork final : public OutputWork {
public:
    UnusableWork(std::string destination, std::string failure)
        : destination_(std::move(destination)), failure_(std::move(failure)) {}

    void begin(Instant, store::Journal&, store::DestinationId) override {}
    void work(Instant) override {}
    [[nodiscard]] Instant next_wakeup() const override { return kNever; }
    [[nodiscard]] std::span<const int> descriptors() const override { return {}; }
    void on_state_changed(Instant) override {}
    [[nodiscard]] bool takes_records() const override { return false; }
    void stop(Instant) override {}
    [[nodiscard]] bool stopped() const override { return true; }
    void report(Instant, OutputStatus& status) const override {
        status.state = OutputState::stopped;
        status.destination = destination_;
        status.failure = failure_;
    }

private:
    std::string destination_;
    std::string failure_;
};

}  // namespace takt::publish
