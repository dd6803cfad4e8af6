// The bytes of one connection to a broker: TCP, with TLS where the broker has it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "mqtt/broker_tls.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/publish/mqtt_port.hpp"

namespace takt::publish {

/// An attempt to connect to one address, and the connection that it becomes. The owner waits for events() on
/// fd() and then calls advance(), read() and write(). No function blocks. One thread.
class BrokerStream {
public:
    enum class State : std::uint8_t {
        connecting,
        handshake,  ///< of TLS
        open,
        ended,  ///< nothing more can be read: see failure()
    };

    /// Begins to connect.
    /// @param address  numeric
    BrokerStream(const MqttBroker& broker, const std::string& address);
    /// Closes the connection.
    ~BrokerStream();
    BrokerStream(const BrokerStream&) = delete;
    BrokerStream& operator=(const BrokerStream&) = delete;

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] bool is_open() const { return state_ == State::open; }
    /// The broker's host accepted the TCP connection.
    [[nodiscard]] bool is_reached() const { return reached_; }
    /// Of a stream that has ended; none: the broker closed the connection.
    [[nodiscard]] const std::optional<MqttFailure>& failure() const { return failure_; }

    /// It is open, or was so before its end.
    [[nodiscard]] bool was_open() const { return was_open_; }

    [[nodiscard]] int fd() const { return socket_.get(); }
    /// Events to wait for, as for poll().
    [[nodiscard]] short events(bool to_read, bool to_write) const;

    /// Continues to connect.
    void advance();
    /// @returns bytes read; 0: none are there, or the stream has ended
    std::size_t read(std::span<char> buffer);
    /// @returns bytes that need not be written again: after an error all of them, as read() finds the cause
    std::size_t write(std::string_view bytes);

private:
    struct Free {
        void operator()(SSL* client) const;
    };

    void connect(const std::string& address, std::uint16_t port);
    void connected();
    void open();
    void fail(MqttFailureKind kind, std::string text);
    void fail_with(int error);
    void shake_hands();
    std::size_t read_plain(std::span<char> buffer);
    std::size_t read_tls(std::span<char> buffer);
    std::size_t write_tls(std::string_view bytes);

    os::Descriptor socket_;
    std::unique_ptr<BrokerTls> tls_;
    std::unique_ptr<SSL, Free> client_;
    State state_ = State::connecting;
    bool reached_ = false;
    bool was_open_ = false;
    short blocked_on_ = 0;  // what TLS waits for, whether it reads or writes
    std::optional<MqttFailure> failure_;
};

/// What an error of a socket means for a connection.
[[nodiscard]] MqttFailureKind kind_of_errno(int error);

}  // namespace takt::publish
