// A mosquitto of the test, on a free port, and programs beside it.
#pragma once

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "folder.hpp"

namespace takt::publish {

using namespace std::chrono_literals;

/// A program that runs until it is ended or killed. Its output goes to a file.
class Process {
public:
    /// @param input  descriptor for the standard input; -1: that of the test
    Process(const std::vector<std::string>& words, const std::string& output, int input = -1) {
        std::vector<char*> arguments;
        for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        pid_ = fork();
        if (pid_ != 0) return;
        const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
        if (input >= 0) dup2(input, 0);
        dup2(file, 1);
        dup2(file, 2);
        execvp(arguments[0], arguments.data());
        _exit(127);
    }
    ~Process() { end(SIGKILL); }
    Process(Process&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
    Process& operator=(Process&& other) noexcept {
        std::swap(pid_, other.pid_);
        return *this;
    }

    void send(int signal) const { kill(pid_, signal); }
    /// Sends the signal, once a second, and waits for the end: mosquitto forgets one that it gets while it
    /// starts.
    void end(int signal) {
        constexpr int kSecond = 100;
        for (int polls = 0; pid_ > 0; ++polls) {
            if (polls % kSecond == 0) send(signal);
            if (waitpid(pid_, nullptr, WNOHANG) != 0)
                pid_ = -1;
            else
                std::this_thread::sleep_for(10ms);
        }
    }
    /// @returns the exit status
    int wait() {
        int status = -1;
        if (pid_ > 0) waitpid(std::exchange(pid_, -1), &status, 0);
        return status;
    }

private:
    pid_t pid_ = -1;
};

inline sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

/// A port that nothing listens on.
inline std::uint16_t free_port() {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address = loopback(0);
    socklen_t length = sizeof address;
    bind(fd, reinterpret_cast<sockaddr*>(&address), length);
    getsockname(fd, reinterpret_cast<sockaddr*>(&address), &length);
    close(fd);
    return ntohs(address.sin_port);
}

inline bool is_listening(std::uint16_t port) {
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    const sockaddr_in address = loopback(port);
    const bool connected = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(fd);
    return connected;
}

class TestBroker {
public:
    /// @param settings  further lines of the configuration
    explicit TestBroker(const std::string& settings = "allow_anonymous true\n") : port_(free_port()) {
        configure(settings);
        start();
    }

    void configure(const std::string& settings) {
        folder_.write("broker.conf",
                      "user root\nlistener " + std::to_string(port_) + " 127.0.0.1\n" + settings);
    }
    void start() {
        const char* installed = "/usr/sbin/mosquitto";  // not in the path of every user
        const std::string program = access(installed, X_OK) == 0 ? installed : "mosquitto";
        process_.emplace_back(std::vector<std::string>{program, "-c", folder_ / "broker.conf"},
                              folder_ / "broker.log");
        for (int i = 0; i < 500 && !is_listening(port_); ++i) std::this_thread::sleep_for(10ms);
        ASSERT_TRUE(is_listening(port_)) << folder_.read("broker.log");
    }
    void end(int signal) {
        process_.back().end(signal);
        process_.clear();
    }
    void send(int signal) const { process_.back().send(signal); }

    /// mosquitto_sub or mosquitto_pub with further words. Its output goes to a file of the folder.
    Process client(const std::string& program, const std::vector<std::string>& words,
                   const std::string& output) const {
        std::vector<std::string> all{program, "-h", "127.0.0.1", "-p", std::to_string(port_)};
        all.insert(all.end(), words.begin(), words.end());
        return {all, folder_ / output};
    }

    [[nodiscard]] std::uint16_t port() const { return port_; }
    [[nodiscard]] const test::Folder& folder() const { return folder_; }

private:
    test::Folder folder_;
    std::uint16_t port_;
    std::vector<Process> process_;
};

}  // namespace takt::publish
