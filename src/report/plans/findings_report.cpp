#include "takt/report/plans/findings_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "states/byte_order_report.hpp"

namespace takt::report {
namespace {

const char* finding_severity_name(model::Severity severity) {
    switch (severity) {
        case model::Severity::note: return "note";
        case model::Severity::warning: return "warning";
        case model::Severity::error: break;
    }
    return "error";
}

/// The name of the file, or nothing where the index has none.
std::string file_name(std::span<const std::string> files, const model::Finding& finding) {
    return finding.location.file < files.size() ? files[finding.location.file] : std::string();
}

std::string location_text(std::span<const std::string> files, const model::Finding& finding) {
    std::string text = file_name(files, finding);
    if (text.empty()) text = "?";
    if (finding.location.line > 0)
        text += fmt::format(":{}:{}", finding.location.line, finding.location.column);
    return text;
}

file::Json finding_json(const Texts& texts, std::span<const std::string> files,
                        const model::Finding& finding) {
    auto object = file::Json::object();
    object.set("severity", finding_severity_name(finding.severity));
    object.set("code", finding.code);
    object.set("file", file_name(files, finding));
    object.set("line", finding.location.line);
    object.set("column", finding.location.column);
    object.set("path", finding.path);
    object.set("value", finding.value);
    object.set("allowed", finding.allowed);
    object.set("message", texts.message(finding));
    object.set("advice", texts.advice(finding));
    return object;
}

std::string count_by_severity(std::span<const model::Finding> findings, model::Severity severity) {
    return std::to_string(std::ranges::count(findings, severity, &model::Finding::severity));
}

}  // namespace

std::string findings_text(const Texts& texts, std::span<const std::string> files,
                          std::span<const model::Finding> findings, model::Severity least) {
    std::string text;
    std::string last_advice;
    for (const auto& finding : findings) {
        if (finding.severity < least) continue;
        text += fmt::format("{}: {}: ", location_text(files, finding),
                            texts(fmt::format("app.{}", finding_severity_name(finding.severity))));
        if (!finding.path.empty()) text += finding.path + ": ";
        text += texts.message(finding) + '\n';
        auto advice = texts.advice(finding);
        if (!advice.empty() && advice != last_advice) text += "    " + advice + '\n';
        last_advice = std::move(advice);
    }
    return text;
}

file::Json findings_json(const Texts& texts, std::span<const std::string> files,
                         std::span<const model::Finding> findings) {
    auto list = file::Json::array();
    for (const auto& finding : findings) list.push_back(finding_json(texts, files, finding));
    return list;
}

std::string findings_text(const Texts& texts, const host::LoadedFile& loaded, model::Severity least) {
    return findings_text(texts, loaded.files, loaded.findings, least);
}

file::Json findings_json(const Texts& texts, const host::LoadedFile& loaded) {
    return findings_json(texts, loaded.files, loaded.findings);
}

file::Json check_json(const Texts& texts, const host::LoadedFile& loaded) {
    auto object = file::Json::object();
    object.set("findings", findings_json(texts, loaded));
    return object;
}

file::Json check_json(const Texts& texts, const host::LoadedProject& loaded) {
    auto object = check_json(texts, static_cast<const host::LoadedFile&>(loaded));
    if (!loaded.has_errors()) object.set("devices", byte_orders_json(loaded.project));
    return object;
}

std::string findings_summary(const Texts& texts, const std::string& project_file,
                             std::span<const model::Finding> findings) {
    return texts("app.checked", {{"file", project_file},
                                 {"errors", count_by_severity(findings, model::Severity::error)},
                                 {"warnings", count_by_severity(findings, model::Severity::warning)},
                                 {"notes", count_by_severity(findings, model::Severity::note)}}) +
           '\n';
}

}  // namespace takt::report
