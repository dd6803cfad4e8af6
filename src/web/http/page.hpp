// The page, compiled into the program.
#pragma once

#include <span>
#include <string_view>

namespace takt::web {

/// A file of the page, compressed with gzip.
struct PageFile {
    std::string_view path;  ///< "/", "/app.js", "/app.css"
    std::string_view content_type;
    std::string_view etag;  ///< with its quotes
    std::string_view gzip;
    std::string_view plain;  ///< for clients that do not accept gzip
};

/// Written by src/web/embed_page at build time, from ui/dist.
[[nodiscard]] std::span<const PageFile> page_files();

[[nodiscard]] const PageFile* find_page_file(std::string_view path);

}  // namespace takt::web
