// A random project before it is written down: the random decisions, in their order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "takt/sim/random.hpp"

namespace takt::simtest {

/// One mapping of a project file: keys with their texts.
using Keys = std::vector<std::pair<std::string, std::string>>;

struct VariableBlueprint {
    Keys keys;
    int period_ms = 0;  ///< 0: the device's
};

struct DeviceBlueprint {
    Keys keys;
    int period_ms = 1000;
    std::vector<VariableBlueprint> variables;
};

struct LineBlueprint {
    Keys keys;
    bool relayed = false;         ///< a server relays to it
    int response_timeout_ms = 0;  ///< of what is relayed
    std::vector<DeviceBlueprint> devices;
};

struct Blueprint {
    Keys keys;
    std::vector<LineBlueprint> lines;
    std::vector<Keys> locals;
};

/// Whether devices with gaps: learn are tried in the run of that seed; else exactly one plan is run.
[[nodiscard]] bool gaps_are_learnt(std::uint64_t seed);

/// @param seed  nothing else goes in
[[nodiscard]] Blueprint draw_blueprint(std::uint64_t seed);

/// The project file; all periods are multiplied by `slower`.
[[nodiscard]] std::string to_yaml(const Blueprint& blueprint, int slower);

/// The properties with which the variables of one device are drawn.
struct DeviceTraits {
    bool mask_writes = false;    ///< fc22
    bool modifies = false;       ///< read_modify_write
    bool gaps_readable = false;  ///< items between the variables exist too
    bool optimal = false;
    std::string prefix;  ///< of the names
};

/// Draws the variables of one device.
class VariableDrawer {
public:
    VariableDrawer(sim::Random& random, const DeviceTraits& traits, std::size_t triggers,
                   std::size_t statuses)
        : random_(random), traits_(traits), triggers_(triggers), statuses_(statuses) {}

    [[nodiscard]] std::vector<VariableBlueprint> draw(std::size_t count);

private:
    void add_registers();
    void add_bits();
    void add_coils();
    void add_gap(const std::string& area, int size);
    [[nodiscard]] bool chance(std::uint32_t percent) { return random_.below(100) < percent; }
    [[nodiscard]] VariableBlueprint& begin(const std::string& type);
    void add_reading(Keys& keys, const std::string& function);
    void add_writing(Keys& keys, const std::string& function);
    static void add_default(Keys& keys);
    void add_values(Keys& keys, const std::string& type);

    sim::Random& random_;
    DeviceTraits traits_;
    std::size_t triggers_;
    std::size_t statuses_;
    int next_[4] = {};  // coils, discrete inputs, input registers, holding registers
    std::vector<VariableBlueprint> made_;
};

}  // namespace takt::simtest
