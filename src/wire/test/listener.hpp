// The owner of a framer in tests: records what the framer reports.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bytes.hpp"
#include "takt/wire/framer.hpp"

namespace takt::wire {

/// Feeds a framer as an engine does. Frames are noted as "10: 03 00 00 00 02", faults as "!checksum".
class Listener {
public:
    explicit Listener(const FramerConfig& config, bool stream = false) : framer_(config, stream) {}

    /// Calls expect_more() after every frame of a unit above this one.
    void own_units_up_to(int unit) { last_own_ = unit; }

    void bytes(Instant t, Bytes bytes) {
        int idle_steps = 0;
        while (!bytes.empty()) {
            const ExactBytes exact(bytes);
            const FramerStep step = framer_.push(t, exact);
            idle_steps = step.consumed == 0 ? idle_steps + 1 : 0;
            ASSERT_LE(idle_steps, 1) << "a step without progress must not come twice";
            note(step);
            bytes = bytes.subspan(step.consumed);
        }
    }
    void hex(Instant t, std::string_view text) { bytes(t, from_hex(text)); }
    void text(Instant t, std::string_view text) { bytes(t, ByteVector(text.begin(), text.end())); }
    void tick(Instant t) { note(framer_.on_tick(t)); }

    /// The reports since the last call.
    std::vector<std::string> reports() { return std::exchange(reports_, {}); }
    Framer& framer() { return framer_; }

private:
    void note(const FramerStep& step) {
        if (step.complete) {
            const Frame frame = framer_.frame();
            const std::uint8_t unit[] = {frame.unit.value};
            reports_.push_back(to_hex(unit) + ": " + to_hex(frame.pdu));
            if (frame.unit.value > last_own_) framer_.expect_more();
        }
        if (step.fault != FrameFault::none) reports_.push_back("!" + std::string(name(step.fault)));
        EXPECT_FALSE(step.complete && step.fault != FrameFault::none);
    }

    StandaloneFramer framer_;
    int last_own_ = 255;
    std::vector<std::string> reports_;
};

using Reports = std::vector<std::string>;

}  // namespace takt::wire
