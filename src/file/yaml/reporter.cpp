#include "yaml/reporter.hpp"

#include <algorithm>
#include <tuple>

#include "takt/base/utf8.hpp"
#include "takt/file/load.hpp"

namespace takt::file {
namespace {

constexpr std::size_t kMaxValueBytes = 80;

// Cuts the text to one printable line that fits into a message.
std::string shown(std::string text) {
    std::ranges::replace_if(
        text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7F; }, '?');
    if (text.size() <= kMaxValueBytes) return text;
    return std::string(whole_characters(text, kMaxValueBytes)) + "…";
}

}  // namespace

void Reporter::error(std::string_view code, const model::SourceLocation& location, Details details) {
    add(model::Severity::error, code, location, std::move(details));
}

void Reporter::warning(std::string_view code, const model::SourceLocation& location, Details details) {
    add(model::Severity::warning, code, location, std::move(details));
}

void Reporter::add(model::Severity severity, std::string_view code, const model::SourceLocation& location,
                   Details details) {
    if (findings_.size() >= kMaxFindings) return;
    if (findings_.size() + 1 == kMaxFindings) {
        code = "file.more_findings";
        severity = model::Severity::error;
        details = {.allowed = std::to_string(kMaxFindings)};
    }
    findings_.push_back({severity, std::string(code), location, shown(std::move(details.path)),
                         shown(std::move(details.value)), std::move(details.allowed),
                         std::move(details.arguments)});
}

std::vector<model::Finding> Reporter::take() {
    std::ranges::stable_sort(findings_, {}, [](const model::Finding& finding) {
        return std::tuple(finding.location.file, finding.location.line, finding.location.column);
    });
    return std::move(findings_);
}

}  // namespace takt::file
