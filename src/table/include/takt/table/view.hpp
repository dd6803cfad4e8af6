// A view of a request table in the bytes of its image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "takt/base/data_type.hpp"
#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/table/bytes.hpp"
#include "takt/table/format.hpp"

namespace takt::table {

/// An image that was checked. Its users need no checks of their own: each index is in its range, each text
/// exists, each request can be encoded and covers its members, each value has its words. Never allocates;
/// copies are cheap. The bytes must outlive it and must not change.
class View {
public:
    /// Checks the whole image once.
    /// @returns malformed (subject "magic") if it is no request table; unsupported (subject "version",
    ///          version, known one) if it is another one; too_short, too_long (size, expected size);
    ///          bad_checksum; malformed (subject: kind of record, number: its index) if records contradict
    ///          each other
    [[nodiscard]] static Result<View> open(Bytes image);

    [[nodiscard]] const Header& header() const { return header_; }
    [[nodiscard]] std::uint32_t line_count() const { return header_.lines.count; }
    [[nodiscard]] std::uint32_t device_count() const { return header_.devices.count; }
    [[nodiscard]] std::uint32_t entry_count() const { return header_.entries.count; }
    [[nodiscard]] std::uint32_t item_count() const { return header_.items.count; }

    /// The index is less than the count.
    [[nodiscard]] LineRecord line(std::uint32_t index) const {
        return record<LineRecord>(header_.lines, index);
    }
    [[nodiscard]] DeviceRecord device(std::uint32_t index) const {
        return record<DeviceRecord>(header_.devices, index);
    }
    [[nodiscard]] EntryRecord entry(std::uint32_t index) const {
        return record<EntryRecord>(header_.entries, index);
    }
    [[nodiscard]] ItemRecord item(std::uint32_t index) const {
        return record<ItemRecord>(header_.items, index);
    }
    /// The item that is member `index` of the entry, in the order of addresses.
    [[nodiscard]] std::uint32_t member(const EntryRecord& entry, std::uint32_t index) const {
        return record<std::uint32_t>(header_.members, entry.first_member + index);
    }
    /// A text by the number a record has for it; empty for kNone.
    [[nodiscard]] std::string_view text(std::uint32_t text) const;

private:
    explicit View(Bytes image) : image_(image) {}

    template <class Record>
    [[nodiscard]] Record record(const Section& section, std::uint32_t index) const {
        Record result{};
        Take take(image_.data() + section.offset + index * record_size<Record>());
        code(take, result);
        return result;
    }

    Bytes image_;
    Header header_;
};

/// The number of 16-bit words of an item's value: as many as it has registers; a bool has one.
std::uint32_t words_of(const ItemRecord& item);

/// The number of registers (or coils: one) that an item occupies in the request of its entry.
std::uint32_t items_of(const ItemRecord& item);

/// The type of an item of a view.
inline DataType type_of(const ItemRecord& item) {
    return static_cast<DataType>(item.type);
}

}  // namespace takt::table
