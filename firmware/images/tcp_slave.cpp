// A Modbus TCP slave with four banks. Register 40108, written by an HMI, is shown on the UART. Input
// registers show the counters of the device.
#include "takt/firmware/main_loop.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/firmware/stack.hpp"
#include "takt/firmware/tcp_device.hpp"
#include "takt/serve/diagnostics.hpp"

namespace {

namespace firmware = takt::firmware;
namespace serve = takt::serve;
using namespace std::chrono_literals;

constexpr std::size_t kShown = 107;  // 40108

firmware::BankStorage<64, 64, 16, 128> g_banks;

/// Text on the UART, sent by interrupts. What does not fit is dropped.
class Console final : public firmware::BoardEvents {
public:
    void put(char character) {
        const firmware::InterruptLock lock;
        if (size_ == text_.size()) return;
        text_[(first_ + size_++) % text_.size()] = character;
        if (size_ == 1) firmware::board::send(static_cast<std::uint8_t>(character));
    }
    void put(const char* text) {
        for (; *text != '\0'; ++text) put(*text);
    }
    void put(std::uint16_t value) {
        std::array<char, 6> digits{};
        std::size_t first = digits.size() - 1;
        do digits[--first] = static_cast<char>('0' + value % 10);
        while ((value /= 10) != 0);
        put(&digits[first]);
    }

    void on_character(std::uint8_t, bool) override {}
    void on_sent() override {
        if (size_ == 0) return;
        first_ = (first_ + 1) % text_.size();
        if (--size_ > 0) firmware::board::send(static_cast<std::uint8_t>(text_[first_]));
    }
    void on_timer() override {}  // it wakes the main loop

private:
    std::array<char, 128> text_{};
    std::size_t first_ = 0;  // being sent
    std::size_t size_ = 0;
};

class Hooks final : public serve::UnitHooks {
public:
    explicit Hooks(Console& console) : console_(console) {}

    std::optional<takt::wire::ExceptionCode> before(const serve::Context&,
                                                    const serve::Access& access) override {
        if (access.area == takt::wire::Area::input_register) show_counters();
        return std::nullopt;
    }
    void written(const serve::Context&, const serve::Access& access) override {
        if (access.area != takt::wire::Area::holding_register) return;
        if (kShown < access.start || kShown >= access.start + access.count) return;
        console_.put("40108 = ");
        console_.put(g_banks.holding_registers[kShown]);
        console_.put("\r\n");
    }
    void attach(const firmware::TcpDevice& device) { device_ = &device; }

private:
    void show_counters() {
        const auto counters = device_->counters();
        const auto memory = device_->memory();
        g_banks.input_registers = {static_cast<std::uint16_t>(firmware::stack_used()),
                                   counters.accepted,
                                   counters.refused,
                                   counters.closed,
                                   counters.unsent_frames,
                                   memory.connections,
                                   memory.pool,
                                   memory.heap,
                                   memory.most_heap};
    }

    Console& console_;
    const firmware::TcpDevice* device_ = nullptr;
};

}  // namespace

int main() {
    static Console console;
    static Hooks hooks(console);
    static serve::Diagnostics diagnostics;
    static serve::Extension* const extensions[]{&diagnostics};
    static std::array units{serve::Unit{takt::UnitId{1}, g_banks.banks(), &hooks, extensions}};
    static serve::Server server(units);
    static firmware::TcpDevice device({.address = {10, 0, 2, 15},
                                       .gateway = {10, 0, 2, 2},
                                       .connection = {.idle_deadline = TAKT_IDLE},
                                       .keep_alive = TAKT_KEEP_ALIVE,
                                       .keep_alive_interval = takt::Duration(TAKT_KEEP_ALIVE) / 4},
                                      server);
    hooks.attach(device);
    if (!firmware::board::open({.baud = 115200, .parity = takt::wire::Parity::none}, console)) return 1;
    if (!device.start()) return 1;
    console.put("listening\r\n");
    firmware::run(device);
}
