// A slave with all that SerialDevice offers: four banks, function 8, a hook for writes, retained registers.
// The build sets the framing, the format of characters and the strictness (firmware/CMakeLists.txt).
#include "takt/firmware/main_loop.hpp"
#include "takt/firmware/retained_registers.hpp"
#include "takt/firmware/serial_device.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/firmware/stack.hpp"
#include "takt/serve/diagnostics.hpp"

namespace {

namespace firmware = takt::firmware;
namespace serve = takt::serve;

// The first registers keep their values without power.
constexpr std::size_t kRetained = 8;
// The input register that shows how much stack was used.
constexpr std::size_t kStackRegister = 0;

firmware::BankStorage<32, 32, 32, 64> g_banks;

/// Stores what was written before the response promises it. Shows the use of the stack.
class Hooks final : public serve::UnitHooks {
public:
    explicit Hooks(firmware::RetainedRegisters& retained) : retained_(retained) {}

    std::optional<takt::wire::ExceptionCode> before(const serve::Context&,
                                                    const serve::Access& access) override {
        if (access.area == takt::wire::Area::input_register)
            g_banks.input_registers[kStackRegister] = static_cast<std::uint16_t>(firmware::stack_used());
        return std::nullopt;
    }
    void written(const serve::Context&, const serve::Access& access) override {
        if (access.area == takt::wire::Area::holding_register) retained_.store(access.start, access.count);
    }

private:
    firmware::RetainedRegisters& retained_;
};

}  // namespace

int main() {
    static firmware::RetainedRegisters retained(
        std::span(g_banks.holding_registers).first(std::min(kRetained, firmware::RetainedRegisters::most())));
    retained.restore();
    static Hooks hooks(retained);
    static serve::Diagnostics diagnostics;
    static serve::Extension* const extensions[]{&diagnostics};
    static std::array units{serve::Unit{takt::UnitId{1}, g_banks.banks(), &hooks, extensions}};
    static serve::Server server(units);
    static firmware::SerialDevice device({.framing = takt::wire::Framing::TAKT_FRAMING,
                                          .format = {.baud = TAKT_BAUD, .parity = takt::wire::Parity::none},
                                          .strict = TAKT_STRICT,
                                          .frame_silence = TAKT_SILENCE},
                                         server);
    if (!device.start()) return 1;
    firmware::run(device);
}
