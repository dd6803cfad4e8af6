// What a stream of server-sent events sends.
#pragma once

#include <string>
#include <string_view>

namespace takt::web {

/// The events of one browser. Used on the server's thread only; its producer has its own.
class StreamSource {
public:
    virtual ~StreamSource() = default;

    /// Appends what is to be sent next, as text of the event stream. Called when everything before was
    /// accepted by the socket. Nothing appended: there is nothing; the producer calls WebServer::poke() when
    /// there is something.
    /// @returns false at the end of the stream
    [[nodiscard]] virtual bool take(std::string& out) = 0;
};

/// "event: NAME\ndata: DATA\n\n"
/// @param data  one line
[[nodiscard]] std::string event_text(std::string_view name, std::string_view data);

}  // namespace takt::web
