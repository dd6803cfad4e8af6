// Lists and mappings by indentation. Each part owns its lines. The blank lines and comment lines between
// two parts are the lead of the second one. The lead of a part that is removed stays if it has a comment.
#include <algorithm>

#include "yaml/yaml_patch.hpp"

namespace takt::file {
namespace {

using model::Node;
using Style = Layout::Style;

bool has_comment(std::string_view lead) {
    return lead.contains('#');
}

/// The blank lines at the beginning.
std::string_view blank_lines(std::string_view lead) {
    const auto text = std::min(lead.find_first_not_of(" \t\r\n"), lead.size());
    const auto last = lead.substr(0, text).rfind('\n');
    return last == std::string_view::npos ? std::string_view() : lead.substr(0, last + 1);
}

}  // namespace

std::string_view YamlPatch::lead_of(const Layout& block, std::size_t index) const {
    if (index == 0) return {};
    const auto begin = block.parts[index - 1].end;
    return span(begin, std::max(begin, line_begin(text_, block.parts[index].begin)));
}

void YamlPatch::end_line() {
    if (!out_.empty() && out_.back() != '\n') out_ += style_.line_break;
}

// The first part begins where the indentation of its collection was copied already.
void YamlPatch::begin_part(bool first, std::size_t column, std::string_view lead) {
    if (first) {
        lead.remove_prefix(std::min(lead.find_first_not_of(" \t\r\n"), lead.size()));
        if (lead.empty()) return;
    } else {
        end_line();
    }
    out_ += lead;
    out_.append(column, ' ');
}

void YamlPatch::put_block_mapping(const Layout& old, const Node& wanted, Object object) {
    bool first = true;
    std::string removed;  // leads with comments
    for (const auto& [index, kept, added] : entry_steps(*old.node, wanted, object)) {
        if (!index) {
            begin_part(std::exchange(first, false), old.column, {});
            out_ += writer_.block_entry(wanted, *added, object, old.column);
        } else if (kept == nullptr) {
            if (has_comment(lead_of(old, *index))) removed += lead_of(old, *index);
        } else {
            begin_part(std::exchange(first, false), old.column,
                       std::exchange(removed, {}).append(lead_of(old, *index)));
            const auto& part = old.parts[*index];
            copy(part.begin, part.indicator_end);
            put_block_entry(part, wanted, {old.node->entries[*index].key, *kept}, object, old.column);
        }
    }
    if (removed.empty()) return;
    end_line();
    out_ += removed;
}

void YamlPatch::put_block_entry(const LayoutPart& part, const Node& owner, const Node::Entry& entry,
                                Object object, std::size_t column) {
    const auto& old = part.value;
    const auto& wanted = entry.value;
    if (same_document(*old.node, wanted)) return copy(part.indicator_end, part.end);
    const Path path(*this, entry.key.text);
    const auto place = place_of(owner, entry.key.text, object, false);
    if (stays_in_place(old, wanted)) {
        copy(part.indicator_end, old.begin);
        put_value(old, wanted, place);
        copy(old.end, part.end);
    } else if (writer_.needs_lines(wanted)) {
        put_below_key(part, writer_.lines(wanted, place.object, column));
    } else {
        put_on_key_line(part, wanted.kind == Node::Kind::null
                                  ? std::string()
                                  : writer_.value_text(owner, entry, object, false));
    }
}

// The comment lines around the parts of a block collection that is replaced, and those below it.
void YamlPatch::put_comments_of(const LayoutPart& part) {
    const auto& old = part.value;
    const auto gap_begin = line_end(text_, part.indicator_end);
    const auto gap_end = line_begin(text_, old.begin);
    if (gap_begin < gap_end && has_comment(span(gap_begin, gap_end))) copy(gap_begin, gap_end);
    for (std::size_t i = 1; i < old.parts.size(); ++i)
        if (has_comment(lead_of(old, i))) out_ += lead_of(old, i);
    copy(old.end, part.end);
}

void YamlPatch::put_on_key_line(const LayoutPart& part, std::string_view text) {
    const auto& old = part.value;
    const auto gap = span(part.indicator_end, old.begin);
    if (old.style == Style::block) {
        if (!text.empty()) out_.append(" ").append(text);
        if (line_end(text_, part.indicator_end) <= old.begin)
            copy(part.indicator_end, line_end(text_, part.indicator_end));
        end_line();
        return put_comments_of(part);
    }
    if (old.style == Style::absent)
        out_ += text.empty() ? "" : " ";
    else if (!text.empty() || has_comment(gap))
        out_ += gap;
    out_ += text;
    copy(old.end, part.end);
}

void YamlPatch::put_below_key(const LayoutPart& part, std::string_view lines) {
    const auto& old = part.value;
    const bool same_line = !span(part.indicator_end, old.begin).contains('\n');
    const bool block_scalar = old.style == Style::block_scalar;  // its header goes with it
    const auto rest = same_line ? old.end : part.indicator_end;
    if (!(same_line && (block_scalar || old.style == Style::block))) copy(rest, line_end(text_, rest));
    end_line();
    out_ += lines;
    if (old.style == Style::block)
        put_comments_of(part);
    else
        copy(std::min(line_end(text_, old.end), part.end), part.end);
}

void YamlPatch::put_block_list(const Layout& old, const Node& wanted, Object object) {
    const auto origins = origins_of(old, wanted);
    std::vector<bool> stays(old.parts.size());
    for (const auto& origin : origins)
        if (origin) stays[*origin] = true;
    std::vector<std::string> leads(old.parts.size() + 1);  // the last one: behind the list
    std::string removed;
    for (std::size_t i = 0; i < old.parts.size(); ++i) {
        const auto lead = lead_of(old, i);
        if (stays[i])
            leads[i] = std::exchange(removed, {}).append(lead);
        else if (has_comment(lead))
            removed += lead;
    }
    leads.back() = removed;
    const auto apart =
        old.parts.size() < 2 ? std::string_view() : blank_lines(lead_of(old, old.parts.size() - 1));
    std::size_t neighbour = old.parts.size() - 1;
    for (std::size_t i = 0; i < origins.size(); ++i) {
        const auto& origin = origins[i];
        const bool own = origin && (*origin > 0 || i == 0);
        begin_part(i == 0, old.column, own ? std::string_view(leads[*origin]) : apart);
        const Path path(*this, i);
        put_block_item(old, origin, wanted.items[i], object, neighbour);
        neighbour = origin.value_or(neighbour);
    }
    if (leads.back().empty()) return;
    end_line();
    out_ += leads.back();
}

void YamlPatch::put_block_item(const Layout& old, std::optional<std::size_t> origin, const Node& wanted,
                               Object object, std::size_t neighbour) {
    const Place place{.object = object};
    if (origin) {
        const auto& part = old.parts[*origin];
        const bool same = same_document(*part.value.node, wanted);
        if (same) return copy(part.begin, part.end);
        if (stays_in_place(part.value, wanted)) {
            copy(part.begin, part.value.begin);
            put_value(part.value, wanted, place);
            return copy(part.value.end, part.end);
        }
    }
    const auto& like = old.parts[neighbour];
    const auto gap = span(like.indicator_end, like.value.begin);
    const bool beside = like.value.style != Style::absent && !gap.contains('\n') && !gap.empty();
    const bool block = like.value.node->kind == Node::Kind::mapping
                           ? like.value.style == Style::block || writer_.needs_lines(wanted)
                           : writer_.is_block_item(wanted, object);
    const bool mapping = wanted.kind == Node::Kind::mapping;
    out_ += writer_.block_item(wanted, object, old.column, mapping && block,
                               beside ? std::min<std::size_t>(gap.size() + 1, 9) : 2);
}

}  // namespace takt::file
