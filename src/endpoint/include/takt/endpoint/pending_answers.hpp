// The one router of an endpoint's pending answers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "takt/serve/answer.hpp"

namespace takt::endpoint {

/// Issues the token of every answer that cannot be given at once, and delivers the answer when all parts that
/// put it off are done: values on their way to a device, registers on their way to the disk, a relayed
/// request. A request is answered once, however many parts it waits for; the first refusal is the answer.
///
/// The sequence for one request is begin(), put_off() for each part, end(), and later done() or complete().
/// A part may also be done before end(): then it delays nothing. Parts of a broadcast, or of an answer whose
/// connection was closed, may finish late; their tokens are ignored.
///
/// The loop's thread only.
class PendingAnswers {
public:
    using Refusal = std::optional<wire::ExceptionCode>;
    using Done = std::function<void(const Refusal&)>;
    using Observer = std::function<void(serve::Token, Bytes)>;

    /// A listener that delivers answers to its connections. It is removed, or outlives this.
    void add(serve::AnswerSink& sink) { sinks_.push_back(&sink); }
    void remove(serve::AnswerSink& sink) { std::erase(sinks_, &sink); }
    /// Called with every answer right before it is delivered, whether or not its client is still there.
    void set_observer(Observer observer) { observer_ = std::move(observer); }

    /// The handling of a request begins.
    void begin(Bytes request);
    /// The answer to the request at hand waits for one more part. Between begin() and end() only.
    /// @returns the token of its answer, the same for all parts
    [[nodiscard]] serve::Token put_off();
    /// The same. @returns a function that reports the part as done; it may outlive this
    [[nodiscard]] Done put_off_until_called();
    /// The handling ends.
    /// @param answer  what the handling came to
    /// @returns `answer`; or pending, when parts are not done yet; or the exception of a part that was
    /// refused
    [[nodiscard]] serve::Answer end(const serve::Answer& answer);

    /// A part is done. The last one delivers the answer.
    void done(serve::Token token, const Refusal& refusal = {});
    /// A part that has the answer itself is done.
    /// @param pdu  1..253 bytes
    void complete(serve::Token token, Bytes pdu);
    /// The client is gone: the answer is not delivered.
    void forget(serve::Token token) { waiting_.erase(token); }

    /// Answers that are awaited.
    [[nodiscard]] std::size_t size() const { return waiting_.size(); }

private:
    struct Entry {
        std::uint8_t function = 0;
        std::size_t parts = 0;
        bool handled = false;  // end() was called
        Refusal refusal;
        wire::Pdu pdu;
    };

    std::vector<serve::AnswerSink*> sinks_;
    Observer observer_;
    serve::Tokens tokens_;
    std::unordered_map<serve::Token, Entry> waiting_;
    bool handling_ = false;
    std::uint8_t function_ = 0;            // of the request at hand
    std::optional<serve::Token> current_;  // its token, once a part put it off
    std::shared_ptr<PendingAnswers*> alive_ = std::make_shared<PendingAnswers*>(this);
};

}  // namespace takt::endpoint
