// Repeats the calls that the master on a board noted (firmware/images/table_master.cpp) with the executor of
// this computer.
//
// usage: table_replay TABLE <notes
// Prints the notes as they come out here: "transmit" lines with the bytes that the executor gives now.
#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "takt/table/executor.hpp"
#include "takt/table/owen_view.hpp"
#include "takt/table/view.hpp"

namespace {

using namespace takt;

std::vector<std::uint8_t> bytes_of(const std::string& hex) {
    std::vector<std::uint8_t> bytes(hex.size() / 2);
    for (std::size_t i = 0; i < bytes.size(); ++i)
        std::from_chars(hex.data() + 2 * i, hex.data() + 2 * i + 2, bytes[i], 16);
    return bytes;
}

struct Buffers {
    explicit Buffers(const table::View& view)
        : values(view.header().value_words),
          read(view.header().write_words),
          wanted(view.header().write_words),
          items(view.item_count()),
          entries(view.entry_count()),
          devices(view.device_count()) {}

    std::vector<std::uint16_t> values, read, wanted;
    std::vector<table::ItemState> items;
    std::vector<table::EntryState> entries;
    std::vector<table::DeviceState> devices;
};

void execute(const table::View& view, table::Executor& executor, Buffers& buffers, Instant t,
             std::istream& line) {
    std::uint32_t local = 0;
    std::uint32_t item = 0;
    std::uint32_t value = 0;
    line >> local >> item >> value;
    const table::ItemRecord record = view.item(item);
    if (local == 0) {
        const std::array words{static_cast<std::uint16_t>(value), static_cast<std::uint16_t>(value >> 16U)};
        static_cast<void>(executor.set(item, std::span(words).first(table::words_of(record))));
        return;
    }
    std::uint16_t& shown = buffers.values[record.place];
    const bool before = std::exchange(shown, static_cast<std::uint16_t>(value)) != 0;
    executor.on_local(t, item, before, shown != 0);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    std::ifstream file(argv[1], std::ios::binary);
    const std::vector<char> text{std::istreambuf_iterator<char>(file), {}};
    std::vector<std::uint8_t> image(text.begin(), text.end());
    if (table::is_owen(image)) {
        const auto owen = table::OwenView::open(image);
        if (!owen) return 1;
        std::vector<std::uint8_t> expanded(table::expanded_size(*owen));
        if (!table::expand(*owen, expanded)) return 1;
        image = expanded;
    }
    const auto view = table::View::open(image);
    if (!view) return 1;
    Buffers buffers(*view);
    const table::Memory memory{
        .values = buffers.values, .read = buffers.read, .wanted = buffers.wanted, .items = buffers.items};
    table::initialise(*view, memory);
    table::Executor executor(*view, 0, memory, {.entries = buffers.entries, .devices = buffers.devices});
    for (std::string text_line; std::getline(std::cin, text_line);) {
        std::istringstream line(text_line);
        std::string what;
        std::int64_t nanoseconds = 0;
        line >> what >> nanoseconds;
        const Instant t = Instant{} + Duration(nanoseconds);
        std::string hex;
        if (what == "link") {
            executor.on_link(t, true);
        } else if (what == "bytes") {
            line >> hex;
            executor.on_bytes(t, bytes_of(hex));
        } else if (what == "tick") {
            executor.on_tick(t);
        } else if (what == "command") {
            execute(*view, executor, buffers, t, line);
        } else if (what == "transmit") {
            text_line = fmt::format("transmit {} ", nanoseconds);
            for (const auto byte : executor.transmit(t)) text_line += fmt::format("{:02x}", byte);
        } else {
            continue;
        }
        fmt::print("{}\n", text_line);
    }
    for (std::uint32_t i = 0; i < view->item_count(); ++i) {
        const table::ItemRecord item = view->item(i);
        const table::ItemState& state = buffers.items[i];
        fmt::print("item {} {} {}", i, static_cast<int>(state.quality), state.status);
        for (std::uint32_t w = 0; w < table::words_of(item); ++w)
            fmt::print(" {}", buffers.values[item.place + w]);
        fmt::print("\n");
    }
}
