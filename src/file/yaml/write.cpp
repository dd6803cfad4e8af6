#include "takt/file/write.hpp"

#include "takt/os/replace.hpp"

namespace takt::file {

Result<void> write_file(const std::string& path, std::string_view bytes, bool replace) {
    constexpr ::mode_t kMode = 0666;
    return os::replace_file(path, bytes, {.mode = kMode, .replace = replace});
}

}  // namespace takt::file
