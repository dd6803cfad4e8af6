#include "offline/interface_packets.hpp"

#include "output.hpp"
#include "stoppable_input.hpp"

namespace takt::app {

Result<void> read_packets(const Texts& texts, const std::string& interface, os::PacketSocket& socket,
                          Duration interval, const PacketHandlers& handlers) {
    auto input = StoppableInput::around(interface, socket.descriptor());
    print_status(texts("app.latency.listening", {{"interface", interface}}) + '\n');
    for (bool wanted = true; wanted && !StoppableInput::stopped();) {
        TAKT_TRY(const bool readable, input.wait(interval));
        if (readable) TAKT_CHECK(socket.read(handlers.on_packet));
        TAKT_TRY(wanted, handlers.on_read());
    }
    TAKT_CHECK(socket.stop_receiving());
    for (;;) {
        TAKT_TRY(const bool more, socket.read(handlers.on_packet));
        if (!more) return {};
        TAKT_CHECK(handlers.on_read());
    }
}

}  // namespace takt::app
