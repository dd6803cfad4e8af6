#include "attacks.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "load.hpp"

namespace bench {
namespace {

using namespace std::chrono_literals;
using Octets = std::vector<std::uint8_t>;

Octets adu(std::initializer_list<std::uint8_t> pdu) {
    return frame(std::span(pdu.begin(), pdu.size()));
}

Octets times(std::size_t count, const Octets& bytes) {
    Octets all;
    for (; count > 0; --count) all.insert(all.end(), bytes.begin(), bytes.end());
    return all;
}

Octets text(std::string_view words) {
    return {words.begin(), words.end()};
}

/// Ten requests a device must refuse, each for another reason.
Octets malformed() {
    Octets all;
    for (const auto& one : {adu({0x03, 0, 7}), adu({0x00}), adu({0x63, 1, 2, 3}), adu({0x83, 0, 0, 0, 1}),
                            adu({0x03, 0, 0, 0, 0}), adu({0x03, 0xFF, 0xFF, 0, 2}), adu({0x05, 0, 0, 0, 1}),
                            adu({0x10, 0, 0, 0, 2, 2, 0, 1}), adu({0x17, 0, 0, 0, 0x7E, 0, 0, 0, 1, 2, 0, 1}),
                            adu({0x0F, 0, 0, 0, 9, 1, 0xFF})})
        all.insert(all.end(), one.begin(), one.end());
    return all;
}

std::vector<Attack> all_attacks() {
    const Octets read = adu({0x03, 0, 0, 0, 1});
    std::vector<Attack> all;
    all.push_back({"6 surplus bytes", 4, adu({0x03, 0, 7, 0, 1, 0x06, 0, 0, 0xDE, 0xAD}), 0, 4ms});
    all.push_back({"8 a byte each 400 ms", 20, read, 1, 400ms});
    all.push_back({"9 half a header", 50, {read.begin(), read.begin() + 4}, 0, 0ms});
    all.push_back({"13 never reads", 4, times(100, adu({0x03, 0, 0, 0, 125})), 0, 1ms, false});
    all.push_back({"15 HTTP", 4, text("GET / HTTP/1.1\r\nHost: plc\r\n\r\n"), 0, 10ms});
    all.push_back({"15 FF", 4, Octets(1000, 0xFF), 0, 10ms});
    all.push_back({"16 unknown function", 4, adu({0x63}), 0, 4ms});
    all.push_back({"17 bad quantity", 4, adu({0x03, 0, 0, 0x07, 0xD1}), 0, 4ms});
    all.push_back({"27 10 000/s malformed", 4, malformed(), 0, 4ms});
    return all;
}

/// One bad client.
class Bad {
public:
    Bad(const Attack& attack, std::uint16_t port) : attack_(&attack), port_(port) {}
    ~Bad() { close(); }
    Bad(Bad&& other) noexcept
        : attack_(other.attack_), port_(other.port_), fd_(std::exchange(other.fd_, -1)) {}
    Bad(const Bad&) = delete;
    Bad& operator=(const Bad&) = delete;
    Bad& operator=(Bad&&) = delete;

    void act(Clock::time_point now) {
        if (fd_ < 0) connect(now);
        if (fd_ >= 0 && attack_->reads) drain();
        if (fd_ < 0 || now < due_) return;
        due_ = attack_->every > 0us ? std::max(due_ + attack_->every, now - 10ms) : Clock::time_point::max();
        say();
    }

private:
    void connect(Clock::time_point now) {
        if (now < retry_) return;
        retry_ = now + 20ms;
        fd_ = connect_to(port_);
        said_ = 0;
        due_ = now;
    }
    void close() {
        if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    }
    void drain() {
        char buffer[16 * 1024];
        for (;;) {
            const ssize_t got = ::recv(fd_, buffer, sizeof buffer, 0);
            if (got < 0 && errno == EAGAIN) return;
            if (got <= 0) return close();
        }
    }
    void say() {
        const std::size_t left = attack_->bytes.size() - said_;
        const std::size_t count = attack_->at_once > 0 ? std::min(attack_->at_once, left) : left;
        const ssize_t sent = ::send(fd_, attack_->bytes.data() + said_, count, MSG_NOSIGNAL);
        if (sent < 0 && errno != EAGAIN) return close();
        if (sent > 0) said_ = (said_ + static_cast<std::size_t>(sent)) % attack_->bytes.size();
    }

    const Attack* attack_;
    std::uint16_t port_;
    int fd_ = -1;
    std::size_t said_ = 0;
    Clock::time_point due_;
    Clock::time_point retry_;
};

}  // namespace

std::span<const Attack> attacks() {
    static const std::vector<Attack> kAttacks = all_attacks();
    return kAttacks;
}

Attackers::Attackers(const Attack& attack, std::uint16_t port)
    : thread_([this, &attack, port] {
          std::vector<Bad> clients;
          for (std::size_t i = 0; i < attack.clients; ++i) clients.emplace_back(attack, port);
          while (!stop_) {
              const auto now = Clock::now();
              for (auto& client : clients) client.act(now);
              std::this_thread::sleep_until(now + 1ms);
          }
      }) {}

Attackers::~Attackers() {
    stop_ = true;
    thread_.join();
}

}  // namespace bench
