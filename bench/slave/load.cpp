#include "load.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace bench {
namespace {

constexpr std::size_t kReadAtOnce = 16 * 1024;

void put_u16(std::vector<std::uint8_t>& bytes, std::size_t value) {
    bytes.push_back(static_cast<std::uint8_t>(value >> 8));
    bytes.push_back(static_cast<std::uint8_t>(value));
}

double micro(Clock::duration time) {
    return std::chrono::duration<double, std::micro>(time).count();
}

/// One client: numbers its requests, and checks the answers in their order.
class Client {
public:
    Client(std::uint16_t port, const Exchange& exchange, bool checked)
        : fd_(connect_to(port)), exchange_(exchange), checked_(checked) {}
    ~Client() {
        if (fd_ >= 0) ::close(fd_);
    }
    Client(Client&& other) noexcept
        : fd_(std::exchange(other.fd_, -1)), exchange_(other.exchange_), checked_(other.checked_) {}
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    Client& operator=(Client&&) = delete;

    void send(std::size_t requests) {
        for (; requests > 0; --requests) {
            const std::size_t at = outgoing_.size();
            outgoing_.insert(outgoing_.end(), exchange_.request.begin(), exchange_.request.end());
            outgoing_[at] = static_cast<std::uint8_t>(next_ >> 8);
            outgoing_[at + 1] = static_cast<std::uint8_t>(next_++);
        }
        flush();
    }
    /// Writes the remaining bytes; those that the peer does not take stay.
    void flush() {
        if (outgoing_.empty()) return;
        const ssize_t sent = ::send(fd_, outgoing_.data(), outgoing_.size(), MSG_NOSIGNAL);
        if (sent > 0) outgoing_.erase(outgoing_.begin(), outgoing_.begin() + sent);
    }
    /// @returns how many answers came
    std::size_t receive() {
        static std::array<std::uint8_t, kReadAtOnce> buffer;
        std::ranges::copy(heard_, buffer.begin());
        const ssize_t got = ::recv(fd_, buffer.data() + heard_.size(), buffer.size() - heard_.size(), 0);
        closed_ = closed_ || got == 0 || (got < 0 && errno != EAGAIN);
        const std::size_t there = heard_.size() + static_cast<std::size_t>(std::max<ssize_t>(got, 0));
        const std::size_t size = exchange_.response.size();
        const std::size_t answers = there / size;
        for (std::size_t i = 0; i < answers; ++i) check(&buffer[i * size]);
        heard_.assign(buffer.begin() + static_cast<std::ptrdiff_t>(answers * size),
                      buffer.begin() + static_cast<std::ptrdiff_t>(there));
        return answers;
    }
    [[nodiscard]] int fd() const { return fd_; }
    [[nodiscard]] bool closed() const { return closed_ || fd_ < 0; }
    [[nodiscard]] std::size_t wrong() const { return wrong_; }

private:
    void check(const std::uint8_t* answer) {
        const std::uint16_t id = expected_++;
        const auto& right = exchange_.response;
        if (checked_ && (answer[0] != id >> 8 || answer[1] != (id & 0xFF) ||
                         std::memcmp(answer + 2, right.data() + 2, right.size() - 2) != 0))
            ++wrong_;
    }

    int fd_;
    const Exchange& exchange_;
    bool checked_;
    bool closed_ = false;
    std::uint16_t next_ = 0;
    std::uint16_t expected_ = 0;
    std::size_t wrong_ = 0;
    std::vector<std::uint8_t> outgoing_;
    std::vector<std::uint8_t> heard_;  // of an answer that is not whole
};

void wait_for(int fd, Clock::duration limit) {
    pollfd waiting{fd, POLLIN, 0};
    const auto time =
        std::chrono::duration_cast<std::chrono::nanoseconds>(std::max(limit, Clock::duration(0)));
    const timespec at_most{static_cast<time_t>(time.count() / 1'000'000'000),
                           static_cast<long>(time.count() % 1'000'000'000)};
    ::ppoll(&waiting, 1, &at_most, nullptr);
}

}  // namespace

std::vector<std::uint8_t> frame(std::span<const std::uint8_t> pdu) {
    std::vector<std::uint8_t> bytes{0, 0, 0, 0};
    put_u16(bytes, pdu.size() + 1);
    bytes.push_back(1);
    bytes.insert(bytes.end(), pdu.begin(), pdu.end());
    return bytes;
}

Exchange read_registers(std::uint16_t start, std::uint16_t count) {
    std::vector<std::uint8_t> request{0x03};
    put_u16(request, start);
    put_u16(request, count);
    std::vector<std::uint8_t> response{0x03, static_cast<std::uint8_t>(2 * count)};
    for (std::size_t i = 0; i < count; ++i) put_u16(response, start + i);
    return {frame(request), frame(response)};
}

Exchange write_registers(std::uint16_t start, std::uint16_t count) {
    std::vector<std::uint8_t> request{0x10};
    put_u16(request, start);
    put_u16(request, count);
    const std::vector<std::uint8_t> response = request;
    request.push_back(static_cast<std::uint8_t>(2 * count));
    for (std::size_t i = 0; i < count; ++i) put_u16(request, start + i);
    return {frame(request), frame(response)};
}

int connect_to(std::uint16_t port) {
    const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (fd < 0 || ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        if (fd >= 0) ::close(fd);
        return -1;
    }
    const int on = 1;
    ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    ::fcntl(fd, F_SETFL, O_NONBLOCK);
    return fd;
}

double Load::quantile_us(double q) const {
    if (latencies_us.empty()) return 0;
    return latencies_us[static_cast<std::size_t>(q * static_cast<double>(latencies_us.size() - 1) + 0.5)];
}

void Load::add(const Load& other) {
    length += other.length;
    answered += other.answered;
    wrong += other.wrong;
    unanswered += other.unanswered;
    requests_per_s = static_cast<double>(answered) / length.count();
    const auto middle =
        latencies_us.insert(latencies_us.end(), other.latencies_us.begin(), other.latencies_us.end());
    std::ranges::inplace_merge(latencies_us, middle);
}

Load flood(std::uint16_t port, const Exchange& exchange, std::size_t connections, std::size_t window,
           std::chrono::milliseconds length, bool checked) {
    std::vector<Client> clients;
    clients.reserve(connections);
    const int epoll = ::epoll_create1(EPOLL_CLOEXEC);
    for (std::size_t i = 0; i < connections; ++i) {
        epoll_event event{};
        event.events = EPOLLIN;
        event.data.u64 = i;
        ::epoll_ctl(epoll, EPOLL_CTL_ADD, clients.emplace_back(port, exchange, checked).fd(), &event);
    }
    Load load;
    const bool timed = connections == 1 && window == 1;
    const auto begin = Clock::now();
    auto sent_at = begin;
    for (auto& client : clients) client.send(window);
    constexpr int kEvents = 64;
    epoll_event events[kEvents];
    auto now = begin;
    while (now < begin + length) {
        constexpr int kPatience = 100;
        const int ready = ::epoll_wait(epoll, events, kEvents, kPatience);
        for (int i = 0; i < ready; ++i) {
            Client& client = clients[events[i].data.u64];
            const std::size_t answers = client.receive();
            now = Clock::now();
            if (timed && answers > 0) load.latencies_us.push_back(micro(now - std::exchange(sent_at, now)));
            load.answered += answers;
            if (!client.closed()) client.send(answers);
        }
        if (ready == 0) now = Clock::now();
    }
    load.length = now - begin;
    load.requests_per_s = static_cast<double>(load.answered) / load.length.count();
    for (const auto& client : clients) load.wrong += client.wrong();
    std::ranges::sort(load.latencies_us);
    ::close(epoll);
    return load;
}

Load paced(std::uint16_t port, const Exchange& exchange, std::size_t per_second,
           std::chrono::milliseconds length, bool checked) {
    constexpr auto kStragglers = std::chrono::seconds(5);
    Client client(port, exchange, checked);
    const auto period = std::chrono::duration_cast<Clock::duration>(std::chrono::seconds(1)) /
                        static_cast<Clock::rep>(per_second);
    const auto total = static_cast<std::size_t>(length / period);
    std::vector<Clock::time_point> due(total);
    Load load;
    const auto begin = Clock::now();
    std::size_t sent = 0;
    while (load.answered < total && !client.closed()) {
        const auto now = Clock::now();
        if (now > begin + length + kStragglers) break;
        const auto next = begin + static_cast<Clock::rep>(sent) * period;
        if (sent < total && now >= next) {
            due[sent++] = now;
            client.send(1);
            continue;
        }
        client.flush();
        wait_for(client.fd(), sent < total ? next - now : begin + length + kStragglers - now);
        const std::size_t answers = client.receive();
        const auto then = Clock::now();
        for (std::size_t i = 0; i < answers && load.answered < sent; ++i)
            load.latencies_us.push_back(micro(then - due[load.answered++]));
    }
    load.wrong = client.wrong();
    load.unanswered = total - load.answered;
    std::ranges::sort(load.latencies_us);
    return load;
}

}  // namespace bench
