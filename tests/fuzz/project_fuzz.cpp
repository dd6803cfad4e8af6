// Arbitrary text as a project file, with arbitrary bytes as its table (behind the first NUL). It is refused
// with located findings, or read, checked and planned; a valid project can be written as rows. A change of it
// is put into the text, or refused.
#include <string>

#include "input.hpp"
#include "takt/file/convert.hpp"
#include "takt/file/edit.hpp"
#include "takt/file/load.hpp"
#include "takt/file/table.hpp"
#include "takt/model/findings.hpp"
#include "takt/plan/plan.hpp"

namespace {

using namespace takt;

constexpr std::size_t kMostVariablesPlanned = 200;  // limits the time of one plan

std::size_t variables_of(const model::Project& project) {
    std::size_t count = 0;
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) count += device.variables.size();
    return count;
}

/// Replaces each scalar, and removes every third item and entry.
void change(model::Node& node) {
    if (node.kind == model::Node::Kind::scalar) node.text += " y";
    for (auto& item : node.items) change(item);
    for (auto& [key, value] : node.entries) change(value);
    for (std::size_t i = 2; i < node.items.size(); i += 3)
        node.items.erase(node.items.begin() + static_cast<std::ptrdiff_t>(i));
    for (std::size_t i = 2; i < node.entries.size(); i += 3)
        node.entries.erase(node.entries.begin() + static_cast<std::ptrdiff_t>(i));
}

/// The text as it is stays; a changed one reads as the changed document, or is an error.
void edit(const std::string& text) {
    auto read = file::read_project_text("fuzz.yaml", text);
    if (!read.readable || !read.findings.empty() || read.document.root.kind != model::Node::Kind::mapping)
        return;
    const auto same = file::patched_project(text, read.document.root);
    fuzz::require(!same || *same == text);
    change(read.document.root);
    (void)file::patched_project(text, read.document.root);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string input(reinterpret_cast<const char*>(data), size);
    const std::size_t end = std::min(input.find('\0'), input.size());
    const std::string table = end < size ? input.substr(end + 1) : std::string();
    edit(input.substr(0, end));
    const auto loaded = file::load_text("fuzz.yaml", input.substr(0, end),
                                        [&](const std::string&) -> Result<std::string> { return table; });
    for (const auto& finding : loaded.findings) fuzz::require(!finding.code.empty());
    if (!loaded.readable) return 0;
    const auto checked = model::interpret(loaded.document);
    (void)file::write_table(file::rows_of_project(loaded.document), {});
    if (variables_of(checked.project) > kMostVariablesPlanned) return 0;
    const auto plan = plan::make_plan(checked.project);
    fuzz::require(plan.lines.size() == checked.project.lines.size());
    return 0;
}
