// Limits the connections to one host, of all lines that have one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <string>
#include <utility>

namespace takt::line {

/// Permits for connections to hosts that accept few at a time. First come, first served. A holder returns its
/// permit while another line waits: see wanted().
///
/// It must outlive every Permit. One owner; the thread of its users only.
class ConnectionLimit {
public:
    /// A permit, or the wait for one. Destroying it ends either.
    class Permit {
    public:
        Permit() = default;
        Permit(ConnectionLimit* limit, std::string host, std::uint64_t ticket)
            : limit_(limit), host_(std::move(host)), ticket_(ticket) {}
        Permit(Permit&& other) noexcept { swap(other); }
        Permit& operator=(Permit&& other) noexcept {
            Permit(std::move(other)).swap(*this);
            return *this;
        }
        ~Permit() {
            if (limit_) limit_->leave(host_, ticket_);
        }

    private:
        void swap(Permit& other) noexcept {
            std::swap(limit_, other.limit_);
            std::swap(host_, other.host_);
            std::swap(ticket_, other.ticket_);
        }
        ConnectionLimit* limit_ = nullptr;
        std::string host_;
        std::uint64_t ticket_ = 0;
    };

    /// @param on_wanted  called with the host when a line begins to wait; may be empty
    explicit ConnectionLimit(std::function<void(const std::string& host)> on_wanted = {})
        : on_wanted_(std::move(on_wanted)) {}
    ConnectionLimit(const ConnectionLimit&) = delete;
    ConnectionLimit& operator=(const ConnectionLimit&) = delete;

    /// Calls `admitted` when there is a permit: at once from inside ask(), or when another one is returned.
    /// @param most  connections to the host at a time, at least 1
    [[nodiscard]] Permit ask(const std::string& host, std::size_t most, std::function<void()> admitted);

    /// A line waits for a permit.
    [[nodiscard]] bool wanted(const std::string& host) const;

private:
    struct Waiting {
        std::uint64_t ticket = 0;
        std::size_t most = 1;
        std::function<void()> admitted;
    };
    struct Host {
        std::size_t taken = 0;
        std::deque<Waiting> waiting;
    };

    void leave(const std::string& host, std::uint64_t ticket);

    std::function<void(const std::string& host)> on_wanted_;
    std::map<std::string, Host> hosts_;
    std::uint64_t last_ticket_ = 0;
};

}  // namespace takt::line
