#include "takt/firmware/tcp_device.hpp"

#include <algorithm>
#include <limits>

#include "takt/firmware/board.hpp"
#include "takt/firmware/ethernet.hpp"

extern "C" {
#include "lwip/etharp.h"
#include "lwip/init.h"
#include "lwip/netif.h"
#include "lwip/stats.h"
#include "lwip/tcp.h"
#include "lwip/timeouts.h"
#include "netif/ethernet.h"
}

namespace takt::firmware {
namespace {

static_assert(TcpDevice::kWindow == TCP_WND);

// Below the time after which the clocks of boards wrap around.
constexpr std::uint32_t kLongestSleep = 60'000'000;
constexpr u8_t kPollsInASecond = 2;  // lwIP's slow timer

netif g_netif;
std::array<std::uint8_t, board::kMaxEthernetFrame> g_frame;  // between lwIP's chains of buffers and the board
std::uint64_t g_microseconds;
std::uint32_t g_last_clock;
std::uint32_t g_random;

std::uint64_t microseconds() {
    const std::uint32_t clock = board::clock();
    g_microseconds += clock - g_last_clock;
    g_last_clock = clock;
    return g_microseconds;
}

Instant now() {
    return Instant(std::chrono::microseconds(microseconds()));
}

u32_t milliseconds(Duration duration) {
    return static_cast<u32_t>(std::chrono::duration_cast<std::chrono::milliseconds>(duration).count());
}

ip4_addr_t ip4(const std::array<std::uint8_t, 4>& address) {
    ip4_addr_t ip;
    IP4_ADDR(&ip, address[0], address[1], address[2], address[3]);
    return ip;
}

err_t send_frame(netif*, pbuf* packet) {
    const std::size_t size = pbuf_copy_partial(packet, g_frame.data(), static_cast<u16_t>(g_frame.size()), 0);
    if (board::send_ethernet(Bytes(g_frame).first(size))) return ERR_OK;
    ++static_cast<TcpDeviceCounters*>(g_netif.state)->unsent_frames;
    return ERR_MEM;  // TCP sends it again
}

err_t set_up(netif* netif) {
    const auto address = board::ethernet_address();
    std::ranges::copy(address, netif->hwaddr);
    netif->hwaddr_len = static_cast<u8_t>(address.size());
    netif->name[0] = 'e';
    netif->name[1] = '0';
    netif->mtu = 1500;
    netif->flags = NETIF_FLAG_BROADCAST | NETIF_FLAG_ETHARP | NETIF_FLAG_ETHERNET;
    netif->output = etharp_output;
    netif->linkoutput = send_frame;
    return ERR_OK;
}

// Bytes that are not acknowledged are probes themselves. A peer whose window is closed would not respond to a
// keep-alive of lwIP behind a probe of its window.
void keep_alive(tcp_pcb* pcb) {
    if (tcp_sndqueuelen(pcb) == 0)
        ip_set_option(pcb, SOF_KEEPALIVE);
    else
        ip_reset_option(pcb, SOF_KEEPALIVE);
}

void detach(tcp_pcb* pcb) {
    tcp_arg(pcb, nullptr);
    tcp_recv(pcb, nullptr);
    tcp_err(pcb, nullptr);
}

err_t abort_closed(void*, tcp_pcb* pcb) {
    tcp_abort(pcb);
    return ERR_ABRT;
}

}  // namespace

TcpDevice::TcpDevice(const TcpDeviceConfig& config, serve::Responder& responder)
    : config_(config), responder_(responder) {
    for (Connection& connection : connections_) connection.device = this;
}

bool TcpDevice::start() {
    if (!board::open_ethernet()) return false;
    g_last_clock = board::clock();
    for (const std::uint8_t byte : board::ethernet_address()) g_random = g_random * 31 + byte;
    lwip_init();
    const ip4_addr_t address = ip4(config_.address);
    const ip4_addr_t mask = ip4(config_.mask);
    const ip4_addr_t gateway = ip4(config_.gateway);
    netif_add(&g_netif, &address, &mask, &gateway, &counters_, set_up, ethernet_input);
    netif_set_default(&g_netif);
    netif_set_up(&g_netif);
    tcp_pcb* const socket = tcp_new();
    if (!socket || tcp_bind(socket, IP_ADDR_ANY, config_.port) != ERR_OK) return false;
    tcp_pcb* const listener = tcp_listen(socket);
    if (!listener) return false;
    tcp_arg(listener, this);
    tcp_accept(listener, on_accept);
    return true;
}

bool TcpDevice::work() {
    receive_frames();
    sys_check_timeouts();
    const Instant t = now();
    for (Connection& connection : connections_)
        if (connection.pcb) serve(t, connection);
    set_timer(t);
    return false;
}

bool TcpDevice::has_work() const {
    return board::ethernet_waits() || board::clock() - timer_since_ >= timer_;
}

TcpDeviceMemory TcpDevice::memory() const {
    return {.connections = lwip_stats.memp[MEMP_TCP_PCB]->used,
            .pool = lwip_stats.memp[MEMP_PBUF_POOL]->used,
            .heap = lwip_stats.mem.used,
            .most_heap = lwip_stats.mem.max};
}

void TcpDevice::receive_frames() {
    // So many before the timers and the connections have their turn.
    constexpr int kAtOnce = 8;
    for (int i = 0; i < kAtOnce; ++i) {
        const std::size_t size = board::receive_ethernet(g_frame);
        if (board::ethernet_link() != (netif_is_link_up(&g_netif) != 0))
            board::ethernet_link() ? netif_set_link_up(&g_netif) : netif_set_link_down(&g_netif);
        if (size == 0) return;
        pbuf* const packet = pbuf_alloc(PBUF_RAW, static_cast<u16_t>(size), PBUF_POOL);
        if (!packet) continue;
        pbuf_take(packet, g_frame.data(), static_cast<u16_t>(size));
        if (ethernet_input(packet, &g_netif) != ERR_OK) pbuf_free(packet);
    }
}

void TcpDevice::set_timer(Instant t) {
    std::uint32_t sleep = std::min(sys_timeouts_sleeptime(), kLongestSleep / 1000) * 1000;
    for (const Connection& connection : connections_) {
        if (!connection.pcb || !connection.unsent.empty()) continue;  // lwIP's timers look after these
        const Instant next = connection.engine->next_wakeup();
        if (next == kNever) continue;
        const auto wait = std::chrono::ceil<std::chrono::microseconds>(std::max(next - t, Duration::zero()));
        sleep = static_cast<std::uint32_t>(std::min<std::int64_t>(sleep, wait.count()));
    }
    timer_since_ = board::clock();
    timer_ = sleep;
    if (sleep > 0) board::start_timer(sleep);
}

// ---- callbacks

std::int8_t TcpDevice::on_accept(void* device, tcp_pcb* pcb, std::int8_t error) {
    if (error != ERR_OK || !pcb) return ERR_VAL;
    TcpDevice& self = *static_cast<TcpDevice*>(device);
    const auto free = std::ranges::find(self.connections_, nullptr, &Connection::pcb);
    if (free == self.connections_.end()) {
        ++self.counters_.refused;
        tcp_abort(pcb);
        return ERR_ABRT;
    }
    ++self.counters_.accepted;
    free->pcb = pcb;
    free->engine.emplace(self.config_.connection, self.responder_);
    free->engine->on_link(now(), true);
    tcp_arg(pcb, &*free);
    tcp_recv(pcb, on_received);
    tcp_err(pcb, on_error);
    tcp_nagle_disable(pcb);
    pcb->keep_idle = milliseconds(self.config_.keep_alive);
    pcb->keep_intvl = milliseconds(self.config_.keep_alive_interval);
    pcb->keep_cnt = self.config_.keep_alive_probes;
    return ERR_OK;
}

// The window is as long as the buffer, and grows by what was taken from it: the bytes fit.
std::int8_t TcpDevice::on_received(void* connection, tcp_pcb*, pbuf* bytes, std::int8_t) {
    Connection& self = *static_cast<Connection*>(connection);
    if (!bytes) {
        self.peer_closed = true;
        return ERR_OK;
    }
    const std::size_t space = self.received.size() - self.received_size;
    self.received_size +=
        pbuf_copy_partial(bytes, &self.received[self.received_size],
                          static_cast<u16_t>(std::min<std::size_t>(space, bytes->tot_len)), 0);
    pbuf_free(bytes);
    return ERR_OK;
}

// lwIP has freed the connection: reset by the peer, or not alive.
void TcpDevice::on_error(void* connection, std::int8_t) {
    Connection& self = *static_cast<Connection*>(connection);
    self.device->forget(self);
}

// ---- connections

void TcpDevice::serve(Instant t, Connection& connection) {
    while (write(t, connection) && connection.received_size > 0 && connection.engine->wants_bytes() > 0)
        feed(t, connection);
    if (connection.unsent.empty() && t >= connection.engine->next_wakeup()) {
        connection.engine->on_tick(t);
        write(t, connection);
    }
    const bool over = connection.engine->close_reason() != serve::CloseReason::none || connection.peer_closed;
    if (overdue(t, connection)) return close(connection, true);
    if (over && connection.unsent.empty()) return close(connection, false);
    tcp_output(connection.pcb);
    keep_alive(connection.pcb);
}

// @returns false: lwIP has no space now
bool TcpDevice::write(Instant t, Connection& connection) {
    for (;;) {
        if (connection.unsent.empty()) connection.unsent = connection.engine->transmit(t);
        if (connection.unsent.empty()) return true;
        const std::size_t size = std::min<std::size_t>(connection.unsent.size(), tcp_sndbuf(connection.pcb));
        if (size == 0 || tcp_write(connection.pcb, connection.unsent.data(), static_cast<u16_t>(size),
                                   TCP_WRITE_FLAG_COPY) != ERR_OK)
            return false;
        connection.unsent = connection.unsent.subspan(size);
    }
}

void TcpDevice::feed(Instant t, Connection& connection) {
    const std::size_t size = std::min(connection.engine->wants_bytes(), connection.received_size);
    connection.engine->on_bytes(t, Bytes(connection.received).first(size));
    std::copy_n(connection.received.begin() + static_cast<std::ptrdiff_t>(size),
                connection.received_size - size, connection.received.begin());
    connection.received_size -= size;
    tcp_recved(connection.pcb, static_cast<u16_t>(size));
}

// The engine keeps no deadline while its bytes are not written.
bool TcpDevice::overdue(Instant t, const Connection& connection) const {
    const Duration most = config_.connection.idle_deadline;
    return !connection.unsent.empty() && most > Duration::zero() &&
           t >= after(connection.engine->last_received(), most);
}

void TcpDevice::close(Connection& connection, bool at_once) {
    tcp_pcb* const pcb = connection.pcb;
    detach(pcb);
    forget(connection);
    if (at_once || tcp_close(pcb) != ERR_OK) return tcp_abort(pcb);
    // lwIP would serve it as long as its peer acknowledges, without ever reading.
    tcp_poll(pcb, abort_closed, static_cast<u8_t>(kPollsInASecond * (kClosing / std::chrono::seconds(1))));
}

void TcpDevice::forget(Connection& connection) {
    connection.pcb = nullptr;
    connection.engine.reset();
    connection.peer_closed = false;
    connection.received_size = 0;
    connection.unsent = {};
    ++counters_.closed;
}

}  // namespace takt::firmware

extern "C" {

u32_t sys_now() {
    return static_cast<u32_t>(takt::firmware::microseconds() / 1000);
}

/// Ports and numbers that need no secrecy.
std::uint32_t takt_random() {
    takt::firmware::g_random =
        takt::firmware::g_random * 1664525U + 1013904223U + takt::firmware::board::clock();
    return takt::firmware::g_random;
}

}  // extern "C"
