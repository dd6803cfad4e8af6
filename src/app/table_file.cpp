#include "takt/app/table_file.hpp"
#include "takt/app/console.hpp"

#include <string_view>

#include "takt/file/read.hpp"
#include "takt/os/replace.hpp"
#include "takt/table/format.hpp"

namespace takt::app {
namespace {

std::string key_of(const Error& error) {
    switch (error.code) {
        case Code::unsupported: return "app.table.newer";
        case Code::too_short: return "app.table.truncated";
        case Code::too_long: return "app.table.followed";
        case Code::bad_checksum: return "app.table.corrupt";
        default: return error.subject.view() == "magic" ? "app.table.foreign" : "app.table.inconsistent";
    }
}

}  // namespace

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

void complain_about_table(const Texts& texts, const std::string& path, const Error& error) {
    const Texts::Arguments arguments{{"file", path},
                                     {"version", std::to_string(error.numbers[0])},
                                     {"known", std::to_string(error.numbers[1])},
                                     {"there", std::to_string(error.numbers[0])},
                                     {"needed", std::to_string(error.numbers[1])},
                                     {"what", std::string(error.subject.view())},
                                     {"index", std::to_string(error.numbers[0])}};
    const auto key = key_of(error);
    print_error(texts(key, arguments));
    if (key == "app.table.foreign") return;
    print_status("    " +
                 texts(key == "app.table.newer" ? key + ".advice" : "app.table.make_anew", arguments) + '\n');
}

Result<void> write_table_file(const std::string& path, const table::Image& image) {
    const std::string_view bytes(reinterpret_cast<const char*>(image.data()), image.size());
    return os::replace_file(path, bytes, {.mode = 0644});
}

}  // namespace takt::app
