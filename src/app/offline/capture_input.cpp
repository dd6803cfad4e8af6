#include "offline/capture_input.hpp"

#include "output.hpp"
#include "stoppable_input.hpp"

namespace takt::app {

Result<void> read_capture(const std::string& source, capture::CaptureReader& reader,
                          const std::function<void(const report::Done&)>& show) {
    TAKT_TRY(auto input, StoppableInput::open(source));
    std::uint64_t bytes = 0;
    for (;;) {
        TAKT_TRY(const auto count, input.read(reader.space()));
        if (count == 0) break;
        bytes += count;
        if (!reader.filled(count) || stdout_error() != 0) return {};
        show({.done = bytes, .total = input.size().value_or(0)});
    }
    if (!StoppableInput::stopped()) reader.end();
    return {};
}

}  // namespace takt::app
