// A controller on `mps2`: the master of a request table on port 0, and a slave on port 1 that shows the
// buffer and takes new tables (docs/firmware.md, "A controller").
#include <algorithm>
#include <array>

#include "takt/firmware/engine_port.hpp"
#include "takt/firmware/main_loop.hpp"
#include "takt/firmware/serial_device.hpp"
#include "takt/firmware/slave_frame.hpp"
#include "takt/firmware/stack.hpp"
#include "takt/firmware/table_master.hpp"
#include "takt/firmware/table_store.hpp"
#include "takt/serve/files.hpp"
#include "takt/table/owen_view.hpp"

namespace {

namespace firmware = takt::firmware;
namespace serve = takt::serve;
namespace table = takt::table;
using takt::Bytes;
using takt::Result;
using takt::wire::Area;
using takt::wire::ExceptionCode;

constexpr std::size_t kItems = 64, kValueWords = 128;
constexpr std::uint8_t kBufferUnit = 1, kLoaderUnit = 2;
constexpr std::uint16_t kLoad = 1;  // the command
constexpr unsigned kLine = 0, kSlave = 1;

using Master = firmware::TableMaster<32, 8, kItems, kValueWords, 64>;

/// Input registers of the loader.
enum Shown : std::uint8_t { kState, kError, kEntries, kShownItems, kStack, kShownCount };

firmware::BankStorage<0, 0, 2 * kItems, kValueWords> g_buffer;
firmware::BankStorage<0, 0, kShownCount, 1> g_loader;
constexpr serve::ValueLimits kCommands{{0, 0}, kLoad, kLoad};
std::array<serve::Unit, 2>* g_units;       // of main()
std::array<std::uint16_t, 8192> g_staged;  // file 1: the new table, high byte first

/// The master and its tables. A new table replaces the running one when no request is in flight.
class Controller {
public:
    enum class State : std::uint8_t { no_table, running, replacing };

    /// Runs the newest table of the flash that can be run.
    void start() {
        for (const Bytes image : firmware::TableStore::stored()) {
            if (image.empty()) continue;
            if (install(image, {reinterpret_cast<std::uint8_t*>(g_staged.data()), sizeof g_staged})) break;
        }
        if (state_ == State::replacing) run_next();
    }

    /// Takes the table of the file. The one before goes on if it is refused.
    void load() {
        swap_bytes();
        const std::span staged(reinterpret_cast<std::uint8_t*>(g_staged.data()), sizeof g_staged);
        std::uint32_t length = 0;
        table::Take{staged.data() + table::kLengthOffset}(length);
        length = std::min<std::uint32_t>(length, sizeof g_staged);
        install(Bytes(staged).first(length), staged.subspan(length));
        swap_bytes();
    }

    bool work() {
        bool worked = port_ && port_->work();
        if (state_ == State::replacing && (!port_ || (master_.executor().idle() && !port_->sending()))) {
            run_next();
            worked = true;
        }
        return worked;
    }
    [[nodiscard]] bool has_work() const { return port_ && port_->has_work(); }

    [[nodiscard]] State state() const { return state_; }
    [[nodiscard]] std::uint16_t error() const { return error_; }
    [[nodiscard]] bool started() const { return master_.started(); }
    [[nodiscard]] Master& master() { return master_; }
    void changed() { port_->changed(); }
    [[nodiscard]] takt::Instant now() { return port_->now(); }

private:
    static void swap_bytes() {
        for (auto& word : g_staged) word = static_cast<std::uint16_t>(word << 8U | word >> 8U);
    }

    /// Checks and stores a table. @param scratch  for one of owen-kc1 in Takt's own format
    bool install(Bytes image, std::span<std::uint8_t> scratch) {
        const auto stored = try_install(image, scratch);
        error_ = stored ? 0 : static_cast<std::uint16_t>(stored.error().code);
        if (!stored) return false;
        next_ = *stored;
        if (port_) master_.executor().stop();
        state_ = State::replacing;
        return true;
    }

    Result<Bytes> try_install(Bytes image, std::span<std::uint8_t> scratch) {
        const auto stored = firmware::TableStore::stored();
        const bool in_flash =
            std::ranges::any_of(stored, [&](Bytes other) { return other.data() == image.data(); });
        const bool is_owen = table::is_owen(image);
        if (is_owen) {
            TAKT_TRY(const auto view, table::OwenView::open(image));
            TAKT_TRY(image, table::expand(view, scratch));
        }
        TAKT_CHECK(master_.can_run(image));
        if (in_flash && !is_owen) return image;
        return firmware::TableStore::store(image, running_);
    }

    void run_next() {
        state_ = State::no_table;
        if (!master_.start(next_)) return;  // the flash has changed
        if (!port_) port_.emplace(master_.executor(), kLine);
        running_ = next_;
        // Only the registers of this table exist.
        auto& banks = (*g_units)[0].banks;
        banks.holding_registers.values =
            std::span(g_buffer.holding_registers).first(master_.view().header().value_words);
        banks.input_registers.values =
            std::span(g_buffer.input_registers).first(2 * std::size_t{master_.view().item_count()});
        if (port_->start(master_.format())) state_ = State::running;
    }

    Master master_;
    std::optional<firmware::EnginePort> port_;
    State state_ = State::no_table;
    Bytes next_, running_;
    std::uint16_t error_ = 0;
};

/// Unit 1: holding registers are the value buffer, input registers the status and the quality of each item. A
/// write sets whole variables and locals.
class Buffer final : public serve::UnitHooks {
public:
    explicit Buffer(Controller& controller) : controller_(controller) {}

    std::optional<ExceptionCode> before(const serve::Context&, const serve::Access& access) override {
        show();
        if (access.write && visit(access, &Buffer::is_writable) != access.count)
            return ExceptionCode::illegal_data_address;
        return std::nullopt;
    }

    void written(const serve::Context&, const serve::Access& access) override {
        visit(access, &Buffer::set);
        controller_.changed();
    }

private:
    using Use = bool (Buffer::*)(std::uint32_t index, const table::ItemRecord& item);

    void show() {
        Master& master = controller_.master();
        std::ranges::copy(master.values(), g_buffer.holding_registers.begin());
        for (std::size_t i = 0; const table::ItemState& state : master.items()) {
            g_buffer.input_registers[i++] = state.status;
            g_buffer.input_registers[i++] = static_cast<std::uint16_t>(state.quality);
        }
    }

    /// The items that lie in the access. @returns the words of those for which `use` is true
    std::size_t visit(const serve::Access& access, Use use) {
        const table::View& view = controller_.master().view();
        std::size_t words = 0;
        for (std::uint32_t i = 0; i < view.item_count(); ++i) {
            const auto item = view.item(i);
            const std::uint32_t size = table::words_of(item);
            const bool inside =
                item.place >= access.start && item.place + size <= std::uint32_t{access.start} + access.count;
            if (inside && (this->*use)(i, item)) words += size;
        }
        return words;
    }

    bool is_writable(std::uint32_t, const table::ItemRecord& item) {
        return item.device == table::kNone || item.write != 0;
    }

    bool set(std::uint32_t index, const table::ItemRecord& item) {
        Master& master = controller_.master();
        const auto words = std::span(g_buffer.holding_registers).subspan(item.place, table::words_of(item));
        if (item.device != table::kNone) return master.executor().set(index, words).has_value();
        const auto shown = master.values().subspan(item.place, words.size());
        const bool before = shown[0] != 0;
        std::ranges::copy(words, shown.begin());
        master.executor().on_local(controller_.now(), index, before, shown[0] != 0);
        return true;
    }

    Controller& controller_;
};

/// Unit 2: the state of the controller, the command, and file 1.
class Loader final : public serve::UnitHooks {
public:
    explicit Loader(Controller& controller) : controller_(controller) {}

    std::optional<ExceptionCode> before(const serve::Context&, const serve::Access& access) override {
        if (!access.write)
            show();
        else if (controller_.state() == Controller::State::replacing)
            return ExceptionCode::server_device_busy;
        return std::nullopt;
    }
    void written(const serve::Context&, const serve::Access&) override {
        controller_.load();
        g_loader.holding_registers[0] = 0;
    }

private:
    void show() {
        auto& shown = g_loader.input_registers;
        shown[kState] = static_cast<std::uint16_t>(controller_.state());
        shown[kError] = controller_.error();
        shown[kStack] = static_cast<std::uint16_t>(firmware::stack_used());
        if (!controller_.started()) return;
        shown[kEntries] = static_cast<std::uint16_t>(controller_.master().view().entry_count());
        shown[kShownItems] = static_cast<std::uint16_t>(controller_.master().view().item_count());
    }

    Controller& controller_;
};

}  // namespace

int main() {
    static Controller controller;
    static Buffer buffer(controller);
    static Loader loader(controller);
    static const std::array files{serve::File{1, g_staged}};
    static serve::Files table_file(files);
    static serve::Extension* const extensions[]{&table_file};
    static std::array units{serve::Unit{takt::UnitId{kBufferUnit}, {}, &buffer, {}},
                            serve::Unit{takt::UnitId{kLoaderUnit}, g_loader.banks(), &loader, extensions}};
    static serve::Server server(units);
    static firmware::SerialDevice slave({.format = {.baud = 115200, .parity = takt::wire::Parity::none},
                                         .frame_silence = TAKT_SILENCE,
                                         .port = kSlave},
                                        server);
    g_units = &units;
    units[1].banks.holding_registers.limits = std::span(&kCommands, 1);
    controller.start();
    if (!slave.start()) return 1;
    firmware::run(controller, slave);
}
