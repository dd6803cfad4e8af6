#include "takt/console/notices.hpp"

#include "takt/report/states/event_report.hpp"

namespace takt::console {

void put_notice(const Texts& texts, const Messages& messages, const endpoint::Notice& notice) {
    const std::string text = report::notice_text(texts, notice);
    notice.severity == endpoint::Notice::Severity::status ? messages.status(text + '\n')
                                                          : messages.error(text);
}

}  // namespace takt::console
