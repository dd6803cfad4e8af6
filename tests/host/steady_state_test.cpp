// The I/O thread of a host in steady state: it polls, serves, publishes and is watched without allocating.
//
// The program is built with AddressSanitizer, which calls a hook for each allocation of any kind, also those
// of libraries. Without it only `operator new` is counted.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

#include "../../src/host/test/projects.hpp"
#include "../../src/host/test/running_host.hpp"
#include "folder.hpp"
#include "takt/os/descriptor.hpp"

// Of sanitizer/allocator_interface.h, which g++ does not install.
// NOLINTBEGIN(*-reserved-identifier)
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                             std::size_t),
                                                         void (*free_hook)(const volatile void*));
extern "C" void __sanitizer_print_stack_trace();
// NOLINTEND(*-reserved-identifier)

namespace takt::host::test {
namespace steady_state_test {

thread_local bool t_is_io_thread = false;
std::atomic<bool> g_counting = false;
std::atomic<std::uint64_t> g_allocations = 0;

#if defined(__SANITIZE_ADDRESS__)
void on_allocation(const volatile void*, std::size_t) {
    if (!t_is_io_thread || !g_counting.load(std::memory_order_relaxed)) return;
    t_is_io_thread = false;  // what the report below allocates is not counted
    if (g_allocations.fetch_add(1) < 3) __sanitizer_print_stack_trace();
    t_is_io_thread = true;
}
void on_free(const volatile void*) {}
#endif

/// Two pseudo-terminals whose other ends are joined: a line between a master and a slave.
class PtyCable {
public:
    PtyCable() {
        for (auto& end : ends_) {
            end.reset(::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC));
            EXPECT_EQ(::grantpt(end.get()), 0);
            EXPECT_EQ(::unlockpt(end.get()), 0);
        }
        thread_ = std::jthread([this](const std::stop_token& stop) { copy(stop); });
    }

    [[nodiscard]] std::string path(std::size_t end) const {
        std::array<char, 64> name{};
        EXPECT_EQ(::ptsname_r(ends_[end].get(), name.data(), name.size()), 0);
        return name.data();
    }

private:
    void copy(const std::stop_token& stop) {
        std::array<char, 512> bytes{};
        while (!stop.stop_requested()) {
            std::array<pollfd, 2> waited{pollfd{ends_[0].get(), POLLIN, 0},
                                         pollfd{ends_[1].get(), POLLIN, 0}};
            if (::poll(waited.data(), waited.size(), 20) <= 0) continue;
            for (std::size_t i = 0; i < 2; ++i) {
                if ((waited[i].revents & POLLIN) == 0) continue;
                const auto count = ::read(ends_[i].get(), bytes.data(), bytes.size());
                if (count > 0)
                    (void)!::write(ends_[1 - i].get(), bytes.data(), static_cast<std::size_t>(count));
            }
        }
    }

    std::array<os::Descriptor, 2> ends_;
    std::jthread thread_;
};

int free_port() {
    const os::Descriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    return ntohs(address.sin_port);
}

/// A serial and a TCP line whose devices are servers of the same project.
std::string project_on(const PtyCable& cable, int port) {
    return R"(takt: 1
lines:
  - name: serial
    transport: serial
    port: )" +
           cable.path(0) + R"(
    baud: 115200
    devices:
      - {name: Boiler, address: 1, poll_period: 10ms, turnaround: 2ms, response_timeout: 2s, variables: [
          {name: Level, type: int, register: 0, read: 0x03},
          {name: Limit, type: float, register: 2, read: 0x03, write: 0x10}]}
  - name: network
    transport: tcp
    host: 127.0.0.1
    tcp_port: )" +
           std::to_string(port) + R"(
    devices:
      - {name: Meter, address: 1, poll_period: 10ms, response_timeout: 2s, variables: [
          {name: Power, type: int, register: 0, read: 0x03}]}
servers:
  - name: slave
    transport: serial
    port: )" +
           cable.path(1) + R"(
    baud: 115200
    units: [{address: 1, banks: [{area: holding_register, items: [0..9]}]}]
  - name: panel
    listen: 127.0.0.1
    tcp_port: )" +
           std::to_string(port) + R"(
    units: [{address: 1, banks: [{area: holding_register, items: [0..9]}], variables: [
        {name: Copy, type: int16, area: holding_register, register: 0, source: {variable: Level}}]}]
)";
}

/// Reads all that a session has until that many frames of each kind of source passed.
void pass_frames(Session& session, int frames) {
    int of_lines = 0;
    int of_endpoints = 0;
    for (int waits = 0; waits < 10'000 && (of_lines < frames || of_endpoints < frames); ++waits) {
        while (session.next_event()) {}
        while (const auto record = session.next_traffic())
            ++(record->source.kind == TrafficSource::Kind::line ? of_lines : of_endpoints);
        (void)session.wait(10ms);
    }
    EXPECT_GE(of_lines, frames);
    EXPECT_GE(of_endpoints, frames);
}

TEST(SteadyState, TheIoThreadAllocatesNothing) {
#if !defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "the hook for allocations is part of AddressSanitizer";
#else
    ASSERT_NE(__sanitizer_install_malloc_and_free_hooks(on_allocation, on_free), 0);
    const takt::test::Folder folder;
    const PtyCable cable;
    auto project = project_of(project_on(cable, free_port()));
    const auto host =
        started(std::move(project), {.project_file = folder / "plant.yaml",
                                     .record_traffic = true,
                                     .begin_thread = [](line::Loop&) { t_is_io_thread = true; }});
    ASSERT_TRUE(host);
    const auto session = *host->open_session({.traffic = true});
    pass_frames(*session, 400);  // buffers reach their size
    // A response that takes a time of another power of two grows its histogram, which ends after a few.
    std::uint64_t allocations = 1;
    for (int window = 0; window < 6 && allocations > 0; ++window) {
        g_allocations = 0;
        g_counting = true;
        pass_frames(*session, 400);
        g_counting = false;
        allocations = g_allocations;
    }
    EXPECT_EQ(allocations, 0u) << "in each window; the first ones are printed above";
    host->stop();
#endif
}

}  // namespace steady_state_test
}  // namespace takt::host::test
