// Arbitrary bytes as a request table: refused, or parsed, built again, and run on a line with arbitrary
// answers. Each input is tried unchanged and with corrected length and checksum, because few mutations would
// pass those checks.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "takt/table/executor.hpp"
#include "takt/table/owen.hpp"
#include "takt/table/restore.hpp"

namespace {

using namespace takt;

constexpr std::size_t kMostWords = 1 << 16;
constexpr int kSteps = 300;
constexpr std::size_t kLongestOwen = 4096;

/// Endless bytes out of the input.
class Noise {
public:
    explicit Noise(Bytes bytes) : bytes_(bytes) {}
    std::uint8_t next() {
        state_ = state_ * 1664525U + 1013904223U;
        return static_cast<std::uint8_t>(bytes_[position_++ % bytes_.size()] ^ (state_ >> 24));
    }

private:
    Bytes bytes_;
    std::size_t position_ = 0;
    std::uint32_t state_ = 1;
};

/// The answer: none, the right one by form, an exception, or random bytes.
std::vector<std::uint8_t> answer(Noise& noise, const table::LineRecord& line, Bytes sent) {
    const auto framing = wire::Framing{line.framing};
    std::vector<std::uint8_t> rubbish;
    if (framing == wire::Framing::ascii || noise.next() % 4 == 0) {
        for (int i = noise.next() % 32; i > 0; --i) rubbish.push_back(noise.next());
        return rubbish;
    }
    const std::size_t head = framing == wire::Framing::tcp ? 7 : 1;
    const Bytes pdu =
        framing == wire::Framing::tcp ? sent.subspan(head) : sent.subspan(head, sent.size() - 3);
    const auto transaction = static_cast<std::uint16_t>(sent[0] << 8 | sent[1]);
    const UnitId unit{framing == wire::Framing::tcp ? sent[6] : sent[0]};
    const auto request = wire::decode_request(pdu);
    if (!request) std::abort();  // an executor sends only what can be read
    wire::Pdu back;
    back.push_back(pdu[0]);
    if (noise.next() % 4 == 0) {
        back[0] = static_cast<std::uint8_t>(pdu[0] | 0x80);
        back.push_back(noise.next());
    } else if (const auto* read = std::get_if<wire::ReadRequest>(&*request)) {
        const auto length = wire::response_pdu_length(read->function, read->quantity);
        back.push_back(static_cast<std::uint8_t>(length - 2));
        while (back.size() < length) back.push_back(noise.next());
    } else {
        back.assign(pdu.first(5));
    }
    const auto frame = wire::encode_frame(framing, unit, transaction, back.span());
    return {frame.begin(), frame.end()};
}

void poke(Noise& noise, table::Executor& executor, const table::View& view, table::Memory& memory,
          Instant t) {
    if (view.item_count() == 0) return;
    const auto index = static_cast<std::uint32_t>(noise.next()) % view.item_count();
    const auto item = view.item(index);
    std::vector<std::uint16_t> words(table::words_of(item));
    for (auto& word : words) word = noise.next();
    if (item.device != table::kNone) {
        (void)executor.set(index, words);
        return;
    }
    const bool before = memory.values[item.place] != 0;
    std::copy(words.begin(), words.end(), memory.values.begin() + item.place);
    executor.on_local(t, index, before, words[0] != 0);
}

void run(const table::View& view, std::uint32_t line, Bytes input) {
    if (view.header().value_words > kMostWords || view.header().write_words > kMostWords) return;
    std::vector<std::uint16_t> values(view.header().value_words);
    std::vector<std::uint16_t> read(view.header().write_words);
    std::vector<std::uint16_t> wanted(view.header().write_words);
    std::vector<table::ItemState> items(view.item_count());
    std::vector<table::EntryState> entries(view.line(line).entry_count);
    std::vector<table::DeviceState> devices(view.line(line).device_count);
    table::Memory memory{values, read, wanted, items};
    table::initialise(view, memory);
    if (!table::Executor::can_run(view, line, memory, {entries, devices})) return;
    table::Executor executor(view, line, memory, {entries, devices});
    const auto record = view.line(line);
    Noise noise(input);
    Instant t{};
    executor.on_link(t, true);
    for (int step = 0; step < kSteps; ++step) {
        if (noise.next() % 8 == 0) poke(noise, executor, view, memory, t);
        if (noise.next() % 64 == 0) executor.on_link(t, noise.next() % 2 == 0);
        const Bytes sent = executor.transmit(t);
        std::vector<std::uint8_t> back;
        if (!sent.empty() && noise.next() % 4 != 0) back = answer(noise, record, sent);
        t += std::chrono::microseconds(noise.next() * 20);
        if (!back.empty()) executor.on_bytes(t, back);
        const Instant next = executor.next_wakeup();
        if (next == kNever) continue;
        t = std::max(t, next);
        executor.on_tick(t);
    }
}

void use(Bytes image, Bytes input) {
    const auto view = table::View::open(image);
    if (!view) return;
    const auto project = table::project_of(*view);
    const auto plan = table::plan_of(*view);
    if (project.lines.size() != plan.lines.size()) std::abort();
    for (std::uint32_t line = 0; line < std::min(view->line_count(), 4U); ++line) run(*view, line, input);
}

void use_owen(Bytes image) {
    if (image.size() > kLongestOwen) return;  // its members may take a hundred times as much
    const auto owen = table::read_owen(image);
    if (!owen) return;
    if (table::write_owen(*owen) != table::Image(image.begin(), image.end())) std::abort();
    const auto view = table::OwenView::open(image);
    std::vector<std::uint8_t> room(table::expanded_size(*view));
    if (const auto expanded = table::expand(*view, room)) use(*expanded, image);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    // On the heap in its exact size, so that the sanitizer detects an access beyond its end.
    const auto bytes = std::make_unique<std::uint8_t[]>(size);
    std::copy(data, data + size, bytes.get());
    const Bytes image(bytes.get(), size);
    use(image, image);
    use_owen(image);
    if (size < table::kHeaderSize) return 0;
    table::Image sealed(data, data + size);
    sealed.shrink_to_fit();
    std::copy(table::kMagic, table::kMagic + table::kMagicSize, sealed.begin());
    table::seal(sealed);
    use(sealed, image);
    std::copy(table::kOwenMagic, table::kOwenMagic + table::kMagicSize, sealed.begin());
    table::seal(sealed);
    use_owen(sealed);
    return 0;
}
