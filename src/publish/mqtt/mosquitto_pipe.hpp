// The pipe between MQTT sessions and brokers on a network: libmosquitto on a thread of its own.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>

#include "takt/publish/mqtt_pipe.hpp"

namespace takt::publish {

/// Executes the actions of one session, and gives its events. It keeps no state beyond the connection: no
/// retries, no queue of messages, no reconnect.
///
/// Names are resolved on a further thread, so that a name service that does not answer delays neither the end
/// of the pipe nor MqttDisconnect. Addresses of a host are tried in their order, each for 5 s if another one
/// follows.
class MosquittoPipe final : public MqttPipe {
public:
    /// @throws std::system_error  no thread or descriptor is left
    MosquittoPipe();
    /// Closes the connection without a DISCONNECT packet: the broker publishes the will. Does not wait for
    /// the network.
    ~MosquittoPipe() override;
    MosquittoPipe(const MosquittoPipe&) = delete;
    MosquittoPipe& operator=(const MosquittoPipe&) = delete;

    /// The session bounds what waits: a window of messages.
    void send(MqttAction&& action) override;
    /// While kMostEvents or kMostEventBytes wait, nothing is read from the network.
    [[nodiscard]] std::optional<MqttEvent> next_event() override;
    [[nodiscard]] int descriptor() const override;

    static constexpr std::size_t kMostEvents = 1024;
    static constexpr std::size_t kMostEventBytes = std::size_t{64} << 10U;

private:
    struct Shared;
    class Thread;

    std::shared_ptr<Shared> shared_;
    std::unique_ptr<Thread> thread_;
};

}  // namespace takt::publish
