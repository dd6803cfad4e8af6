#include "takt/client/probe_connection.hpp"

namespace takt::client {

Result<int> ProbeConnection::transact(const wire::PreparedRequest& request) {
    constexpr int kInvalidCode = 255;  // of an exception with the code 0
    TAKT_TRY(const auto response, client_.transact(request));
    if (!response.is_exception()) return 0;
    return response.exception() == 0 ? kInvalidCode : int{response.exception()};
}

}  // namespace takt::client
