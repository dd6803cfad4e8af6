// Shared by the tests of this module: output in memory, and a small project.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "../../host/test/rig.hpp"
#include "takt/console/command_reader.hpp"
#include "takt/os/record_writer.hpp"

namespace takt::console::test {

using namespace std::chrono_literals;

inline constexpr const char* kPlant = R"(takt: 1
lines:
  - name: main
    transport: simulated
    framing: rtu
    devices:
      - name: Boiler
        address: 1
        poll_period: 100ms
        turnaround: 5ms
        variables:
          - {name: Level, type: int, register: 0, read: 0x03, write: 0x10}
          - {name: "Pump speed", type: real, register: 1, read: 0x03, write: 0x10, scale: 0.5}
locals:
  - {name: go, type: bool}
)";

inline const Texts& english() {
    static const Texts kTexts(text::Language::english);
    return kTexts;
}

/// Text that a writing thread puts into memory.
class Memory {
public:
    [[nodiscard]] std::unique_ptr<os::Sink> sink() { return std::make_unique<MemorySink>(text_); }
    /// After the writer has finished.
    [[nodiscard]] const std::string& text() const { return *text_; }

private:
    class MemorySink final : public os::Sink {
    public:
        explicit MemorySink(std::shared_ptr<std::string> text) : text_(std::move(text)) {}
        Written write(std::string_view text) override {
            *text_ += text;
            return {.bytes = text.size()};
        }

    private:
        std::shared_ptr<std::string> text_;
    };

    std::shared_ptr<std::string> text_ = std::make_shared<std::string>();
};

/// The answers to commands, in their order.
struct Answers {
    [[nodiscard]] Reply reply() {
        return [this](const Answer& answer) {
            lines.push_back(answer.line);
            json.push_back(answer.json.dump());
        };
    }
    std::vector<std::string> lines;
    std::vector<std::string> json;
};

}  // namespace takt::console::test
