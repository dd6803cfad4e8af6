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
    /// Checks the image and makes the executor of its first line.
    /// @param image  outlives the master; it is read in place
    /// @returns the errors of table::View::open() and table::Executor::can_run(); too_short (needed, there)
    ///          if the buffers are too small
    [[nodiscard]] Result<void> start(Bytes image) {
        TAKT_TRY(view_, table::View::open(image));
        const table::Memory memory{.values = values_, .read = read_, .wanted = wanted_, .items = items_};
        const table::Workspace workspace{.entries = entries_, .devices = devices_};
        if (const auto able = table::Executor::can_run(*view_, kLine, memory, workspace); !able)
            return std::unexpected(able.error());
        table::initialise(*view_, memory);
        executor_.emplace(*view_, kLine, memory, workspace);
        return {};
    }

    /// @pre start() has succeeded
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
