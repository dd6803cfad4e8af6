// The complete slave: every function.
#include "takt/firmware/rtu_device.hpp"
#include "takt/serve/diagnostics.hpp"
#include "takt/serve/fifos.hpp"
#include "takt/serve/files.hpp"
#include "takt/serve/identification.hpp"
#include "takt/wire/frame.hpp"

namespace {

namespace serve = takt::serve;

takt::firmware::BankStorage<64, 64, 64, 64> g_banks;
std::array<std::uint8_t, takt::wire::kMaxRtuFrame> g_frame;
std::array<std::uint16_t, 16> g_records;
std::array<std::uint16_t, 8> g_queue;

constexpr serve::IdentificationObject kObjects[]{{0, "Takt"}, {1, "device"}, {2, "1"}};
constexpr std::uint8_t kServerId[]{'T'};

}  // namespace

volatile std::size_t g_received;
volatile std::size_t g_to_send;

int main() {
    static serve::EventLog log;
    static serve::Diagnostics diagnostics({}, &log);
    static serve::Identification identification(kObjects, kServerId);
    static const serve::File files[]{{1, g_records}};
    static serve::Files file_records(files);
    static const serve::Fifo fifos[]{{0, g_queue}};
    static serve::Fifos queues(fifos);
    static serve::Extension* const extensions[]{&diagnostics, &identification, &file_records, &queues};
    static std::array units{serve::Unit{takt::UnitId{1}, g_banks.banks(), nullptr, extensions}};
    static serve::Server server(units);
    for (;;) {
        const std::size_t received = g_received;
        if (received == 0 || received > g_frame.size()) continue;
        g_to_send = takt::firmware::process(server, takt::Bytes(g_frame).first(received), g_frame);
        g_received = 0;
    }
}
