// The clients of the brokers that send commands: good ones, stale ones, forbidden ones, repeated ones.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scenario.hpp"
#include "takt/publish/mqtt_port.hpp"
#include "takt/sim/random.hpp"

namespace takt::gatewaysim {

/// A command as its sender means it.
struct SentCommand {
    publish::MqttMessage message;
    std::string id;                      ///< empty: the gateway makes one (a plain value)
    std::string subject;                 ///< a variable or device
    std::optional<std::uint32_t> value;  ///< that no other command has
    bool well_formed = true;
    bool executable = true;  ///< and of something that the project lists
    std::optional<std::int64_t> sent_ns;
    std::optional<std::int64_t> expires_ns;
    std::optional<Duration> expiry;
};

class Senders {
public:
    using Publish = std::function<void(const SentCommand&)>;

    Senders(const Scenario& scenario, Publish publish);

    [[nodiscard]] Instant next() const { return next_; }
    /// @param wall_ns  of the senders' clock, which never jumps
    void act(Instant now, std::int64_t wall_ns);

private:
    void send(std::int64_t wall_ns);
    [[nodiscard]] SentCommand make(std::int64_t wall_ns);
    void add_subject(SentCommand& command);
    void add_expiry(SentCommand& command, std::int64_t wall_ns);
    void compose(SentCommand& command, const std::string& verb);
    [[nodiscard]] const std::string& one_of(const std::vector<std::string>& names);
    [[nodiscard]] bool chance(std::uint32_t percent) { return random_.below(100) < percent; }

    const Scenario& scenario_;
    Publish publish_;
    sim::Random random_;
    Instant next_;
    std::vector<std::string> writable_;  // listed variables of devices
    std::vector<std::string> locals_;    // listed locals of a number
    std::vector<std::string> hidden_;    // not listed
    std::vector<std::string> readable_;
    std::vector<std::string> devices_;  // with poll_enable
    std::deque<SentCommand> last_;
    std::uint32_t count_ = 0;
    bool has_commands_ = false;
};

}  // namespace takt::gatewaysim
