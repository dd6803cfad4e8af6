// Arbitrary bytes as a table of variables, with options from the first byte. A table without findings is
// written and read again with the same result.
#include <string>

#include "input.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/table.hpp"

namespace {

using namespace takt;

file::TableOptions options_of(std::uint8_t choice) {
    constexpr char kSeparators[] = {0, ',', ';', '\t'};
    file::TableOptions options;
    options.separator = kSeparators[choice % 4];
    if ((choice & 4) != 0)
        options.encoding = (choice & 8) != 0 ? file::Encoding::cp1251 : file::Encoding::utf8;
    options.addresses = file::Addresses{static_cast<std::uint8_t>((choice >> 4) % 3)};
    options.devices = (choice & 0x80) != 0;
    return options;
}

std::vector<std::pair<std::string, std::string>> texts_of(const model::Node& row) {
    std::vector<std::pair<std::string, std::string>> texts;
    for (const auto& [key, value] : row.entries)
        if (!value.text.empty()) texts.emplace_back(key.text, value.text);
    std::ranges::sort(texts);
    return texts;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    auto options = options_of(input.byte());
    const Bytes table = input.bytes(size);
    const auto loaded = file::load_table_text("fuzz.csv", std::string(table.begin(), table.end()), options);
    const auto written = file::write_table(loaded.document.root.items, {});
    if (!loaded.readable || !loaded.findings.empty() || !written.findings.empty()) return 0;
    options.encoding = file::Encoding::utf8;
    options.separator = ',';
    options.addresses = file::Addresses::zero_based;
    const auto again = file::load_table_text("again.csv", written.bytes, options);
    const auto& rows = loaded.document.root.items;
    const auto& same = again.document.root.items;
    fuzz::require(rows.size() == same.size());
    for (std::size_t i = 0; i < rows.size(); ++i) fuzz::require(texts_of(rows[i]) == texts_of(same[i]));
    return 0;
}
