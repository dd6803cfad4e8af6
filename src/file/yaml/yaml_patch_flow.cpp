// Lists and mappings in brackets. As long as no part is added, removed or moved, only values change. Else the
// collection is put together anew from its parts: the lead of each part (white space,
// comment lines), the part, its comma, and the comment behind that on the same line.
#include <algorithm>

#include "yaml/yaml_patch.hpp"

namespace takt::file {
namespace {

using model::Node;
using Style = Layout::Style;

/// The white space before the last line's text, with its line break.
std::string last_break(std::string_view lead) {
    const auto at = lead.rfind('\n');
    if (at == std::string_view::npos) return " ";
    return std::string(lead.substr(at > 0 && lead[at - 1] == '\r' ? at - 1 : at));
}

bool begins_line(std::string_view text) {
    return text.starts_with('\n') || text.starts_with("\r\n");
}

std::string_view without_trailing_space(std::string_view text) {
    return text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
}

}  // namespace

// Behind the comma and a comment that ends its line.
std::size_t YamlPatch::flow_tail_end(const LayoutPart& part) const {
    const auto behind = part.comma == LayoutPart::kNone ? part.end : part.comma + 1;
    const auto comment = text_.find_first_not_of(" \t", behind);
    if (comment == std::string_view::npos || text_[comment] != '#') return behind;
    const auto end = std::min(text_.find('\n', comment), text_.size());
    return end > 0 && text_[end - 1] == '\r' ? end - 1 : end;
}

std::string_view YamlPatch::flow_lead_of(const Layout& old, std::size_t index) const {
    const auto begin = index == 0 ? old.begin + 1 : flow_tail_end(old.parts[index - 1]);
    return span(begin, std::max(begin, old.parts[index].begin));
}

std::string YamlPatch::flow_lead(const Layout& old, const FlowStep& step, bool first) const {
    if (old.parts.empty()) return first ? "" : " ";
    const auto outer = flow_lead_of(old, 0);
    const auto own = step.old && *step.old > 0 ? flow_lead_of(old, *step.old) : std::string_view();
    if (first) return own.contains('#') ? std::string(outer).append(own) : std::string(outer);
    if (!own.empty()) return std::string(own);
    const auto last = old.parts.size() > 1 ? flow_lead_of(old, old.parts.size() - 1) : outer;
    return old.parts.size() > 1 && !last.contains('\n') && !last.empty() ? std::string(last)
                                                                         : last_break(last);
}

void YamlPatch::put_flow_part(const LayoutPart& part, const FlowStep& step, bool entry) {
    const auto& old = part.value;
    if (same_document(*old.node, *step.wanted)) return copy(part.begin, part.end);
    copy(part.begin, part.indicator_end);
    if (old.style == Style::absent && entry) {
        const bool colon = part.indicator_end > 0 && text_[part.indicator_end - 1] == ':';
        out_ += colon ? " " : ": ";
    } else {
        copy(part.indicator_end, old.begin);
    }
    put_value(old, *step.wanted, step.place);
}

void YamlPatch::put_flow(const Layout& old, const std::vector<FlowStep>& steps) {
    const bool entry = old.node->kind == Node::Kind::mapping;
    Origins origins;
    for (const auto& step : steps) origins.push_back(step.old);
    if (keeps_order(origins, old.parts.size())) {
        auto at = old.begin;
        for (const auto& step : steps) {
            copy(at, old.parts[*step.old].begin);
            put_flow_part(old.parts[*step.old], step, entry);
            at = old.parts[*step.old].end;
        }
        return copy(at, old.end);
    }
    std::vector<std::string> removed(old.parts.size() + 1);  // comment lines, by the part that follows them
    std::string pending;
    for (std::size_t i = 0; i < old.parts.size(); ++i) {
        if (std::ranges::find(origins, std::optional(i)) != origins.end())
            removed[i] = std::exchange(pending, {});
        else if (flow_lead_of(old, i).contains('#'))
            pending += without_trailing_space(flow_lead_of(old, i));
    }
    removed.back() = pending;

    out_ += text_[old.begin];
    bool in_comment = false;
    const auto put_space = [&](std::string_view space) {
        if (in_comment && !begins_line(space)) out_.append(style_.line_break).append(1, ' ');
        in_comment = false;
        out_ += space;
    };
    const bool comma_behind_last = !old.parts.empty() && old.parts.back().comma != LayoutPart::kNone;
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const auto& step = steps[i];
        if (step.old && !removed[*step.old].empty()) {
            put_space(removed[*step.old]);
            in_comment = true;
        }
        put_space(flow_lead(old, step, i == 0));
        const bool comma = i + 1 < steps.size() || comma_behind_last;
        if (!step.old) {
            out_.append(step.text).append(comma ? "," : "");
            continue;
        }
        const auto& part = old.parts[*step.old];
        const bool had_comma = part.comma != LayoutPart::kNone;
        put_flow_part(part, step, entry);
        if (had_comma) copy(part.end, part.comma);
        if (comma) out_ += ',';
        const auto tail = span(had_comma ? part.comma + 1 : part.end, flow_tail_end(part));
        out_ += tail;
        in_comment = tail.contains('#');
    }
    if (!removed.back().empty()) {
        put_space(removed.back());
        in_comment = true;
    }
    put_space(span(old.parts.empty() ? old.begin + 1 : flow_tail_end(old.parts.back()), old.end));
}

void YamlPatch::put_flow_mapping(const Layout& old, const Node& wanted, Object object) {
    std::vector<FlowStep> steps;
    for (const auto& [index, kept, added] : entry_steps(*old.node, wanted, object)) {
        if (!index)
            steps.push_back({.text = writer_.flow_entry(wanted, *added, object)});
        else if (kept != nullptr)
            steps.push_back({.old = index,
                             .wanted = kept,
                             .place = place_of(wanted, old.node->entries[*index].key.text, object, true)});
    }
    put_flow(old, steps);
}

void YamlPatch::put_flow_list(const Layout& old, const Node& wanted, const Place& place) {
    const auto origins = origins_of(old, wanted);
    std::vector<FlowStep> steps;
    for (std::size_t i = 0; i < origins.size(); ++i) {
        if (origins[i])
            steps.push_back({.old = origins[i],
                             .wanted = &wanted.items[i],
                             .place = {.object = place.object, .flow = true}});
        else
            steps.push_back({.text = writer_.flow_item(wanted.items[i], place.object)});
    }
    put_flow(old, steps);
}

}  // namespace takt::file
