// Times of a line as the judge computes them (docs/planning.md, "Bus time"; docs/guarantees.md, "Model"):
// character times, t3.5, the deadline of a transaction, F.
#pragma once

#include "frames.hpp"
#include "takt/base/time.hpp"
#include "takt/model/project.hpp"

namespace takt::judge {

class Arithmetic {
public:
    Arithmetic(const model::Project& project, const model::Line& line);

    /// That many characters one after the other; zero on a byte stream.
    [[nodiscard]] Duration characters(std::size_t count) const;
    /// 3.5 characters, 1750 us above 19200 bit/s; zero but for RTU on a serial line.
    [[nodiscard]] Duration t3_5() const { return t3_5_; }
    /// Least silence before a request.
    [[nodiscard]] Duration silence() const;
    [[nodiscard]] bool is_broadcast(const Asked& asked) const {
        return line_.framing != wire::Framing::tcp && asked.unit == 0;
    }
    /// Longest time from the start of a request to its deadline.
    [[nodiscard]] Duration longest(const model::Device& device, const Asked& asked) const;
    /// F: the cost of a failed attempt; whole microseconds.
    [[nodiscard]] Duration failure(const model::Device& device, const Asked& asked) const;

private:
    [[nodiscard]] Duration wait(const model::Device& device) const;

    const model::Project& project_;
    const model::Line& line_;
    bool serial_;
    std::int64_t bits_;
    Duration t3_5_{};
};

}  // namespace takt::judge
