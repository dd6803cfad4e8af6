// Bounds the evaluations in progress and ends those that are superseded.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace takt::web {

/// Any thread.
class EvaluationQueue {
public:
    explicit EvaluationQueue(int most) : most_(most) {}

    /// One evaluation, from the request to the answer.
    class Turn {
    public:
        /// Supersedes the evaluation of the same client.
        Turn(EvaluationQueue& queue, std::string client);
        ~Turn();
        Turn(const Turn&) = delete;
        Turn& operator=(const Turn&) = delete;

        /// Blocks until fewer than the most are in progress. @returns false: it was superseded meanwhile
        [[nodiscard]] bool begin();
        [[nodiscard]] bool superseded() const;

    private:
        [[nodiscard]] bool is_superseded() const;

        EvaluationQueue& queue_;
        std::string client_;
        std::uint64_t number_ = 0;
        bool begun_ = false;
    };

private:
    struct Client {
        std::uint64_t newest = 0;
        int turns = 0;
    };

    const int most_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::map<std::string, Client, std::less<>> clients_;  // with turns
    std::uint64_t numbers_ = 0;
    int in_progress_ = 0;
};

}  // namespace takt::web
