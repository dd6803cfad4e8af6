// The master of a request table (`takt table build`) on a microcontroller.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "takt/table/executor.hpp"
#include "takt/table/view.hpp"

namespace takt::firmware {

/// The buffers of one line of a table, and its executor. The numbers are the most that a table may have.
/// No heap.
template <std::size_t Entries, std::size_t Devices, std::size_t Items, std::size_t ValueWords,
          std::size_t WriteWords>
class TableMaster {
public:
    /// @returns the errors of table::View::open() and table::Executor::can_run(); too_short (needed, there)
    ///          if the buffers are too small
    [[nodiscard]] Result<void> can_run(Bytes image) {
        TAKT_TRY(const table::View view, table::View::open(image));
        return table::Executor::can_run(view, kLine, memory(), workspace());
    }

    /// Makes the executor of the first line of the image. May be called again, with another image: all values
    /// begin anew.
    /// @param image  outlives the master; it is read in place
    /// @returns what can_run() returns; then the image before goes on
    [[nodiscard]] Result<void> start(Bytes image) {
        TAKT_CHECK(can_run(image));
        view_ = *table::View::open(image);
        table::initialise(*view_, memory());
        executor_.emplace(*view_, kLine, memory(), workspace());
        return {};
    }

    [[nodiscard]] bool started() const { return executor_.has_value(); }
    /// @pre started()
    [[nodiscard]] table::Executor& executor() { return *executor_; }
    [[nodiscard]] const table::View& view() const { return *view_; }
    [[nodiscard]] std::span<std::uint16_t> values() { return values_; }
    [[nodiscard]] std::span<const table::ItemState> items() const {
        return std::span(items_).first(view_->item_count());
    }
    [[nodiscard]] wire::CharacterFormat format() const {
        const table::LineRecord line = view_->line(kLine);
        return {.baud = line.baud,
                .data_bits = line.data_bits,
                .parity = static_cast<wire::Parity>(line.parity),
                .stop_bits = line.stop_bits};
    }

private:
    static constexpr std::uint32_t kLine = 0;

    [[nodiscard]] table::Memory memory() {
        return {.values = values_, .read = read_, .wanted = wanted_, .items = items_};
    }
    [[nodiscard]] table::Workspace workspace() { return {.entries = entries_, .devices = devices_}; }

    std::optional<table::View> view_;
    std::optional<table::Executor> executor_;
    std::array<std::uint16_t, ValueWords> values_{};
    std::array<std::uint16_t, WriteWords> read_{};
    std::array<std::uint16_t, WriteWords> wanted_{};
    std::array<table::ItemState, Items> items_{};
    std::array<table::EntryState, Entries> entries_{};
    std::array<table::DeviceState, Devices> devices_{};
};

}  // namespace takt::firmware
