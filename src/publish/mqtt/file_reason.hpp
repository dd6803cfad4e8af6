// Why a file that an output names cannot be used.
#pragma once

#include <cstring>
#include <string>

#include "takt/base/result.hpp"

namespace takt::publish {

/// @param error  of file::read_file() or file::check_readable()
inline std::string file_reason(const Error& error) {
    switch (error.code) {
        case Code::unsupported: return "not a regular file";
        case Code::too_long: return "longer than " + std::to_string(error.numbers[1]) + " bytes";
        default: return std::strerror(static_cast<int>(error.numbers[0]));
    }
}

}  // namespace takt::publish
