#include "unit_functions.hpp"

namespace takt::endpoint {

std::span<std::uint16_t> UnitFunctions::add_file(std::uint16_t number, std::size_t records, bool read_only) {
    const std::span<std::uint16_t> all = records_.emplace_back(records);
    file_list_.push_back({number, all, read_only});
    return all;
}

std::span<serve::Extension* const> UnitFunctions::extensions() {
    const auto* const text = reinterpret_cast<const std::uint8_t*>(server_text_.data());
    const Bytes id = server_text_.empty() ? Bytes() : Bytes(server_id_);
    identification_.emplace(objects_, id, Bytes(text, server_text_.size()));
    extensions_ = {&diagnostics_, &*identification_};
    if (!file_list_.empty()) extensions_.push_back(&files_.emplace(file_list_));
    if (!fifo_list_.empty()) extensions_.push_back(&fifos_.emplace(fifo_list_));
    return extensions_;
}

}  // namespace takt::endpoint
