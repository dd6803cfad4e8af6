// The LAN9118 of the MPS2 boards. Registers: SMSC LAN9118 data sheet, revision 1.5.
#include "takt/firmware/ethernet.hpp"

#include <algorithm>
#include <cstring>

#include "takt/firmware/cortex_m.hpp"

namespace takt::firmware::board {
namespace {

constexpr std::uint32_t kBase = 0x40200000;
constexpr std::uint32_t kReceiveData = kBase + 0x00;
constexpr std::uint32_t kSendData = kBase + 0x20;
constexpr std::uint32_t kReceiveStatus = kBase + 0x40;
constexpr std::uint32_t kSendStatus = kBase + 0x48;
constexpr std::uint32_t kInterruptConfig = kBase + 0x54;
constexpr std::uint32_t kInterruptStatus = kBase + 0x58;
constexpr std::uint32_t kInterruptEnable = kBase + 0x5C;
constexpr std::uint32_t kByteTest = kBase + 0x64;
constexpr std::uint32_t kFifoLevels = kBase + 0x68;
constexpr std::uint32_t kSendConfig = kBase + 0x70;
constexpr std::uint32_t kHardwareConfig = kBase + 0x74;
constexpr std::uint32_t kReceiveFifo = kBase + 0x7C;
constexpr std::uint32_t kSendFifo = kBase + 0x80;
constexpr std::uint32_t kMacCommand = kBase + 0xA4;
constexpr std::uint32_t kMacData = kBase + 0xA8;

constexpr std::uint32_t kByteTestValue = 0x87654321;
constexpr std::uint32_t kReceived = 1U << 3U;     // interrupt: a frame was received
constexpr std::uint32_t kLinkChange = 1U << 18U;  // interrupt: of the PHY
constexpr std::uint32_t kReceiveError = 1U << 15U;
constexpr std::uint32_t kFirstAndLast = 1U << 13U | 1U << 12U;
constexpr unsigned kChecksum = 4;
constexpr unsigned kInterrupt = 13;

// Registers of the MAC and, behind them, of the PHY
constexpr std::uint32_t kMacControl = 1;
constexpr std::uint32_t kAddressHigh = 2;
constexpr std::uint32_t kAddressLow = 3;
constexpr std::uint32_t kPhyCommand = 6;
constexpr std::uint32_t kPhyData = 7;
constexpr std::uint32_t kPhyStatus = 1;
constexpr std::uint32_t kPhyInterruptSource = 29;
constexpr std::uint32_t kPhyInterruptMask = 30;
constexpr std::uint32_t kPhyLinkDown = 1U << 4U;
constexpr std::uint32_t kPhyNegotiated = 1U << 6U;
constexpr std::uint32_t kPhyLinkUp = 1U << 2U;  // of kPhyStatus

constexpr unsigned kPatience = 100'000;  // reads of a register; the controller needs a few

bool g_link;

void wait_for_mac() {
    for (unsigned i = 0; i < kPatience && (reg(kMacCommand) >> 31U) != 0; ++i) {}
}

void write_mac(std::uint32_t index, std::uint32_t value) {
    wait_for_mac();
    reg(kMacData) = value;
    reg(kMacCommand) = 1U << 31U | index;
    wait_for_mac();
}

std::uint32_t read_mac(std::uint32_t index) {
    wait_for_mac();
    reg(kMacCommand) = 1U << 31U | 1U << 30U | index;
    wait_for_mac();
    return reg(kMacData);
}

void phy_command(std::uint32_t index, std::uint32_t write) {
    constexpr std::uint32_t kAddress = 1;  // of the PHY inside
    write_mac(kPhyCommand, kAddress << 11U | index << 6U | write << 1U | 1U);
    for (unsigned i = 0; i < kPatience && (read_mac(kPhyCommand) & 1U) != 0; ++i) {}
}

std::uint32_t read_phy(std::uint32_t index) {
    phy_command(index, 0);
    return read_mac(kPhyData);
}

void write_phy(std::uint32_t index, std::uint32_t value) {
    write_mac(kPhyData, value);
    phy_command(index, 1);
}

// The bit of a lost link stays set until it is read.
void update_link() {
    static_cast<void>(read_phy(kPhyInterruptSource));
    static_cast<void>(read_phy(kPhyStatus));
    g_link = (read_phy(kPhyStatus) & kPhyLinkUp) != 0;
}

[[nodiscard]] bool frame_waits() {
    return (reg(kReceiveFifo) >> 16U & 0xFFU) != 0;
}

}  // namespace

bool open_ethernet() {
    for (unsigned i = 0; i < kPatience && reg(kByteTest) != kByteTestValue; ++i) {}
    if (reg(kByteTest) != kByteTestValue) return false;
    constexpr std::uint32_t kFullDuplex = 1U << 20U;
    constexpr std::uint32_t kTransmitter = 1U << 3U;
    constexpr std::uint32_t kReceiver = 1U << 2U;
    reg(kHardwareConfig) = 5U << 16U;  // 5 KB to send, the rest to receive
    reg(kFifoLevels) = 0;              // an interrupt with the first frame
    reg(kSendConfig) = 1U << 1U;
    write_mac(kMacControl, kFullDuplex | kTransmitter | kReceiver);
    write_phy(kPhyInterruptMask, kPhyLinkDown | kPhyNegotiated);
    update_link();
    reg(kInterruptStatus) = ~0U;
    reg(kInterruptEnable) = kReceived | kLinkChange;
    reg(kInterruptConfig) = 1U << 8U | 1U << 4U | 1U << 0U;  // enabled, high, push-pull
    enable_interrupt(kInterrupt);
    return true;
}

std::array<std::uint8_t, 6> ethernet_address() {
    const std::uint32_t low = read_mac(kAddressLow);
    const std::uint32_t high = read_mac(kAddressHigh);
    std::array<std::uint8_t, 6> address{};
    for (unsigned i = 0; i < address.size(); ++i)
        address[i] = static_cast<std::uint8_t>(i < 4 ? low >> 8U * i : high >> 8U * (i - 4));
    return address;
}

bool ethernet_link() {
    return g_link;
}

std::size_t receive_ethernet(std::span<std::uint8_t> into) {
    if ((reg(kInterruptStatus) & kLinkChange) != 0) {
        reg(kInterruptStatus) = kLinkChange;
        update_link();
    }
    while (frame_waits()) {
        const std::uint32_t status = reg(kReceiveStatus);
        const std::size_t length = status >> 16U & 0x3FFFU;
        for (std::size_t i = 0; i < length; i += 4) {
            const std::uint32_t word = reg(kReceiveData);
            if (i < into.size()) std::memcpy(&into[i], &word, std::min<std::size_t>(4, into.size() - i));
        }
        const bool fits = length > kChecksum && length - kChecksum <= into.size();
        if (fits && (status & kReceiveError) == 0) return length - kChecksum;
    }
    reg(kInterruptStatus) = kReceived;
    reg(kInterruptEnable) = kReceived | kLinkChange;
    return 0;
}

bool send_ethernet(Bytes frame) {
    constexpr std::size_t kCommands = 8;
    while ((reg(kSendFifo) >> 16U & 0xFFU) != 0) static_cast<void>(std::uint32_t{reg(kSendStatus)});
    if ((reg(kSendFifo) & 0xFFFFU) < frame.size() + kCommands + 4) return false;
    const auto length = static_cast<std::uint32_t>(frame.size());
    reg(kSendData) = kFirstAndLast | length;
    reg(kSendData) = length;
    for (std::size_t i = 0; i < frame.size(); i += 4) {
        std::uint32_t word = 0;
        std::memcpy(&word, &frame[i], std::min<std::size_t>(4, frame.size() - i));
        reg(kSendData) = word;
    }
    return true;
}

bool ethernet_waits() {
    return frame_waits() || (reg(kInterruptStatus) & kLinkChange) != 0;
}

}  // namespace takt::firmware::board

extern "C" {

/// The controller holds its line until its frames are read: masked until then (receive_ethernet).
void ethernet_interrupt() {
    takt::firmware::reg(takt::firmware::board::kInterruptEnable) = 0;
}

}  // extern "C"
