// The lines of the project with their devices, in front of the program that runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "clock.hpp"
#include "field.hpp"
#include "scenario.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::gatewaysim {

/// The program on the lines. Absent while it does not run.
class LineOwner {
public:
    [[nodiscard]] virtual Engine& engine(std::size_t line) = 0;
    virtual void on_link(Instant t, std::size_t line, bool up) = 0;
    [[nodiscard]] virtual bool must_reconnect(std::size_t line) = 0;

protected:
    ~LineOwner() = default;
};

/// The devices go on when the program ends; its link to them does not.
class Bus {
public:
    /// @param ordered_at  when the last request left the program
    using Written = std::function<void(std::uint32_t value, Instant ordered_at)>;

    Bus(const Scenario& scenario, Written written);
    ~Bus();

    void start(Instant t, LineOwner& owner);
    void stop(Instant t);
    [[nodiscard]] Instant next_wakeup() const;
    void advance(Instant t);
    void poke(std::size_t line, Instant t);
    [[nodiscard]] std::uint64_t frames() const { return frames_; }

private:
    class Port;

    void add_line(const Scenario& scenario, std::size_t index);

    Field field_;
    Written written_;
    LineOwner* owner_ = nullptr;
    std::uint64_t frames_ = 0;
    std::vector<std::unique_ptr<Port>> ports_;
    std::vector<std::unique_ptr<sim::SimulatedLine>> lines_;
};

}  // namespace takt::gatewaysim
