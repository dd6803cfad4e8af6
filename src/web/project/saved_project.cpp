#include "project/saved_project.hpp"

#include <cstdint>

#include "takt/base/ascii.hpp"
#include "takt/file/edit.hpp"
#include "takt/file/read.hpp"

namespace takt::web {

std::string revision_of(std::string_view bytes) {
    std::uint64_t hash = 0xCBF29CE484222325U;
    for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
    std::string text;
    for (int shift = 60; shift >= 0; shift -= 4)
        text += lower_case(hex_digit(static_cast<unsigned>(hash >> shift)));
    return text + '-' + std::to_string(bytes.size());
}

Result<std::shared_ptr<const SavedProject>> ProjectOnDisk::read() {
    TAKT_TRY(auto text, file::read_file(file_, file::kMaxFileBytes));
    auto revision = revision_of(text);
    const std::scoped_lock lock(mutex_);
    if (last_ && last_->revision == revision) return last_;
    auto alone = file::read_project_text(file_, text);
    last_ = std::make_shared<const SavedProject>(
        SavedProject{std::move(text), std::move(revision), std::move(alone)});
    return last_;
}

}  // namespace takt::web
