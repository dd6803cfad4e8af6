// The files and environment variables that outputs name.
#include <sys/stat.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>

#include "takt/file/read.hpp"
#include "takt/host/project_file.hpp"

namespace takt::host {
namespace {

struct NamedFile {
    std::string_view key;
    const std::string& path;
    bool secret;
    std::size_t limit;
};

/// The code of what is wrong with a file; empty: nothing.
std::string_view trouble_of(const std::string& path, const NamedFile& named) {
    const auto readable = file::check_readable(path, named.limit);
    if (!readable) {
        const auto& error = readable.error();
        if (error.code == Code::unsupported) return "output.file_irregular";
        if (error.code == Code::too_long) return "output.file_too_long";
        return error.numbers[0] == ENOENT ? "output.file_missing" : "output.file_unreadable";
    }
    struct stat status{};
    const bool exposed = ::stat(path.c_str(), &status) == 0 && (status.st_mode & S_IROTH) != 0;
    return named.secret && exposed ? "output.file_exposed" : std::string_view();
}

model::Finding warning_of(std::string_view code, const model::Output& output, std::size_t index,
                          std::string_view key, std::string value) {
    return {.severity = model::Severity::warning,
            .code = std::string(code),
            .location = output.location,
            .path = "outputs[" + std::to_string(index) + "]." + std::string(key),
            .value = std::move(value),
            .allowed = {},
            .arguments = {{"key", std::string(key)}}};
}

}  // namespace

void check_output_files(LoadedProject& loaded, const std::string& project_file) {
    const auto folder = std::filesystem::path(project_file).parent_path();
    for (std::size_t i = 0; i < loaded.project.outputs.size(); ++i) {
        const auto& output = loaded.project.outputs[i];
        const auto& mqtt = output.mqtt;
        const NamedFile files[] = {
            {"password_file", mqtt.password_file, true, file::kMaxSecretBytes},
            {"key_file", mqtt.key_file, true, file::kMaxSecretBytes},
            {"ca_file", mqtt.ca_file, false, file::kMaxCertificateBytes},
            {"certificate_file", mqtt.certificate_file, false, file::kMaxCertificateBytes},
        };
        for (const auto& named : files) {
            if (named.path.empty()) continue;
            auto path = (folder / named.path).string();
            const auto code = trouble_of(path, named);
            if (code.empty()) continue;
            auto& finding =
                loaded.findings.emplace_back(warning_of(code, output, i, named.key, std::move(path)));
            if (code != "output.file_too_long") continue;
            finding.allowed = "0.." + std::to_string(named.limit);
            finding.arguments.emplace_back("limit", std::to_string(named.limit));
        }
        const auto& variable = mqtt.password_env;
        if (!variable.empty() && std::getenv(variable.c_str()) == nullptr)
            loaded.findings.push_back(
                warning_of("output.variable_unset", output, i, "password_env", variable));
    }
}

}  // namespace takt::host
