// The connection of a probe to a real device.
#pragma once

#include "takt/bus/device_probe.hpp"
#include "takt/client/client.hpp"

namespace takt::client {

class ProbeConnection final : public bus::ProbeConnection {
public:
    /// @param client  outlives it
    explicit ProbeConnection(Client& client) : client_(client) {}

    Result<int> transact(const wire::PreparedRequest& request) override;
    void pause(Duration time) override { client_.pause(time); }
    [[nodiscard]] bool interrupted() const override { return client_.interrupted(); }

private:
    Client& client_;
};

}  // namespace takt::client
