#include "takt/os/set_aside.hpp"

#include <filesystem>
#include <system_error>

namespace takt::os {

Result<std::string> set_aside(const std::string& path, const std::string& companion) {
    constexpr int kMostSetAside = 999;
    for (int i = 1; i <= kMostSetAside; ++i) {
        std::string aside = path + ".damaged-" + std::to_string(i);
        std::error_code error;
        if (std::filesystem::exists(aside, error)) continue;
        std::filesystem::rename(path, aside, error);
        if (error) return fail(Code::io_failed, path, error.value());
        if (!companion.empty()) std::filesystem::rename(path + companion, aside + companion, error);
        return aside;
    }
    return fail(Code::queue_full, path, kMostSetAside);
}

}  // namespace takt::os
