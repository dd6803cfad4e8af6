// The rules that the records of an image keep. View::open checks them once.
#pragma once

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/table/view.hpp"
#include "takt/wire/function.hpp"

namespace takt::table {

class Rules {
public:
    /// @param texts  the bytes of the texts
    Rules(const View& view, Bytes texts) : view_(view), texts_(texts) {}

    /// @returns malformed (kind of record, index) for the first record that breaks a rule
    [[nodiscard]] Result<void> check() const;

private:
    [[nodiscard]] bool holds(const LineRecord& line, std::uint32_t index) const;
    [[nodiscard]] bool holds(const DeviceRecord& device, std::uint32_t index) const;
    [[nodiscard]] bool holds(const EntryRecord& entry, std::uint32_t index) const;
    [[nodiscard]] bool holds(const ItemRecord& item, std::uint32_t index) const;
    [[nodiscard]] bool members_hold(const EntryRecord& entry) const;
    [[nodiscard]] bool is_text(std::uint32_t text) const;
    [[nodiscard]] bool is_local_of(std::uint32_t item, bool boolean) const;

    const View& view_;
    Bytes texts_;
};

}  // namespace takt::table
