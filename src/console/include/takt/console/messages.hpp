// Where a console puts what is no data.
#pragma once

#include <functional>
#include <string>

namespace takt::console {

/// Both are called on the thread of the console.
struct Messages {
    std::function<void(const std::string& text)> status;    ///< with its line end
    std::function<void(const std::string& message)> error;  ///< one sentence, without a line end
};

}  // namespace takt::console
