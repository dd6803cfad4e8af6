#include "takt/console/notices.hpp"

#include "takt/report/event_report.hpp"

namespace takt::console {
namespace {

/// Notices that are no warnings.
bool is_status(const endpoint::Notice& notice) {
    return notice.code == "app.serving" || notice.code == "app.access.in_force" ||
           notice.code == "app.registers.new";
}

}  // namespace

void put_notice(const Texts& texts, const Messages& messages, const endpoint::Notice& notice) {
    const std::string text = report::notice_text(texts, notice);
    is_status(notice) ? messages.status(text + '\n') : messages.error(text);
}

}  // namespace takt::console
