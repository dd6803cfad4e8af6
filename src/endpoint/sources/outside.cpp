#include "sources/outside.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "takt/base/ascii.hpp"
#include "takt/endpoint/answer.hpp"
#include "takt/os/open.hpp"
#include "takt/value/text.hpp"

namespace takt::endpoint {
namespace {

/// Reads a file, a FIFO or a device without waiting for its writer.
Result<std::string> read_bounded(const std::string& path, std::size_t limit) {
    const os::Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
    if (!file) return fail(Code::cannot_open, path, errno);
    auto text = os::read_all(file.get(), path, limit);
    if (!text && text.error().code == Code::too_long)  // the file's size is not known
        return fail(Code::too_long, path, static_cast<std::int64_t>(limit));
    return text;
}

constexpr std::string_view kAroundCells = " \r\"";

std::vector<std::string_view> cells(std::string_view row, char separator) {
    std::vector<std::string_view> all;
    while (true) {
        const auto end = row.find(separator);
        all.push_back(trimmed(row.substr(0, end), kAroundCells));
        if (end == std::string_view::npos) return all;
        row.remove_prefix(end + 1);
    }
}

std::optional<double> cell_number(std::string_view cell) {
    const auto value = value::parse(DataType::float64, false, cell);
    return value ? std::optional(std::get<double>(*value)) : std::nullopt;
}

/// The index of a column by its heading, or else by its number.
std::optional<std::size_t> find_column(const std::vector<std::string_view>& head, std::string_view column) {
    if (const auto found = std::ranges::find(head, column); found != head.end())
        return static_cast<std::size_t>(found - head.begin());
    const auto index = cell_number(column);
    if (!index || *index < 1 || *index > static_cast<double>(head.size())) return std::nullopt;
    return static_cast<std::size_t>(*index) - 1;
}

}  // namespace

Result<std::string> read_small_file(const std::string& path) {
    TAKT_TRY(auto text, read_bounded(path, kMostText));
    text.erase(text.find_last_not_of("\r\n") + 1);
    return text;
}

Result<std::vector<double>> read_column(const std::string& path, const std::string& column) {
    TAKT_TRY(const auto text, read_bounded(path, kMostReplay));
    std::string_view rest = text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    std::optional<std::size_t> index;
    char separator = ',';
    std::vector<double> values;
    for (std::size_t line = 1; !rest.empty(); ++line) {
        const auto row = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(row.size() + 1, rest.size()));
        if (trimmed(row, kAroundCells).empty()) continue;
        const bool first = !index;
        if (first)
            for (const char other : {';', '\t'})
                if (row.find(other) != std::string_view::npos) separator = other;
        const auto all = cells(row, separator);
        if (first) {
            index = find_column(all, column);
            if (!index) return fail(Code::not_found, path + ": " + column);
            if (!std::ranges::all_of(all, [](auto cell) { return cell_number(cell).has_value(); })) continue;
        }
        const auto value = *index < all.size() ? cell_number(all[*index]) : std::nullopt;
        if (!value)
            return fail(Code::syntax,
                        path + ":" + std::to_string(line) + ": " +
                            std::string(*index < all.size() ? all[*index] : std::string_view()));
        values.push_back(*value);
    }
    if (values.empty()) return fail(Code::not_found, path + ": " + column);
    return values;
}

model::Command with_value(const model::Command& command, const std::string& value) {
    constexpr std::string_view kPlace = "{value}";
    model::Command filled = command;
    for (std::size_t i = 1; i < filled.run.size(); ++i) {
        auto& argument = filled.run[i];
        for (auto at = argument.find(kPlace); at != std::string::npos;
             at = argument.find(kPlace, at + value.size()))
            argument.replace(at, kPlace.size(), value);
    }
    return filled;
}

}  // namespace takt::endpoint
