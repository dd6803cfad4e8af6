// The files and environment variables that outputs name.
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>

#include "takt/host/project_file.hpp"

namespace takt::host {
namespace {

struct NamedFile {
    std::string_view key;
    const std::string& path;
    bool secret;
};

/// The code of what is wrong with a file; empty: nothing.
std::string_view trouble_of(const std::string& path, bool secret) {
    struct stat status{};
    if (::stat(path.c_str(), &status) != 0 && errno == ENOENT) return "output.file_missing";
    if (::access(path.c_str(), R_OK) != 0 || S_ISDIR(status.st_mode)) return "output.file_unreadable";
    if (secret && (status.st_mode & S_IROTH) != 0) return "output.file_exposed";
    return {};
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
        for (const auto& [key, name, secret] :
             {NamedFile{"password_file", mqtt.password_file, true},
              NamedFile{"key_file", mqtt.key_file, true}, NamedFile{"ca_file", mqtt.ca_file, false},
              NamedFile{"certificate_file", mqtt.certificate_file, false}}) {
            if (name.empty()) continue;
            auto path = (folder / name).string();
            const auto code = trouble_of(path, secret);
            if (!code.empty()) loaded.findings.push_back(warning_of(code, output, i, key, std::move(path)));
        }
        const auto& variable = mqtt.password_env;
        if (!variable.empty() && std::getenv(variable.c_str()) == nullptr)
            loaded.findings.push_back(
                warning_of("output.variable_unset", output, i, "password_env", variable));
    }
}

}  // namespace takt::host
