// The notices of endpoints and hosts as text.
#pragma once

#include "takt/console/messages.hpp"
#include "takt/endpoint/notice.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::console {

using report::Texts;

/// Gives the text of a notice to the messages: a warning as an error, anything else as status.
void put_notice(const Texts& texts, const Messages& messages, const endpoint::Notice& notice);

}  // namespace takt::console
