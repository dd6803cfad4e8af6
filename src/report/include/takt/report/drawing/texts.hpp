// Messages by code, filled with arguments, in one language.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/base/time.hpp"
#include "takt/model/findings.hpp"
#include "takt/text/language.hpp"
#include "takt/value/value.hpp"

namespace takt::report {

/// Messages by code, in one language. Cheap to copy.
class Texts {
public:
    explicit Texts(text::Language language) : language_(language) {}

    using Arguments = std::vector<std::pair<std::string, std::string>>;

    /// The message of `code` with its {placeholders} filled in.
    [[nodiscard]] std::string operator()(std::string_view code, const Arguments& arguments = {}) const;

    /// A duration with its unit (text::duration_text()).
    [[nodiscard]] std::string duration(Duration duration) const;
    /// The same of a proved bound, which is rounded up.
    [[nodiscard]] std::string bound(Duration bound) const;
    /// The same in milliseconds with all digits (plan::time_text()).
    [[nodiscard]] std::string exact(Duration duration) const;

    /// The message of a finding, and its advice (empty where the code has none). The argument `variant` names
    /// one of several advices of a code.
    [[nodiscard]] std::string message(const model::Finding& finding) const;
    [[nodiscard]] std::string advice(const model::Finding& finding) const;
    /// The texts of model::output_remedies(), separated by `; `.
    [[nodiscard]] std::string remedies(std::string_view words, const Arguments& arguments = {}) const;

    /// The message of an error, then its advice, as one text.
    [[nodiscard]] std::string describe(const Error& error) const;

    /// The quality of a value and the reason: "bad, time-out".
    [[nodiscard]] std::string quality(value::Quality quality, value::Reason reason) const;

    [[nodiscard]] text::Language language() const { return language_; }

private:
    text::Language language_;
};

/// Why a file was not written: it exists and may not be replaced, or the error.
[[nodiscard]] std::string unwritten_text(const Texts& texts, const std::string& path, const Error& error);

/// The sentence without the full stop at its end, so that more text can follow.
[[nodiscard]] std::string without_stop(std::string sentence);

}  // namespace takt::report
