// The smallest whole device: one unit, four banks, functions 1-6, 15, 16 (22 and 23 come with them). This
// image is measured. A real device reads `g_frame` from its UART and sends it back.
#include "takt/firmware/rtu_device.hpp"
#include "takt/wire/frame.hpp"

namespace {

takt::firmware::BankStorage<64, 64, 64, 64> g_banks;
std::array<std::uint8_t, takt::wire::kMaxRtuFrame> g_frame;

}  // namespace

/// Lengths of the received frame and of the answer, set and read by a debugger or a UART's interrupt.
volatile std::size_t g_received;
volatile std::size_t g_to_send;

int main() {
    static std::array units{takt::serve::Unit{takt::UnitId{1}, g_banks.banks()}};
    static takt::serve::Server server(units);
    for (;;) {
        const std::size_t received = g_received;
        if (received == 0 || received > g_frame.size()) continue;
        g_to_send = takt::firmware::process(server, takt::Bytes(g_frame).first(received), g_frame);
        g_received = 0;
    }
}
