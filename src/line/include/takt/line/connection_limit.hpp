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

/// The places for connections to hosts that accept few at a time. First come, first served. A holder
/// gives its place back while another line waits: see wanted().
///
/// It must outlive every Place. One owner; the thread of its users only.
class HostPlaces {
public:
    /// A place, or the wait for one. Destroying it ends either.
    class Place {
    public:
        Place() = default;
        Place(HostPlaces* places, std::string host, std::uint64_t ticket)
            : places_(places), host_(std::move(host)), ticket_(ticket) {}
        Place(Place&& other) noexcept { swap(other); }
        Place& operator=(Place&& other) noexcept {
            Place(std::move(other)).swap(*this);
            return *this;
        }
        ~Place() {
            if (places_) places_->leave(host_, ticket_);
        }

    private:
        void swap(Place& other) noexcept {
            std::swap(places_, other.places_);
            std::swap(host_, other.host_);
            std::swap(ticket_, other.ticket_);
        }
        HostPlaces* places_ = nullptr;
        std::string host_;
        std::uint64_t ticket_ = 0;
    };

    /// @param on_wanted  called with the host when a line begins to wait; may be empty
    explicit HostPlaces(std::function<void(const std::string& host)> on_wanted = {})
        : on_wanted_(std::move(on_wanted)) {}
    HostPlaces(const HostPlaces&) = delete;
    HostPlaces& operator=(const HostPlaces&) = delete;

    /// Calls `admitted` when there is a place: at once from inside ask(), or when another one is given back.
    /// @param most  connections to the host at a time, at least 1
    [[nodiscard]] Place ask(const std::string& host, std::size_t most, std::function<void()> admitted);

    /// A line waits for a place.
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
