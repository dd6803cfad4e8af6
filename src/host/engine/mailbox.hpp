// A lock-free list that any thread adds to and one thread empties.
#pragma once

#include <atomic>
#include <memory>
#include <utility>

namespace takt::host {

/// Base of what goes into a Mailbox.
struct MailboxNode {
    MailboxNode* next = nullptr;
    MailboxNode() = default;
    MailboxNode(const MailboxNode&) = delete;
    MailboxNode& operator=(const MailboxNode&) = delete;
    virtual ~MailboxNode() = default;
};

/// A Treiber stack that is emptied as a whole, in the order of arrival. Neither push() nor take() allocates,
/// waits or takes a lock. Bounded by what its users allow to be in flight.
///
/// @tparam T  derives from MailboxNode
template <class T>
class Mailbox {
public:
    Mailbox() = default;
    ~Mailbox() {
        while (auto item = take()) {}
    }
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    /// Any thread.
    void push(std::unique_ptr<T> item) {
        T* const node = item.release();
        MailboxNode* top = arrived_.load(std::memory_order_relaxed);
        do node->next = top;
        while (
            !arrived_.compare_exchange_weak(top, node, std::memory_order_release, std::memory_order_relaxed));
    }

    /// The oldest item; nullptr when it is empty. One thread at a time.
    [[nodiscard]] std::unique_ptr<T> take() {
        if (!ordered_) reverse(arrived_.exchange(nullptr, std::memory_order_acquire));
        if (!ordered_) return nullptr;
        auto* const first = ordered_;
        ordered_ = std::exchange(first->next, nullptr);
        return std::unique_ptr<T>(static_cast<T*>(first));
    }

    /// Whether take() would find something. The thread that takes.
    [[nodiscard]] bool empty() const { return !ordered_ && !arrived_.load(std::memory_order_acquire); }

private:
    void reverse(MailboxNode* node) {
        while (node) {
            auto* const next = std::exchange(node->next, ordered_);
            ordered_ = std::exchange(node, next);
        }
    }

    std::atomic<MailboxNode*> arrived_ = nullptr;  // the newest first
    MailboxNode* ordered_ = nullptr;               // the oldest first; of the thread that takes
};

}  // namespace takt::host
