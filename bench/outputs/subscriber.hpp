// Clients of the broker that are not Takt: one that checks the order of samples, and one that publishes.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>

struct mosquitto;

namespace takt::bench {

struct MosquittoDelete {
    void operator()(mosquitto* client) const;
};
using MosquittoPtr = std::unique_ptr<mosquitto, MosquittoDelete>;

/// Takes all messages with QoS 1 on a thread of its own. Those of topics plant/… are samples.
class Subscriber {
public:
    /// Returns when the subscription is acknowledged. Throws Failure.
    explicit Subscriber(std::uint16_t port);
    ~Subscriber();
    Subscriber(const Subscriber&) = delete;
    Subscriber& operator=(const Subscriber&) = delete;

    /// All messages.
    [[nodiscard]] std::uint64_t messages() const { return messages_; }
    /// Each sample up to this number was received, in order.
    [[nodiscard]] std::uint64_t complete() const { return complete_; }
    /// Samples that came again and are marked as repeated.
    [[nodiscard]] std::uint64_t repeated() const { return repeated_; }
    /// Samples that left out others or came again without the mark; complete() ends before the first one.
    [[nodiscard]] std::uint64_t out_of_order() const { return out_of_order_; }

private:
    void on_message(std::string_view topic, std::string_view payload);

    std::atomic<bool> subscribed_ = false;
    std::atomic<std::uint64_t> messages_ = 0;
    std::atomic<std::uint64_t> complete_ = 0;
    std::atomic<std::uint64_t> repeated_ = 0;
    std::atomic<std::uint64_t> out_of_order_ = 0;
    MosquittoPtr client_;
};

/// Publishes messages as a sample has them, with QoS 1 and 64 in flight, and does nothing else: the pace of
/// the broker. @returns messages a second. Throws Failure
[[nodiscard]] double publish_plainly(std::uint16_t port, std::size_t messages);

}  // namespace takt::bench
