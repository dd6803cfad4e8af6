// Arbitrary text as a project file, with arbitrary bytes as its table (behind the first NUL). It is refused
// with located findings, or read, checked and planned; a valid project can be written as rows.
#include <string>

#include "input.hpp"
#include "takt/file/convert.hpp"
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

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string input(reinterpret_cast<const char*>(data), size);
    const std::size_t end = std::min(input.find('\0'), input.size());
    const std::string table = end < size ? input.substr(end + 1) : std::string();
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
