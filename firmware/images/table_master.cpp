// For tests on `mps2`: the master of the request table in the flash, where the emulator has loaded it. Notes
// each call of the executor with its time and bytes, so that the executor of the desktop can repeat it
// (tests/firmware/table_replay.cpp); shows the buffer at the end.
//
// File "script": words of 32 bits. Milliseconds until the end; then commands, four words each, by time: the
// milliseconds, 0 (set a variable) or 1 (set a local bool), the item, the value (at most two registers).
#include <algorithm>
#include <array>

#include "takt/firmware/engine_port.hpp"
#include "takt/firmware/main_loop.hpp"
#include "takt/firmware/semihosting.hpp"
#include "takt/firmware/stack.hpp"
#include "takt/firmware/table_master.hpp"
#include "takt/firmware/table_store.hpp"
#include "takt/table/owen_view.hpp"

namespace {

namespace firmware = takt::firmware;
namespace semihosting = takt::firmware::semihosting;
namespace table = takt::table;
using takt::Bytes;
using takt::Instant;

struct Command {
    std::uint32_t at;  // milliseconds
    std::uint32_t local;
    std::uint32_t item;
    std::uint32_t value;
};
struct Script {
    std::uint32_t duration;
    std::array<Command, 64> commands;
};
Script g_script;

using Master = firmware::TableMaster<48, 16, 96, 256, 128>;
Master* g_master;  // of main()

class Text {
public:
    Text& add(const char* text) {
        while (*text != 0 && size_ + 1 < text_.size()) text_[size_++] = *text++;
        return *this;
    }
    Text& add(std::uint64_t number) {
        std::array<char, 21> digits{};
        char* first = &digits.back();
        do *--first = static_cast<char>('0' + number % 10);
        while ((number /= 10) != 0);
        return add(" ").add(first);
    }
    Text& add(Bytes bytes) {
        add(" ");
        for (const unsigned byte : bytes) {
            const char hex[]{"0123456789abcdef"[byte >> 4U], "0123456789abcdef"[byte & 15U], 0};
            add(hex);
        }
        return *this;
    }
    ~Text() {
        text_[size_++] = '\n';
        semihosting::write(text_.data());
    }

private:
    std::array<char, 1100> text_{};
    std::size_t size_ = 0;
};

std::uint64_t nanoseconds(Instant t) {
    return static_cast<std::uint64_t>(t.time_since_epoch().count());
}

/// Notes the calls of an engine, and passes them on.
class Notes final : public takt::Engine {
public:
    explicit Notes(takt::Engine& engine) : engine_(engine) {}
    void on_link(Instant t, bool up) override {
        Text().add("link").add(nanoseconds(t)).add(std::uint64_t{up});
        engine_.on_link(t, up);
    }
    void on_bytes(Instant t, Bytes bytes) override {
        Text().add("bytes").add(nanoseconds(t)).add(bytes);
        engine_.on_bytes(t, bytes);
    }
    void on_tick(Instant t) override {
        Text().add("tick").add(nanoseconds(t));
        engine_.on_tick(t);
    }
    Bytes transmit(Instant t) override {
        const Bytes bytes = engine_.transmit(t);
        Text().add("transmit").add(nanoseconds(t)).add(bytes);
        return bytes;
    }
    Instant next_wakeup() const override { return engine_.next_wakeup(); }

private:
    takt::Engine& engine_;
};

void execute(const Command& command, Instant t) {
    Text().add("command").add(nanoseconds(t)).add(command.local).add(command.item).add(command.value);
    const std::array words{static_cast<std::uint16_t>(command.value),
                           static_cast<std::uint16_t>(command.value >> 16U)};
    const table::ItemRecord item = g_master->view().item(command.item);
    if (command.local == 0) {
        static_cast<void>(
            g_master->executor().set(command.item, std::span(words).first(table::words_of(item))));
        return;
    }
    std::uint16_t& value = g_master->values()[item.place];
    const bool before = value != 0;
    value = words[0];
    g_master->executor().on_local(t, command.item, before, value != 0);
}

void show_buffer() {
    for (std::uint32_t i = 0; i < g_master->view().item_count(); ++i) {
        const table::ItemRecord item = g_master->view().item(i);
        const table::ItemState& state = g_master->items()[i];
        Text line;
        line.add("item").add(i).add(static_cast<std::uint64_t>(state.quality)).add(state.status);
        for (const auto word : g_master->values().subspan(item.place, table::words_of(item))) line.add(word);
    }
}

}  // namespace

int main() {
    static Master master;
    g_master = &master;
    semihosting::read_file("script", 6, {reinterpret_cast<std::uint8_t*>(&g_script), sizeof g_script});
    static std::array<std::uint8_t, 8192> expanded;
    Bytes image = firmware::TableStore::stored()[0];
    if (table::is_owen(image))
        if (const auto view = table::OwenView::open(image))
            image = table::expand(*view, expanded).value_or(Bytes{});
    if (const auto started = master.start(image); !started) {
        Text().add("refused").add(static_cast<std::uint64_t>(started.error().code));
        semihosting::exit();
    }
    static Notes notes(master.executor());
    static firmware::EnginePort port(notes);
    if (!port.start(master.format())) return 1;
    std::size_t next = 0;
    for (;;) {
        while (port.work()) {}
        const Instant now = port.now();
        const auto passed = [&](std::uint32_t milliseconds) {
            return now >= Instant{} + std::chrono::milliseconds(milliseconds);
        };
        if (passed(g_script.duration)) break;
        const Command& command = g_script.commands[next];
        if (next + 1 < g_script.commands.size() && command.at != 0 && passed(command.at)) {
            ++next;
            execute(command, now);
            port.changed();
        }
        const firmware::InterruptLock lock;
        if (!port.has_work()) firmware::board::sleep();
    }
    show_buffer();
    Text().add("stack").add(firmware::stack_used());
    semihosting::exit();
}
