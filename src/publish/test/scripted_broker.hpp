// A broker that answers each connection with given bytes, and ignores the contents of requests.
#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "broker_process.hpp"

namespace takt::publish {

/// CONNACK of MQTT 5 with success.
inline const std::string kAccepted("\x20\x03\x00\x00\x00", 5);
/// At the end of a script: the connection stays open until the client closes it.
inline const std::string kStaysOpen = "<open>";

class ScriptedBroker {
public:
    /// @param scripts  one for each connection, sent after its first bytes; then the connection is closed
    explicit ScriptedBroker(std::vector<std::string> scripts)
        : scripts_(std::move(scripts)), listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address = loopback(0);
        socklen_t length = sizeof address;
        bind(listener_, reinterpret_cast<sockaddr*>(&address), length);
        getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &length);
        port_ = ntohs(address.sin_port);
        listen(listener_, 16);
        thread_ = std::thread([this] { run(); });
    }
    ~ScriptedBroker() {
        shutdown(listener_, SHUT_RDWR);
        thread_.join();
        close(listener_);
        for (const int fd : open_) close(fd);
    }
    ScriptedBroker(const ScriptedBroker&) = delete;
    ScriptedBroker& operator=(const ScriptedBroker&) = delete;

    [[nodiscard]] std::uint16_t port() const { return port_; }
    [[nodiscard]] std::size_t connections() const { return connections_; }

private:
    void run() {
        for (const auto& script : scripts_) {
            const int fd = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
            if (fd < 0) return;
            ++connections_;
            char buffer[4096];
            if (recv(fd, buffer, sizeof buffer, 0) > 0) answer(fd, script);
        }
    }
    void answer(int fd, std::string script) {
        const bool stays = script.ends_with(kStaysOpen);
        if (stays) script.resize(script.size() - kStaysOpen.size());
        send(fd, script.data(), script.size(), MSG_NOSIGNAL);
        if (stays)
            open_.push_back(fd);
        else
            close(fd);
    }

    std::vector<std::string> scripts_;
    int listener_;
    std::uint16_t port_ = 0;
    std::atomic<std::size_t> connections_ = 0;
    std::vector<int> open_;
    std::thread thread_;
};

}  // namespace takt::publish
