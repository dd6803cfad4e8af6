#include "mqtt/mosquitto_pipe.hpp"

#include <netdb.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <deque>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "mqtt/mosquitto_client.hpp"
#include "takt/base/network.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/os/priority.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/os/worker.hpp"

namespace takt::publish {

struct ResolvedBroker {
    MqttConnectionId connection = 0;
    std::vector<std::string> addresses;  // numeric
    std::string error;
};

namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTick = std::chrono::seconds(1);          // keep-alive of libmosquitto, in seconds
constexpr auto kAddressLimit = std::chrono::seconds(5);  // of a TCP connection, if another address follows
constexpr auto kFlushLimit = std::chrono::milliseconds(500);  // of DISCONNECT

// Blocks as long as the name service.
ResolvedBroker look_up(MqttConnectionId connection, const std::string& host) {
    ResolvedBroker result{.connection = connection};
    addrinfo hints{};
    hints.ai_family = AF_UNSPEC;
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* list = nullptr;
    if (const int error = getaddrinfo(host.c_str(), nullptr, &hints, &list)) {
        result.error = gai_strerror(error);
        return result;
    }
    for (const addrinfo* entry = list; entry; entry = entry->ai_next) {
        std::array<char, NI_MAXHOST> text{};
        if (getnameinfo(entry->ai_addr, entry->ai_addrlen, text.data(), text.size(), nullptr, 0,
                        NI_NUMERICHOST) == 0)
            result.addresses.emplace_back(text.data());
    }
    freeaddrinfo(list);
    return result;
}

// What the broker decides.
std::size_t bytes_of(const MqttEvent& event) {
    const auto* const received = std::get_if<MqttReceived>(&event);
    if (!received) return 0;
    const auto& [topic, payload, qos, retain, properties] = received->message;
    return topic.size() + payload.size() + properties.response_topic.size() +
           properties.correlation_data.size() + properties.content_type.size();
}

os::Descriptor make_bell() {
    os::Descriptor bell(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
    if (!bell) throw std::system_error(errno, std::generic_category(), "eventfd");
    return bell;
}

// EAGAIN means that a wake-up is already pending.
void ring(const os::Descriptor& bell) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(bell.get(), &one, sizeof one);
}

void silence(const os::Descriptor& bell) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = read(bell.get(), &count, sizeof count);
}

}  // namespace

// Shared with look-ups that may outlive the pipe.
struct MosquittoPipe::Shared {
    std::mutex mutex;
    std::deque<MqttAction> actions;
    std::deque<MqttEvent> events;
    std::optional<ResolvedBroker> resolved;
    std::size_t event_bytes = 0;
    bool paused = false;  // too many events wait
    bool ending = false;
    os::Descriptor bell = make_bell();   // wakes the thread
    os::Descriptor ready = make_bell();  // readable while events wait
};

class MosquittoPipe::Thread {
public:
    explicit Thread(std::shared_ptr<Shared> shared)
        : shared_(std::move(shared)),
          resolver_({.name = "takt-resolver",
                     .threads = 2,
                     .queue = 2,
                     .at_end = os::Worker::AtEnd::discard,
                     .join_timeout = std::chrono::milliseconds(0)}),
          thread_([this] { run(); }) {}
    ~Thread() { thread_.join(); }

private:
    void run();
    bool take();
    void wait();
    void act(const MqttConnect& action);
    void act(const MqttPublish& action);
    void act(const MqttSubscribe& action);
    void act(const MqttDisconnect& action);
    void on_resolved(ResolvedBroker&& resolved);
    void try_next_address();
    void check_client();
    void emit(MqttEvent&& event);
    void close(MqttFailure failure);

    std::shared_ptr<Shared> shared_;
    os::Worker resolver_;

    // Of the thread.
    std::optional<MqttConnect> connect_;  // none: no connection
    std::deque<std::string> addresses_;   // not tried yet
    bool nearby_ = false;                 // all of them and those that were tried
    std::unique_ptr<MosquittoClient> client_;
    Clock::time_point next_tick_{};
    std::optional<Clock::time_point> deadline_;  // of the address, or of DISCONNECT

    std::thread thread_;  // the last member: it uses the others
};

void MosquittoPipe::Thread::run() {
    os::name_thread("takt-mqtt");
    os::become_background_thread();
    while (take()) {
        check_client();
        wait();
    }
    client_.reset();
}

// Executes what was posted. @returns false at the end
bool MosquittoPipe::Thread::take() {
    std::deque<MqttAction> actions;
    std::optional<ResolvedBroker> resolved;
    {
        const std::lock_guard lock(shared_->mutex);
        if (shared_->ending) return false;
        actions.swap(shared_->actions);
        resolved = std::exchange(shared_->resolved, {});
    }
    if (resolved) on_resolved(std::move(*resolved));
    for (const auto& action : actions) std::visit([this](const auto& its) { act(its); }, action);
    return true;
}

void MosquittoPipe::Thread::wait() {
    MosquittoClient::Descriptors of_client{};
    std::array<pollfd, 1 + std::tuple_size_v<MosquittoClient::Descriptors>> descriptors{};
    nfds_t count = 1;
    descriptors[0] = {.fd = shared_->bell.get(), .events = POLLIN, .revents = 0};
    auto until = Clock::time_point::max();
    if (client_) {
        bool paused = false;
        {
            const std::lock_guard lock(shared_->mutex);
            paused = shared_->paused =
                shared_->events.size() >= kMostEvents || shared_->event_bytes >= kMostEventBytes;
        }
        of_client = client_->descriptors(paused);
        std::ranges::copy(of_client, descriptors.begin() + 1);
        count = descriptors.size();
        until = std::min(next_tick_, deadline_.value_or(Clock::time_point::max()));
    }
    int milliseconds = -1;
    if (until != Clock::time_point::max())
        milliseconds = static_cast<int>(std::max<std::int64_t>(
            0, std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count()));
    if (::poll(descriptors.data(), count, milliseconds) < 0) return;
    if (descriptors[0].revents) silence(shared_->bell);
    if (!client_) return;
    std::copy(descriptors.begin() + 1, descriptors.end(), of_client.begin());
    client_->on_ready(of_client);
    if (Clock::now() < next_tick_) return;
    next_tick_ = Clock::now() + kTick;
    client_->on_second();
}

void MosquittoPipe::Thread::act(const MqttConnect& action) {
    connect_ = action;
    nearby_ = false;
    const bool posted = resolver_.post(
        [shared = shared_, request = std::make_unique<std::pair<MqttConnectionId, std::string>>(
                               action.connection, action.broker.host)] {
            auto resolved = look_up(request->first, request->second);
            const std::lock_guard lock(shared->mutex);
            shared->resolved = std::move(resolved);
            ring(shared->bell);
        });
    if (!posted) close({MqttFailureKind::dns, {}, "earlier look-ups have not ended"});
}

void MosquittoPipe::Thread::act(const MqttPublish& action) {
    if (client_ && connect_->connection == action.connection) client_->publish(action);
}

void MosquittoPipe::Thread::act(const MqttSubscribe& action) {
    if (client_ && connect_->connection == action.connection) client_->subscribe(action);
}

void MosquittoPipe::Thread::act(const MqttDisconnect& action) {
    if (!connect_ || connect_->connection != action.connection) return;
    if (!client_ || !client_->is_reached() || !action.orderly) return close({});
    addresses_.clear();
    deadline_ = Clock::now() + kFlushLimit;
    client_->disconnect();
}

void MosquittoPipe::Thread::on_resolved(ResolvedBroker&& resolved) {
    if (!connect_ || connect_->connection != resolved.connection) return;
    if (resolved.addresses.empty()) return close({MqttFailureKind::dns, {}, resolved.error});
    addresses_.assign(resolved.addresses.begin(), resolved.addresses.end());
    nearby_ = std::ranges::all_of(addresses_, [](const std::string& address) {
        const auto ip = parse_ip(address);
        return ip && ip->is_nearby();
    });
    try_next_address();
}

void MosquittoPipe::Thread::try_next_address() {
    const std::string address = std::move(addresses_.front());
    addresses_.pop_front();
    client_.reset();
    client_ = std::make_unique<MosquittoClient>(*connect_, address,
                                                [this](MqttEvent&& event) { emit(std::move(event)); });
    next_tick_ = Clock::now() + kTick;
    deadline_.reset();
    if (!addresses_.empty()) deadline_ = Clock::now() + kAddressLimit;
}

// Continues with the next address, or reports the end.
void MosquittoPipe::Thread::check_client() {
    while (client_) {
        if (client_->is_reached() && !addresses_.empty()) {
            addresses_.clear();
            deadline_.reset();
        }
        const bool expired = deadline_ && Clock::now() >= *deadline_;
        if (!client_->ended() && !expired) return;
        if (addresses_.empty()) return close(client_->ended().value_or(MqttFailure{}));
        try_next_address();
    }
}

void MosquittoPipe::Thread::emit(MqttEvent&& event) {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->events.empty()) ring(shared_->ready);
    shared_->event_bytes += bytes_of(event);
    shared_->events.push_back(std::move(event));
}

void MosquittoPipe::Thread::close(MqttFailure failure) {
    const auto connection = connect_->connection;
    client_.reset();
    connect_.reset();
    addresses_.clear();
    deadline_.reset();
    emit(MqttClosed{connection, std::move(failure), nearby_});
}

MosquittoPipe::MosquittoPipe()
    : shared_(std::make_shared<Shared>()), thread_(std::make_unique<Thread>(shared_)) {}

MosquittoPipe::~MosquittoPipe() {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->ending = true;
    }
    ring(shared_->bell);
    thread_.reset();
}

void MosquittoPipe::send(MqttAction&& action) {
    {
        const std::lock_guard lock(shared_->mutex);
        shared_->actions.push_back(std::move(action));
    }
    ring(shared_->bell);
}

std::optional<MqttEvent> MosquittoPipe::next_event() {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->events.empty()) return {};
    auto event = std::move(shared_->events.front());
    shared_->events.pop_front();
    shared_->event_bytes -= bytes_of(event);
    if (!shared_->events.empty()) return event;
    silence(shared_->ready);
    if (std::exchange(shared_->paused, false)) ring(shared_->bell);
    return event;
}

int MosquittoPipe::descriptor() const {
    return shared_->ready.get();
}

}  // namespace takt::publish
