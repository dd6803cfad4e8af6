// Own echo on a two-wire line.
#pragma once

#include <cstddef>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"

namespace takt::serve {

/// Recognises the bytes of the frame just sent when the receiver hears them too.
///
/// A repeated write can look exactly like the answer to its first copy. So an echo is only believed until a
/// window ends that is too short for another party to have kept the silence and sent as many characters.
class EchoFilter {
public:
    struct Split {
        Bytes replay;  ///< bytes held back earlier that turn out to be no echo; they come before `rest`
        Bytes rest;    ///< of the bytes given: what is no echo
        bool whole_echo = false;  ///< the frame came back completely
    };

    /// @param frame   the bytes sent; they stay valid and unchanged while the filter is used
    /// @param window  when a complete echo is no longer believed
    /// @param pause   bytes held back are forgotten after a pause of that length
    void sent(Bytes frame, Instant window, Duration pause);

    [[nodiscard]] Split split(Instant t, Bytes bytes);

    void reset() { frame_ = {}; }

private:
    Bytes frame_;  ///< empty: nothing is expected
    std::size_t matched_ = 0;
    Instant window_;
    Instant last_match_;
    Duration pause_{};
};

}  // namespace takt::serve
