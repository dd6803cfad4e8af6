// Prints the events of a run to stderr.
#pragma once

#include <cstdint>
#include <string_view>

#include "sim/faults/faults.hpp"
#include "takt/base/engine.hpp"
#include "takt/poll/statistics.hpp"
#include "takt/value/command.hpp"
#include "users.hpp"

namespace takt::simtest {

class Trace {
public:
    explicit Trace(bool on) : on_(on) {}

    /// @param slot     the name of what it is for
    /// @param command  the number a command will have
    void action(Instant t, const Action& action, std::string_view slot, std::uint64_t command) const;
    void outcome(Instant t, std::size_t line, const value::CommandOutcome& outcome) const;
    void frame(Instant t, std::size_t line, bool sent, Bytes bytes) const;
    void sending(Instant t, std::size_t line, const poll::Sending& sending) const;
    void fault(std::size_t line, const sim::FaultEvent& event) const;
    void link(Instant t, std::size_t line, std::string_view state) const;

private:
    bool on_;
};

}  // namespace takt::simtest
