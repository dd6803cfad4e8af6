#include "takt/app/table_file.hpp"

#include <string_view>

#include "takt/app/console.hpp"
#include "takt/file/read.hpp"
#include "takt/os/replace.hpp"
#include "takt/table/format.hpp"

namespace takt::app {
std::optional<TableFile> read_table_file(const Texts& texts, const std::string& path) {
    const auto text = file::read_file(path, table::kMaxImage);
    if (!text) {
        print_error(texts.describe(text.error()));
        return std::nullopt;
    }
    TableFile read;
    read.image.assign(text->begin(), text->end());
    read.owen = text->starts_with(table::kOwenMagic);
    return read;
}

Result<void> write_table_file(const std::string& path, const table::Image& image) {
    const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
    return os::replace_file(path, bytes, {.mode = 0644});
}

}  // namespace takt::app
